"""The page in headless Chromium: keys and sliders move the jaw, standard deviations fall, all browsers see one jaw."""

import re
import socket
import threading
import time
from contextlib import contextmanager
from types import SimpleNamespace

import numpy as np
import pytest
from axe_playwright_python.sync_playwright import Axe

from jawenv.base.errors import InputError
from jawenv.live import panels
from jawenv.live.page import Page
from jawenv.live.playback import Playback
from jawenv.live.playback_page import PlaybackPage
from jawenv.live.server import serving, url_of
from jawenv.live.session import BY_HAND, DriveSession
from jawenv.live.setup import Setup
from jawenv.recordings.files import load_record
from tests.browser import new_page

FEW_PIXELS = "/?fixedDpr=0.25"  # these browsers draw without a graphics card


@pytest.fixture
def server():
    with serving(0) as server:
        yield server


@contextmanager
def running(page):
    thread = threading.Thread(target=page.run, daemon=True)
    thread.start()
    try:
        yield page
    finally:
        page.stop()
        thread.join(10)
        assert not thread.is_alive()


@contextmanager
def looking_at(server, width=700, scheme="light", height=500):
    """A tab with what it complains of in ``complaints``."""
    tab = new_page(viewport={"width": width, "height": height}, color_scheme=scheme)
    tab.goto(url_of(server) + FEW_PIXELS)
    tab.wait_for_selector("[data-worst]", timeout=60_000)
    try:
        yield tab
    finally:
        tab.context.close()


CUT = """() => [...document.querySelectorAll("#status, #steps, #posterior, #comfort, #legend")]
  .filter((card) => card.scrollWidth > card.clientWidth).map((card) => card.id)"""


def worst(tab):
    return float(tab.get_attribute("[data-worst]", "data-worst"))


def wait_until(condition, seconds=30.0):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "it did not happen"
        time.sleep(0.05)


def test_a_screen_reader_is_told_what_each_slider_and_button_is(tmp_path, server):
    page = Page(server, Setup.of(seed=500, episode_s=600.0), tmp_path)
    with running(page), looking_at(server) as tab:
        tab.wait_for_selector("[role=slider][aria-label]:not([aria-label=''])")
        sliders = tab.locator("[role=slider]")
        names = [sliders.nth(k).get_attribute("aria-label") for k in range(sliders.count())]
        assert len(set(names)) == len(names) >= 4 and "opening" in names[0].lower()
        assert tab.locator("button:not([aria-label])", has_not_text=re.compile("[A-Za-z]")).count() == 0


def test_keys_open_the_jaw_and_every_browser_sees_the_sds_fall(tmp_path, server):
    page = Page(server, Setup.of(seed=500, episode_s=600.0), tmp_path)
    with running(page), looking_at(server) as tab, looking_at(server, 480, "dark") as other:
        before = worst(tab)
        assert page.steps == 0 and "Hold S" in tab.inner_text("#steps")
        assert tab.title() == "jawenv live" and "not a medical device" in tab.inner_text("#notice")
        assert tab.evaluate(CUT) == other.evaluate(CUT) == []
        tab.keyboard.down("KeyS")
        wait_until(lambda: page.session.steering.hand[0] > 0.4)
        tab.keyboard.up("KeyS")
        wait_until(lambda: not page._keys.take())
        held = page.session.steering.hand.copy()
        tab.keyboard.press("KeyD")
        wait_until(lambda: page.session.steering.hand[1] > held[1])
        assert page.session.steering.hand[0] == pytest.approx(held[0])
        wait_until(lambda: not page._keys.take())
        wait_until(lambda: worst(tab) < 0.7 * before and worst(other) < 0.7 * before)
        assert tab.complaints == other.complaints == []
        schemes = [each.evaluate("document.documentElement.dataset.mantineColorScheme") for each in (tab, other)]
        assert schemes == ["light", "dark"]
        assert other.evaluate("document.documentElement.scrollWidth") <= 480
        other.wait_for_selector("[role=slider][aria-label='Opening']", state="attached")
        found = Axe().run(other).response["violations"]
        assert [rule["id"] for rule in found if rule["impact"] in ("serious", "critical")] == []


def test_a_maneuver_drives_until_a_key_takes_over_and_the_end_has_a_score(tmp_path, server):
    page = Page(server, Setup.of(seed=500, episode_s=4.0), tmp_path, driver="universal")
    assert page._driver.value == "universal"
    page._pause()
    with running(page), looking_at(server, 900, "dark", height=1800) as tab:
        tab.get_by_text("Step", exact=True).click()
        wait_until(lambda: page.steps == 1)
        tab.get_by_text("Pause", exact=True).click()
        wait_until(lambda: page.steps > 20)
        tab.keyboard.press("KeyS")
        wait_until(lambda: page.session.driver == BY_HAND)
        tab.wait_for_selector("#score", timeout=60_000)
        words = tab.inner_text("#score")
        assert "universal" in words and "slow opening" in words and "you and universal" in words
        assert tab.complaints == []
        found = Axe().run(tab).response["violations"]
        assert [rule["id"] for rule in found if rule["impact"] in ("serious", "critical")] == []
        tab.get_by_text("Again", exact=True).click()
        wait_until(lambda: page.session.outcome().duration_s == 0.0)
        assert page.session.driver == BY_HAND and page._score.content == ""
    assert sorted(path.suffix for path in tmp_path.iterdir()) == [".csv", ".yaml"]


def test_one_wish_of_a_kind_waits_at_a_time(tmp_path, server):
    page = Page(server, Setup.of(seed=500, episode_s=1.0), tmp_path)
    client = SimpleNamespace(client_id=1)
    for _ in range(100):
        page._buttons_clicked("Save", client)
    page._buttons_clicked("Pause", client)
    assert len(page._wishes) == 2


def test_what_the_discomfort_was_spent_on_stays_to_be_read(tmp_path, server):
    page = Page(server, Setup.of(seed=500, episode_s=10.0), tmp_path)
    session = page.session
    while session.outcome().discomfort_s == 0.0:
        session.drive([1.0, 1.0, 1.0, 0.0])
    spent = session.shown().spent_on
    for _ in range(20):
        shown = session.drive([0.0, 0.0, 0.0, 0.0])
    assert shown.spent_on[:1] == spent[:1] and max(shown.scene.comfort.values()) < 1.0
    assert spent[0].replace("_", " ").replace("fore aft", "fore-aft") in panels.status_html(shown)


def test_a_recording_plays_in_the_same_view(tmp_path):
    with serving(0) as server:
        page = Page(server, Setup.of(seed=500, episode_s=1.0), tmp_path, driver="universal")
        while not page.session.ended:
            page.step()
    playback = Playback(load_record(tmp_path / "my_drive_1.csv"), "my_drive_1")
    with serving(0) as server:
        with running(PlaybackPage(server, playback)), looking_at(server) as tab:
            first = worst(tab)
            wait_until(lambda: worst(tab) != first)
            assert "driven by my_drive_1" in tab.inner_text("#status") and tab.complaints == []


def test_another_patient_and_a_refused_choice(tmp_path, server):
    page = Page(server, Setup.of(seed=500, episode_s=2.0), tmp_path)
    page.step()
    page._choices.fields["seed"].value = 501
    page._choices.fields["model"].value = "sides"
    page._fulfil(page._change)
    assert page.session.setup.seed == 501 and len(page._shown.scene.parameter_names) == 4
    page.step()
    page._choices.fields["model"].value = "sagittal"
    page._choices.fields["knowledge"].value = "imaged"
    page._fulfil(page._change)
    assert page.session.setup.world.model == "sides"
    assert "knowledge is not exact" in page._view._status.content


def test_a_budget_is_chosen_and_kept_and_refused_where_no_targets_are_followed(tmp_path, server):
    page = Page(server, Setup.of(seed=500, cohort="healthy", episode_s=6.0), tmp_path, driver="universal")
    assert page.session.setup.world.comfort_budget_s is None
    spent = []
    for budget_s in (0.0, 0.02):
        page._choices.fields["comfort_budget_s"].value = budget_s
        page._fulfil(page._change)
        while not page.session.ended:
            page.step()
        spent.append(page.session.outcome().discomfort_s)
    assert spent[1] < 0.5 * spent[0] and page.session.setup.world.comfort_budget_s == 0.02
    page._choices.fields["control"].value = "force"
    page._fulfil(page._change)
    assert "comfort_budget_s is 0.02" in page._view._status.content


def test_a_ghost_moves_in_step_and_comes_along_to_another_patient(tmp_path, server):
    page = Page(server, Setup.of(seed=500, episode_s=2.0), tmp_path)
    for _ in range(3):
        page.step()
    page._ghosts.value = "refined"
    page._fulfil(page._call_ghost)
    assert page._ghost.steps == 3 and page._ghost.driver == "refined"
    page.step()
    alone = DriveSession(page.session.setup)
    alone.hand_over("refined")
    for _ in range(4):
        expected = alone.drive()
    np.testing.assert_array_equal(page._ghost.shown().scene.contact_m, expected.scene.contact_m)
    assert "ghost of refined" in page._view._beside.content
    page._choices.fields["seed"].value = 501
    page._fulfil(page._change)
    assert page._ghost.setup.seed == 501 and page._ghost.steps == 0
    page._ghosts.value = "nobody"
    page._fulfil(page._call_ghost)
    assert page._ghost is None and page._view._beside.content == ""


def test_a_folder_that_cannot_be_written_is_said_on_the_page(tmp_path):
    (tmp_path / "file").write_text("")
    with serving(0) as server:
        page = Page(server, Setup.of(seed=500, episode_s=1.0), tmp_path / "file")
        while not page.session.ended:
            page.step()
        assert "cannot be made" in page._view._status.content and "universal" in page._score.content


def test_a_port_that_is_taken_is_one_line():
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        port = other.getsockname()[1]
        with pytest.raises(InputError):
            with serving(port):
                pass
    with pytest.raises(InputError):
        with serving(70000):
            pass


def test_the_page_is_of_this_machine_alone(server):
    assert url_of(server) == f"http://127.0.0.1:{server.get_port()}"
    assert server.get_host() == "127.0.0.1"
