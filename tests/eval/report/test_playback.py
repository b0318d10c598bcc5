"""The page draws a jaw as the films do."""

import json

import numpy as np
import pytest
from PIL import Image

from eval.comparison.motion import beginning, frame_of
from eval.comparison.ranking import rank
from eval.report.page import write
from eval.report.playback import legend
from jawenv.rendering import Renderer, palette
from tests.browser import executable
from tests.eval.report.browser import opened
from tests.eval.studies import GOOD, study
from tests.rendering.jaw_scenes import scene

VIEWS = {"side": (16, 88), "front": (414, 88)}  # left upper corners in the environment's picture
WIDTH, HEIGHT = 382, 384
ALIKE = 24
"""Of 255: what antialiasing and rounding make."""


@pytest.fixture(scope="module")
def shown():
    return scene(opening=0.2, yaw=0.03, sd=0.04)


@pytest.fixture(scope="module")
def page(shown, tmp_path_factory):
    executable()
    made = study(patients=3)
    motion = beginning(shown, "targets") | {"frames": {}}
    motion["frames"] = {name: [value, value] for name, value in frame_of(shown, np.zeros(4)).items()}
    motion["frames"]["time_s"] = [0.0, 1.0]
    whole = type(made)(made.patients, made.curves, made.about, {GOOD: motion})
    with opened(write(whole, rank(whole), tmp_path_factory.mktemp("page") / "report.html")) as page:
        yield page


@pytest.mark.parametrize("view", VIEWS)
def test_the_pages_picture_is_that_of_the_film(page, shown, view, tmp_path):
    page.evaluate(
        """([name, entry, size]) => {
          const canvas = Object.assign(document.createElement("canvas"), { id: `own-${name}` });
          const [width, height] = [`${size}px`, `${size}px`];
          Object.assign(canvas.style, { width, height, position: "fixed", left: 0, top: 0, zIndex: 9 });
          canvas.style.background = "#fff";
          document.body.append(canvas);
          const motion = report.data.playback.motions[entry];
          jaw.draw(canvas, name, motion, jaw.frameAt(motion, 0));
        }""",
        [view, GOOD, HEIGHT],
    )
    page.locator(f"#own-{view}").screenshot(path=tmp_path / "own.png")
    left, top = VIEWS[view]
    film = Renderer("rgb_array", 20).draw(shown)[top : top + HEIGHT, left : left + WIDTH].astype(int)
    own = np.asarray(Image.open(tmp_path / "own.png").convert("RGB")).astype(int)[:, :WIDTH]
    alike = (np.abs(film - own).max(axis=-1) < ALIKE)[60:300]  # between the faded top and the words below
    assert alike.mean() > 0.9, (~alike).mean()
    blue = np.array(palette.knowledge(0.04))
    places = [np.argwhere(np.abs(picture[60:300] - blue).max(axis=-1) < ALIKE) for picture in (film, own)]
    assert len(places[0]) > 300 and np.abs(places[0].mean(axis=0) - places[1].mean(axis=0)).max() < 10.0


def test_the_legend_has_the_colours_of_the_renderer():
    found = legend()
    assert found["stops"][0] == (0.0, f"rgb({', '.join(map(str, palette.knowledge(0.5)))})")
    assert [sd for _, sd in found["sds"]] == [50.0, 20.0, 10.0, 5.0, 2.0, 1.0]
    widths = [width for _, width in found["tensions"]]
    assert widths == sorted(widths)
    assert json.dumps(found)
