import re
import xml.etree.ElementTree as ET
from html.parser import HTMLParser

import pytest

from eval.comparison.ranking import rank
from eval.report import figures, svg
from eval.report.page import render, write
from tests.eval.studies import BOASTFUL, ENTRIES, GOOD, study

FIGURES = ("overview", "differences", "sd_over_time", "time_to_target", "calibration", "nees_over_time", "discomfort")
VOID = {"meta", "br", "link", "img", "input", "hr"}


class Balance(HTMLParser):
    """Checks that every element that is opened is closed, and gathers ids and addresses."""

    def __init__(self):
        super().__init__()
        self.open, self.ids, self.addresses = [], [], []

    def handle_starttag(self, tag, attrs):
        if tag not in VOID:
            self.open.append(tag)
        for key, value in attrs:
            if key == "id":
                self.ids.append(value)
            if key in ("src", "href", "xlink:href"):
                self.addresses.append(value)

    def handle_startendtag(self, tag, attrs):
        self.handle_starttag(tag, attrs)
        if tag not in VOID:
            self.open.pop()

    def handle_endtag(self, tag):
        assert self.open.pop() == tag


@pytest.fixture(scope="module")
def made():
    return study(patients=12)


@pytest.fixture(scope="module")
def page(made):
    return render(made, rank(made))


def test_the_report_is_one_whole_page_without_the_network(page):
    parser = Balance()
    parser.feed(page)
    assert parser.open == []
    assert len(parser.ids) == len(set(parser.ids))
    assert all(address.startswith("#") for address in parser.addresses)
    assert {address[1:] for address in parser.addresses} <= set(parser.ids)
    assert not re.search(r"@import|url\((?!#)", page)
    assert len(page) < 6_000_000


def test_the_report_shows_every_entry_in_every_section(page):
    for entry in ENTRIES:
        assert page.count(entry.replace("_", " ")) >= 6
    for section in ("ranking", "time", "honesty", "comfort", "diagnosis", "settings"):
        assert f'id="{section}"' in page
    assert page.count("<svg") == len(FIGURES) + len(ENTRIES)


def test_the_report_says_when_the_filter_lies(page):
    assert "Overconfident: boastful" in page
    assert '<span class="badge overconfident">overconfident</span>' in page


def test_one_entry_and_one_patient_make_a_whole_file_and_names_are_escaped(tmp_path):
    whole = study(patients=1)
    strange = whole.about | {"command": "<script>alert(1)</script>"}
    one = type(whole)(whole.of(GOOD), whole.curves[whole.curves["entry"] == GOOD], strange)
    path = write(one, rank(one), tmp_path / "new" / "report.html")
    text = path.read_text()
    assert "One patient only" in text
    assert "<script>" not in text
    assert text.rstrip().endswith("</html>")
    assert [file.name for file in path.parent.iterdir()] == ["report.html"]


@pytest.mark.parametrize("name", FIGURES)
def test_every_figure_is_valid_svg_in_the_colours_of_the_page(made, name):
    text = svg.inline(getattr(figures, name)(made, rank(made)), name, "a <label>")
    ET.fromstring(text)
    assert "currentColor" in text
    assert "<script" not in text


@pytest.mark.parametrize(
    ("env", "number", "first"),
    [
        ("jawenv/JawHinge-v1", 2, "closers"),
        ("jawenv/JawSagittal-v1", 6, "masseter"),
        ("jawenv/JawSides-v1", 4, "$F_o$ left"),
        ("jawenv/JawPortions-v1", 24, "superficial masseter"),
    ],
)
def test_the_report_follows_the_parameters_of_the_environment(env, number, first):
    made = study(patients=5, env=env)
    page = render(made, rank(made))
    assert f"<title>{env}: " in page
    assert f"The {number} parameters of {env} are identified best by good one." in page
    for words in (f"worst of the {number} sd", f"honest: {number})", f"known<br>of {number}<"):
        assert words in page
    assert not re.search(r"\b(of|all|the) 12\b", page, re.IGNORECASE)
    assert len(page) < 6_000_000
    panels = figures.sd_of_entry(made, GOOD).axes
    assert len({axes.get_title(loc="left") for axes in panels}) == number
    assert panels[0].get_title(loc="left").startswith(first)


def test_curves_show_what_the_table_holds(made):
    grid = figures.sd_of_entry(made, BOASTFUL).axes
    assert len(grid) == 12
    titles = [axes.get_title(loc="left") for axes in grid]
    assert titles[0].startswith("masseter")
    last = made.curves[(made.curves["entry"] == BOASTFUL) & (made.curves["quantity"] == "sd/log_F_o/masseter_left")]
    assert grid[0].lines[0].get_ydata()[-1] == last["centre"].iloc[-1]
