"""Which keys are held, and what the panels say."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from jawenv.answers.tension import Tension
from jawenv.device.channels import CHANNELS
from jawenv.live import panels
from jawenv.live.jaw3d import FIRST_POSITION
from jawenv.live.keys import DRIVE_KEYS, Keys, keys_html, moved
from jawenv.live.session import DriveSession
from jawenv.live.setup import Setup
from jawenv.live.view import _fit


class Gui:
    def __init__(self):
        self.commands = {}

    def add_command(self, label, hotkey, modifier=None):
        def on_trigger(callback):
            self.commands[hotkey, modifier] = callback

        return SimpleNamespace(on_trigger=on_trigger)


@pytest.fixture
def server():
    server = SimpleNamespace(gui=Gui(), left=None)
    server.on_client_disconnect = lambda callback: setattr(server, "left", callback)
    return server


def test_a_key_is_held_until_it_is_let_go_in_that_browser(server):
    keys = Keys(server)
    first, second = SimpleNamespace(client_id=1), SimpleNamespace(client_id=2)
    server.gui.commands["1", None](first)
    server.gui.commands["1", None](second)
    server.gui.commands["1", "shift"](first)
    assert keys.take() == {"KeyW"} and keys.take() == {"KeyW"}
    server.left(second)
    assert keys.take() == set()


def test_a_key_that_was_only_tapped_counts_once(server):
    keys = Keys(server)
    client = SimpleNamespace(client_id=1)
    server.gui.commands["4", None](client)
    server.gui.commands["4", "shift"](client)
    assert keys.take() == {"KeyD"} and keys.take() == set()


def test_every_channel_has_a_key_for_either_way_and_stays_in_its_range():
    for channel in range(len(CHANNELS)):
        speeds = [speed for _, of, speed in DRIVE_KEYS.values() if of == channel]
        assert sorted(np.sign(speeds)) == [-1, 1]
    np.testing.assert_allclose(moved(np.zeros(4), {"KeyS", "KeyA"}, 0.1), [0.05, -0.15, 0, 0])
    np.testing.assert_allclose(moved(np.zeros(4), {"KeyW", "ArrowUp"}, 9.0), [0, 0, 1, 0])
    assert len(DRIVE_KEYS) <= 9 and all(code in keys_html() for code in DRIVE_KEYS)


@pytest.fixture(scope="module")
def shown():
    session = DriveSession(Setup.of(seed=500, episode_s=2.0))
    return session.drive([0.3, 0.1, 0.0, 0.0])


def test_panels_say_what_is_known_and_used(shown):
    known = int((shown.scene.belief_sd <= 0.1).sum())
    html = panels.posterior_html(shown.scene)
    assert html.count("<tr>") == 7 and "med. pterygoid L" in html and f"of 12: {known} within 10 %" in html
    comfort = panels.comfort_html(shown.scene)
    assert comfort.count("<tr>") == len(shown.scene.comfort) and "fore-aft" in comfort
    assert panels.comfort_html(replace(shown.scene, comfort={}, comfort_hard={})) == ""
    status = panels.status_html(shown, "<b>remark</b>")
    assert "driven by you" in status and "&lt;b&gt;remark" in status and "do not fit" not in status
    assert "do not fit the model" in panels.status_html(replace(shown, misfit=1.5))
    assert "0 of 6 verdicts stand" in status
    assert "4 of 6 verdicts stand" in panels.status_html(replace(shown, stands=np.arange(6) < 4))
    score = panels.score_html(
        [shown.outcome], [Tension(10.0, 3.0, 0.1, 0.2, 0.01, 0.5, "")], ["runs/live/my_drive_1.yaml"]
    )
    assert "saved: runs/live/my_drive_1.yaml" in score and "–" in score and "opened by 10 mm 3.00 ± 0.10 N" in score


@pytest.mark.parametrize(("aspect", "moved_away"), [(0.53, True), (0.6, True), (0.69, False), (1.5, False)])
def test_a_narrow_page_looks_at_the_jaw_from_farther_whenever_it_begins_as_a_wide_one(aspect, moved_away):
    told = []
    camera = SimpleNamespace(aspect=aspect, position=(3.0, 3.0, 3.0), look_at=None, on_update=told.append)
    _fit(SimpleNamespace(camera=camera))
    for _ in range(2):  # the browser may begin a second time
        camera.position = FIRST_POSITION
        told[0](camera)
        assert (camera.position != FIRST_POSITION) == moved_away
    camera.position = (1.0, 2.0, 3.0)  # where the reader has turned it
    told[0](camera)
    assert camera.position == (1.0, 2.0, 3.0)
