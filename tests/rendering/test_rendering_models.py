"""Pictures of every model of the ladder: each can be drawn, filmed and read."""

import gymnasium as gym
import numpy as np
import pytest

import jawenv  # noqa: F401  (registers the environments)
from jawenv.envs.shown_world import build_scene, moment_of
from jawenv.ladder import MODELS
from jawenv.rendering import palette
from jawenv.rendering.canvas import Canvas
from jawenv.rendering.film import JawRenderer
from jawenv.rendering.frame import CARDS
from jawenv.rendering.posterior import lay_out
from jawenv.rendering.renderer import Renderer
from tests.rendering import jaw_scenes as scenes

models = pytest.mark.parametrize("model", MODELS)
TITLE_BAND = (0.0, 0.0, 1280.0, 54.0)
OPENING = np.array([0.6, 0.6, 0.0, 0.0], dtype=np.float32)


def written(canvas: Canvas) -> list[tuple[float, float, float, float]]:
    """Left, top, right and bottom of the ink of every text in the last picture."""
    rects = []
    for image, (x, y) in canvas._texts:
        ink = image.get_bounding_rect()
        if ink.width:
            rects.append((x + ink.left, y + ink.top, x + ink.right, y + ink.bottom))
    return rects


def inside(rect: tuple[float, ...], box: tuple[float, ...]) -> bool:
    x, y, width, height = box
    return rect[0] >= x and rect[1] >= y and rect[2] <= x + width and rect[3] <= y + height


def overlap(one: tuple[float, ...], other: tuple[float, ...]) -> bool:
    return one[0] < other[2] and other[0] < one[2] and one[1] < other[3] and other[1] < one[3]


@models
@pytest.mark.parametrize(
    "moment",
    [{"opening": 0.0}, {"opening": 0.3, "yaw": 0.06}, {"opening": 0.35, "sd": 0.01}, {"lift_m": -1e-3, "sd": 0.7}],
)
def test_every_text_stays_in_its_panel_and_covers_no_other(model, moment):
    plane = model in ("hinge", "sagittal")
    renderer = Renderer("rgb_array", 20)
    renderer.draw(scenes.scene(model=model, **({**moment, "yaw": 0.0} if plane else moment)))
    rects = written(renderer._frame._canvas)
    assert len(rects) > 60
    for rect in rects:
        assert any(inside(rect, box) for box in (*CARDS, TITLE_BAND)), rect
    for i, rect in enumerate(rects):
        assert [other for other in rects[:i] if overlap(rect, other)] == [], rect


@models
@pytest.mark.parametrize("lift_m", [0.0, -1e-3])
def test_no_text_of_a_film_covers_another(model, lift_m):
    yaw = 0.0 if model in ("hinge", "sagittal") else 0.06
    renderer = JawRenderer()
    renderer.draw(scenes.scene(model=model, opening=0.3, yaw=yaw, lift_m=lift_m))
    rects = written(renderer._canvas)
    assert len(rects) >= 5
    for i, rect in enumerate(rects):
        assert inside(rect, (0, 0, 640, renderer.height)), rect
        assert [other for other in rects[:i] if overlap(rect, other)] == [], rect


@models
def test_every_parameter_has_a_row_inside_the_panel(model):
    box = CARDS[2]
    layout = lay_out(box, scenes.scene(model=model))
    rows = [row for block in layout.blocks for row in block.rows]
    assert 2 * len(rows) == len(MODELS[model].muscles.parameter_names)
    tops = sorted(row.middle - row.height / 2 for row in rows)
    assert tops[0] >= box[1] + 60 and tops[-1] + rows[0].height <= box[1] + box[3] - 30
    assert np.diff(tops).min(initial=np.inf) >= rows[0].height - 1e-9
    assert layout.columns.sd.left + layout.columns.sd.width < box[0] + box[2] - 40


@models
def test_a_jaw_that_opens_looks_different_in_both_views(model):
    renderer = Renderer("rgb_array", 20)
    closed, opened = (renderer.draw(scenes.scene(model=model, opening=angle)) for angle in (0.0, 0.3))
    assert closed.shape == (720, 1280, 3) and closed.dtype == np.uint8
    for part in (scenes.SIDE, scenes.FRONT):
        assert scenes.differ(closed, opened, part) > 5000


def test_a_lifted_condyle_is_told_from_a_pressed_one():
    pressed, lifted = (scenes.scene(model="sagittal", lift_m=lift) for lift in (0.1e-3, -1e-3))
    assert (pressed.condyle_gap_m < 0).all() and lifted.condyle_gap_m == pytest.approx(1e-3, abs=2e-5)
    renderer = Renderer("rgb_array", 20)
    one, other = renderer.draw(pressed), renderer.draw(lifted)
    ink = palette.mix(palette.GOOD, palette.INK, 0.2)
    part = np.s_[60:270, 20:794]
    assert scenes.coloured(one, part, ink) > 20 and scenes.coloured(other, part, ink) == 0


@models
def test_every_environment_renders(model):
    env = gym.make(MODELS[model].env_id, render_mode="rgb_array", control="trajectory", episode_s=1.0)
    env.reset(seed=3)
    rest, done = env.unwrapped.render(), False
    while not done:
        _, _, terminated, truncated, _ = env.step(OPENING)
        done = terminated or truncated
    opened = env.unwrapped.render()
    env.close()
    assert rest.shape == opened.shape == (720, 1280, 3) and rest.dtype == np.uint8
    assert scenes.differ(rest, opened, scenes.SIDE) > 2000


def test_the_trace_holds_steps_that_were_not_drawn_and_the_title_names_the_cohort():
    env = gym.make("jawenv/Jaw-v3", render_mode="rgb_array", cohort="severe", episode_s=2.0, control="force").unwrapped
    env.reset(seed=0)
    for _ in range(7):
        env.step(OPENING)
    env.render()
    renderer = env._renderer
    times = [moment[0] for moment in renderer._trace]
    np.testing.assert_allclose(times, 0.05 * np.arange(8), atol=1e-12)
    assert build_scene(env.simulation).title == "Jaw, severe patient, force control"
    assert build_scene(env.simulation).moment == pytest.approx(moment_of(env.simulation))
    env.reset()
    assert len(renderer._trace) == 1


def test_a_governor_that_acts_all_the_time_is_drawn():
    env = gym.make("jawenv/Jaw-v3").unwrapped
    env.reset(seed=0)
    env.simulation.worlds["truth"]["governor"] = np.nextafter(1.0, 2.0)  # as a sum of shares rounds
    assert build_scene(env.simulation).governor == 1.0
