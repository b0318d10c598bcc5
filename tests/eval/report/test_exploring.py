"""The report in a browser: what is drawn, sorted, hidden, filmed and pressed."""

import pandas as pd
import pytest

from eval.commands.app import main
from eval.comparison.ranking import rank
from eval.report.page import write
from tests.browser import executable
from tests.eval.report.browser import opened
from tests.eval.studies import many_entries


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    """The report of two maneuvers that were really played."""
    executable()
    folder = tmp_path_factory.mktemp("study")
    arguments = ["--control", "targets", "--patients", "3", "--episode-s", "3", "--output", str(folder)]
    assert main(["compare", "chirp", "slow_opening", "opening_with_swings", *arguments]) == 0
    return folder / "report.html"


@pytest.fixture(scope="module")
def page(path):
    with opened(path) as page:
        yield page


@pytest.fixture(scope="module")
def narrow(path):
    with opened(path, 480, "dark") as page:
        yield page


@pytest.fixture(params=["wide and light", "narrow and dark"])
def both(request, page, narrow):
    """The report at 1,400 pixels in light, and at 480 in dark colours."""
    return page if request.param == "wide and light" else narrow


def names(page):
    return page.eval_on_selector_all("#ranking-table td.text .name", "cells => cells.map(c => c.textContent.trim())")


def test_it_is_drawn_without_a_complaint_or_the_network(path, both):
    assert both.complaints == []
    assert [url for url in both.requests if not url.startswith(("data:", "blob:"))] == [path.as_uri()]
    assert both.locator(".chart").count() == both.locator(".chart[data-ready]").count() > 12
    assert both.evaluate("document.documentElement.scrollWidth") <= both.viewport_size["width"]
    smallest = "texts => Math.min(...texts.map(text => parseFloat(getComputedStyle(text).fontSize)))"
    assert both.eval_on_selector_all(".chart svg text", smallest) >= 11.0


def test_the_first_screen_has_the_answer_its_reason_and_two_films(both):
    best = both.evaluate("report.data.entries[0].name")
    answer = both.locator("#answer .answer")
    both.evaluate("scrollTo(0, 0)")
    assert best in answer.inner_text().lower() and "3 patients" in answer.inner_text()
    assert answer.bounding_box()["y"] + answer.bounding_box()["height"] < 450
    assert "NEES" in both.inner_text("#answer .belief") and "alarm" in both.inner_text("#answer .belief")
    assert "known exactly" in both.inner_text("#answer .assumption")
    assert both.locator("#films figure b").all_text_contents() == [best, "slow opening"]
    assert both.complaints == []


def test_a_table_is_saved_in_the_units_of_its_headings(page, tmp_path):
    with page.expect_download() as saving:
        page.locator(".scroll:has(#ranking-table) + .csv").click()
    saving.value.save_as(tmp_path / "table.csv")
    table = pd.read_csv(tmp_path / "table.csv")
    assert saving.value.suggested_filename == "ranking.csv" and len(table) == 3
    assert sorted(table["maneuver"]) == sorted(names(page))
    shown = page.locator("#ranking-table tbody tr").first.locator("td").nth(12).inner_text()
    assert table["patient discomfort s per 30 s"][0] == float(shown)
    assert table["worst of the 12 sd, % median"].between(1.0, 100.0).all()


def test_the_films_stay_still_where_a_reader_wants_no_motion_and_play_in_step_until_nobody_looks(path):
    times = "films => films.map(film => film.currentTime)"
    with opened(path) as page:
        page.emulate_media(reduced_motion="reduce")
        page.reload()
        page.wait_for_function("[...document.querySelectorAll('#films video')].every(film => film.readyState > 1)")
        assert page.evaluate("[...document.querySelectorAll('#films video')].every(film => film.paused)")
        page.evaluate("document.querySelector('#films video').currentTime = 0.2")
        page.wait_for_timeout(300)
        assert page.eval_on_selector_all("#films video", times) == [0.2, 0.2]
        page.evaluate("document.querySelector('#films video').play()")
        page.wait_for_function("[...document.querySelectorAll('#films video')].every(film => film.currentTime > 0.4)")
        page.evaluate("document.getElementById('settings').scrollIntoView()")
        page.wait_for_function("[...document.querySelectorAll('#films video')].every(film => film.paused)")
        assert page.complaints == []


def test_the_navigation_stays_and_hides_no_heading(both):
    for link in both.locator("nav a").all():
        target = link.get_attribute("href")
        both.evaluate("address => { location.hash = address; }", target)
        both.wait_for_timeout(50)
        bar, heading = both.locator("nav").bounding_box(), both.locator(target).bounding_box()
        assert bar["y"] == 0
        assert heading["y"] >= bar["y"] + bar["height"] - 1 or target == "#answer"


def test_the_rest_of_many_entries_is_behind_a_click(tmp_path):
    executable()
    whole = many_entries()
    with opened(write(whole, rank(whole), tmp_path / "report.html")) as page:
        assert page.locator("#ranking-table tbody tr:visible").count() == 6
        assert page.locator("#nees .scatterlayer .trace").count() == 6
        rows = page.locator("#nees .ytick text").all_text_contents()
        assert len(rows) == 6 and rows[-1].endswith("my own")
        page.locator(".entries .all").first.click()
        assert page.locator("#nees .scatterlayer .trace").count() == 12
        page.fill("#filter", "no 9")
        assert page.locator("#ranking-table tbody tr:visible .name").all_inner_texts() == ["no 9"]
        page.fill("#filter", "")
        assert page.locator("#ranking-table tbody tr:visible").count() == 12
        assert page.complaints == []


def test_a_long_name_without_spaces_makes_no_page_wider(tmp_path):
    executable()
    made, name = many_entries(), "runs/a/rather/long/folder/whose/name/has/no/space.yaml"
    long = [table.replace({"entry": {"my_own": name}}) for table in (made.patients, made.curves)]
    entries = [
        each | ({"label": name, "spec": name} if each["label"] == "my_own" else {}) for each in made.about["entries"]
    ]
    whole = type(made)(*long, made.about | {"entries": entries})
    with opened(write(whole, rank(whole), tmp_path / "report.html"), 480) as page:
        assert page.evaluate("document.documentElement.scrollWidth") <= 480


def test_no_element_breaks_an_accessibility_rule_seriously(page):
    from axe_playwright_python.sync_playwright import Axe

    found = [rule for rule in Axe().run(page).response["violations"] if rule["impact"] in ("serious", "critical")]
    assert [(rule["id"], rule["nodes"][0]["html"][:120]) for rule in found] == []


# Headings whose largest value is the best, and those with a value that is; of all others the least is.
MOST = ("share", "mean", "against", "known", "claimed nats", "true nats", "bound nats", "sensitivity", "specificity")
NEAREST = {"NEES": 12.0, "claimed − true": 0.0, "RMSE": 1.0, "within 1": 0.6827, "within 2": 0.9545, "within 3": 0.9973}


def cells_of(column):
    return f"""table => [...table.tBodies[0].rows].map(row => row.cells[{column}])
        .map(cell => cell.dataset.v ?? cell.textContent.trim())"""


def badness(heading, cell):
    """How far a value is from the best of its column; a text as it stands."""
    try:
        value = float(cell)
    except ValueError:
        return cell
    if any(heading.startswith(name) for name in MOST):
        return -value
    return next((abs(value - best) for name, best in NEAREST.items() if heading.startswith(name)), value)


def test_the_first_click_on_any_heading_puts_the_best_first_and_the_second_last(page):
    seen = set()
    for table in page.locator("table.sortable").all():
        headings = table.locator("thead tr:last-child th")
        for column in range(headings.count()):
            button = headings.nth(column).locator("button")
            heading = " ".join(button.inner_text().split())
            headings.nth((column + 1) % headings.count()).locator("button").click()
            button.click()
            order = [badness(heading, cell) for cell in table.evaluate(cells_of(column))]
            known = [value for value in order if value == value]
            assert known == sorted(known), heading
            assert order[: len(known)] == known, f"{heading}: what has no value is last"
            button.click()
            order = [badness(heading, cell) for cell in table.evaluate(cells_of(column))]
            assert [value for value in order if value == value] == sorted(known, reverse=True), heading
            seen.add(heading)
    assert {name for name in (*MOST, *NEAREST) if not any(each.startswith(name) for each in seen)} == set()
    page.locator("#ranking-table thead tr:last-child button").first.click()


def test_the_filter_hides_rows_and_says_so(page):
    page.fill("#filter", "chi")
    assert page.locator("#ranking-table tbody tr:visible .name").all_inner_texts() == ["chirp"]
    assert page.inner_text("#count") == "1 of 3 shown"
    page.fill("#filter", "")
    assert page.locator("#ranking-table tbody tr:visible").count() == 3


def test_an_entry_is_hidden_in_every_chart(page):
    lines = "#reached_5 .scatterlayer .trace"
    assert page.locator(lines).count() == 3
    chip = page.locator('.entries button[data-entry="1"]').first
    chip.click()
    assert chip.get_attribute("aria-pressed") == "false"
    assert page.locator(lines).count() == 2
    assert page.locator("#parameter-0 .scatterlayer .trace").count() == 2
    chip.press("Enter")
    assert page.locator(lines).count() == 3


def test_one_entry_is_shown_with_its_spread_and_its_bound(page):
    page.select_option("#focus", "chirp")
    assert page.locator("#parameter-0 .scatterlayer .trace").count() == 4
    assert page.locator("#focus-note").is_visible()
    page.select_option("#focus", "")


def test_another_film_is_chosen(page):
    stage = page.locator(".stage").nth(1)
    stage.locator("select").select_option("opening_with_swings")
    first, second = page.locator(".stage video").all()
    assert first.get_attribute("src") != second.get_attribute("src")
    assert page.complaints == []


def test_on_paper_nothing_is_wider_than_the_sheet(page):
    page.evaluate("dispatchEvent(new Event('beforeprint'))")
    try:
        assert page.locator("#nees_over_time .main-svg").first.bounding_box()["width"] <= 680
    finally:
        page.evaluate("dispatchEvent(new Event('afterprint'))")
