"""Pictures of an episode: bad scenes are refused, every quantity is seen, and no display is touched."""

import os
import subprocess
import sys

import numpy as np
import pytest

from jawenv.base.errors import InputError  # noqa: F401  (of the code below)
from jawenv.rendering import palette
from jawenv.rendering.renderer import Renderer
from jawenv.rendering.scene import Scene
from tests.rendering.jaw_scenes import COMFORT, FRONT, LIMITS, POSTERIOR, SIDE, TRACE, coloured, differ, scene


@pytest.fixture(scope="module")
def renderer():
    made = Renderer("rgb_array", 20)
    yield made
    made.close()


@pytest.fixture
def draw(renderer):
    """Draw one scene as the first of an episode."""

    def first(picture: Scene) -> np.ndarray:
        renderer.reset()
        return renderer.draw(picture)

    return first


@pytest.mark.parametrize("size", [(1280, 720), (640, 480), (480, 270)])
def test_picture_is_a_fresh_array_of_the_asked_size(size):
    renderer = Renderer("rgb_array", 20, size)
    first = renderer.draw(scene())
    kept = first.copy()
    second = renderer.draw(scene(opening=0.3))
    assert first.shape == (size[1], size[0], 3) and first.dtype == np.uint8
    assert first.flags.writeable and first.flags.c_contiguous
    assert (first == kept).all() and (first != second).any()


def test_the_same_scenes_give_the_same_pixels():
    pictures = []
    for _ in range(2):
        renderer = Renderer("rgb_array", 20)
        renderer.draw(scene(time_s=0.0))
        pictures.append(renderer.draw(scene(opening=0.2, time_s=1.0)))
        renderer.close()
    assert (pictures[0] == pictures[1]).all()


def test_a_scene_leaves_nothing_behind(draw):
    before = draw(scene())
    draw(scene(opening=0.4, yaw=0.1, sd=0.01, governor=1.0, truth=None, title="Another"))
    assert (draw(scene()) == before).all()


def test_the_chin_goes_down_when_the_jaw_opens(draw):
    def chin(picture: np.ndarray) -> int:
        bone = np.abs(picture[SIDE].astype(int) - palette.BONE_LINE).max(axis=-1) < 40
        return int(np.flatnonzero(bone.sum(axis=1) > 2).max())

    heights = [chin(draw(scene(opening=angle))) for angle in (0.0, 0.1, 0.2, 0.3)]
    assert heights == sorted(set(heights))


def test_yaw_to_the_left_moves_the_jaw_to_the_right_of_the_front_view(draw):
    def middle(picture: np.ndarray) -> float:
        """Mean column of the mouthpiece, the only blue thing between the teeth."""
        teeth = picture[FRONT][200:330].astype(int)
        return float(np.flatnonzero((teeth[..., 2] - teeth[..., 0] > 15).any(axis=0)).mean())

    muscles_without_blue = {"sd": 0.5, "opening": 0.25}
    left, straight, right = (middle(draw(scene(yaw=yaw, **muscles_without_blue))) for yaw in (0.1, 0.0, -0.1))
    assert right < straight < left


def test_knowledge_changes_muscles_and_bars(draw):
    vague, known = draw(scene(sd=0.5)), draw(scene(sd=0.01))
    assert coloured(vague, POSTERIOR, palette.knowledge(0.5)) > 500
    assert coloured(known, POSTERIOR, palette.knowledge(0.01)) > 500
    assert coloured(known, POSTERIOR, palette.knowledge(0.5)) == 0
    assert coloured(known, SIDE, palette.knowledge(0.01)) > 100
    assert coloured(vague, SIDE, palette.knowledge(0.01)) == 0


def test_a_tense_muscle_is_drawn_wider(draw):
    slack, tense = (draw(scene(muscle_tension_N=np.full(6, tension))) for tension in (0.2, 20.0))
    colour = palette.knowledge(0.2)
    assert coloured(tense, FRONT, colour) > 1.3 * coloured(slack, FRONT, colour)


def test_truth_may_be_hidden(draw):
    assert differ(draw(scene()), draw(scene(truth=None)), POSTERIOR) > 100


@pytest.mark.parametrize(("used", "colour"), [(0.5, palette.GOOD), (1.1, palette.WARN), (1.4, palette.ALARM)])
def test_comfort_bars_are_green_amber_or_red(draw, used, colour):
    picture = draw(scene(comfort=dict.fromkeys(LIMITS, 0.0) | {"side": used}))
    other = draw(scene(comfort=dict.fromkeys(LIMITS, 0.0)))
    assert coloured(picture, COMFORT, colour) > coloured(other, COMFORT, colour) + 100


def test_trace_grows_and_is_cleared_by_reset(renderer):
    renderer.reset()
    first = renderer.draw(scene(time_s=0.0))
    for step in range(1, 40):
        later = renderer.draw(scene(opening=0.005 * step, time_s=0.5 * step))
    area = palette.mix(palette.ACCENT, palette.CARD, 0.86)
    assert coloured(first, TRACE, area) == 0
    assert coloured(later, TRACE, area) > 1000
    renderer.reset()
    assert (renderer.draw(scene(time_s=0.0)) == first).all()


def test_time_that_goes_back_replaces_the_trace(renderer):
    renderer.reset()
    first = renderer.draw(scene(time_s=0.0))
    renderer.draw(scene(time_s=5.0))
    assert (renderer.draw(scene(time_s=0.0)) == first).all()


@pytest.mark.parametrize("force", [(0, 0, 0), (30, 0, 0), (-30, 0, 0), (0, 60, 0), (0, 0, 60), (0, 0, -300)])
def test_any_force_can_be_drawn(draw, force):
    assert draw(scene(mouthpiece_force_N=np.array(force, dtype=float))).shape == (720, 1280, 3)


def test_extreme_beliefs_stay_inside_their_columns(draw):
    """A filter that diverges is drawn at the end of the scale, not across the neighbouring card."""
    mild, wild = draw(scene()), draw(scene(belief_mean=np.tile([40.0, -40.0], 6), sd=1e-6))
    assert differ(mild, wild, np.s_[60:500, 1268:1280]) == 0
    assert differ(mild, wild, np.s_[60:500, 800:812]) == 0


def test_closing_twice_and_drawing_again():
    renderer = Renderer("rgb_array", 20)
    renderer.close()
    first = renderer.draw(scene())
    renderer.close()
    renderer.close()
    assert (renderer.draw(scene()) == first).all()


def in_new_process(code: str, **environment: str) -> str:
    """Run code in a process without display; `environment` is added to what is needed to start Python."""
    kept = {key: os.environ[key] for key in ("PATH", "HOME", "LD_LIBRARY_PATH") if key in os.environ}
    here = os.path.dirname(os.path.abspath(__file__))
    root = os.path.dirname(os.path.dirname(here))
    setup = f"import sys; sys.path[:0] = [{root!r}]; sys.dont_write_bytecode = True\n"
    setup += "import importlib.util as u; spec = u.spec_from_file_location('scenes', " + repr(__file__) + ")\n"
    setup += "scenes = u.module_from_spec(spec); spec.loader.exec_module(scenes)\n"
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", setup + code],
        env=kept | environment,
        capture_output=True,
        text=True,
        timeout=600,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.parametrize("driver", [None, "dummy"])
def test_off_screen_needs_no_display_opens_no_window_and_prints_nothing(driver):
    environment = {} if driver is None else {"SDL_VIDEODRIVER": driver}
    code = (
        "assert 'pygame' not in sys.modules\n"
        "picture = scenes.Renderer('rgb_array', 20).draw(scenes.scene())\n"
        "import pygame\n"
        "assert picture.std() > 10\n"
        "assert not pygame.display.get_init() and pygame.display.get_surface() is None\n"
    )
    assert in_new_process(code, **environment) == ""


def test_importing_jawenv_does_not_import_pygame():
    assert in_new_process("import jawenv; assert not any(m.split('.')[0] == 'pygame' for m in sys.modules)") == ""


def test_window_shows_the_picture_survives_being_closed_and_can_be_opened_again():
    code = (
        "renderer = scenes.Renderer('human', 1000)\n"
        "renderer.show(scenes.scene(time_s=0.0))\n"
        "import pygame\n"
        "shown = pygame.surfarray.array3d(pygame.display.get_surface()).swapaxes(0, 1)\n"
        "assert (shown == scenes.Renderer('rgb_array', 20).draw(scenes.scene(time_s=0.0))).all()\n"
        "pygame.event.post(pygame.event.Event(pygame.QUIT))\n"
        "for step in range(3): renderer.show(scenes.scene(time_s=1.0 + step))\n"
        "assert not pygame.display.get_init()\n"
        "renderer.close(); renderer.close()\n"
        "renderer.show(scenes.scene()); assert pygame.display.get_surface().get_size() == (1280, 720)\n"
        "renderer.close()\n"
    )
    assert in_new_process(code, SDL_VIDEODRIVER="dummy") == ""


def test_window_without_display_is_refused_with_the_remedy():
    code = "try: scenes.Renderer('human', 20).show(scenes.scene())\nexcept scenes.InputError as error: print(error)\n"
    said = in_new_process(code, SDL_VIDEODRIVER="no-such-driver")
    assert said.startswith("render_mode: 'human' needs a display (") and said.count("\n") == 1
    assert "use 'rgb_array'" in said
