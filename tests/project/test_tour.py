"""The page to send a link to opens from disk, with all that it shows in one file."""

from pathlib import Path

from axe_playwright_python.sync_playwright import Axe

from tests.browser import new_page

ROOT = Path(__file__).parents[2]


def test_the_tour_opens_from_disk_and_asks_for_nothing_else(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(str(ROOT / "docs" / "site"))
    import tour

    monkeypatch.setattr(tour, "COHORT", "trismus")  # whose filter other tests compile too
    file = tmp_path / "tour.html"
    file.write_text(tour.tour(1.0, tmp_path / "kept"), encoding="utf-8")
    assert file.stat().st_size < 5e6
    tab = new_page(viewport={"width": 480, "height": 800}, color_scheme="dark")
    tab.goto(file.as_uri())
    drives, patient = tab.main_frame.child_frames
    drives.wait_for_selector("canvas")
    assert drives.evaluate("window.__VISER_EMBED_CONFIG__.darkMode") is True
    assert "Masseter" in patient.inner_text("body")
    titles = [tab.inner_text(f"#titles div:nth-child({i})").splitlines() for i in (1, 2, 3)]
    assert [title for title, _ in titles] == list(tour.DRIVERS.values())
    assert {tour.clock(float("inf")), titles[0][1]} == {"a verdict is open at the end"}  # of one second
    assert tour.clock(1.42) == "all six verdicts stand after 1.4 s"
    assert tab.evaluate("document.documentElement.scrollWidth") <= 480
    tab.wait_for_timeout(1000)  # names of the player's fields come twice a second
    for frame in (tab.main_frame, drives, patient):
        found = Axe().run(frame, options={"iframes": False}).response["violations"]
        assert [rule["id"] for rule in found if rule["impact"] in ("serious", "critical")] == []
    assert tab.requests == [file.as_uri()] and tab.complaints == []
    tab.context.close()
