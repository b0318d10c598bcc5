import json
import re
from html.parser import HTMLParser

import pytest

from eval.comparison.ranking import rank
from eval.report.page import render, write
from tests.eval.studies import ENTRIES, GOOD, study

CHARTS = ("information", "worst_sd", "nees", "nees_over_time", "discomfort", "reached_5")
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
    outside_scripts = re.sub(r"<script.*?</script>", "", page, flags=re.DOTALL)
    assert not re.search(r"@import|url\((?!#)", outside_scripts)
    assert page.count("plotly.js (basic - minified)") == 1
    assert len(page) < 3_000_000


def test_the_report_shows_every_entry_in_every_section(page):
    for entry in ENTRIES:
        assert page.count(entry.replace("_", " ")) >= 6
    for section in ("ranking", "time", "honesty", "comfort", "diagnosis", "settings"):
        assert f'id="{section}"' in page
    for chart in CHARTS:
        assert f'class="chart" id="{chart}"' in page


def test_the_report_says_when_the_filter_lies(page):
    assert '<span class="badge overconfident">overconfident</span>' in page
    assert "not ranked: sds are false: errors are" in page


def data_of(page):
    return json.loads(re.search(r'<script type="application/json" id="data">(.*?)</script>', page).group(1))


def test_charts_show_what_the_table_holds(made, page):
    ranking = rank(made)
    points = {trace["meta"]: trace for trace in data_of(page)["charts"]["nees"]["data"]}
    for i, row in enumerate(ranking.rows):
        assert points[i]["x"] == [pytest.approx(row["nees"].value, rel=1e-3)]
    share = data_of(page)["charts"]["reached_5"]["data"][0]
    assert share["y"][-1] == pytest.approx(100 * ranking.rows[0]["reaches_5"].value)
    assert share["x"] == sorted(share["x"])


def test_the_bound_is_drawn_where_it_is_one(made, page):
    settings = made.about["settings"] | {"reality": {"creep_share": 0.3}}
    misled = type(made)(made.patients, made.curves, made.about | {"settings": settings})
    other = render(misled, rank(misled))
    assert "bound" in data_of(page)["curves"][GOOD]["log_b/masseter_left"]
    assert "bound" not in data_of(other)["curves"][GOOD]["log_b/masseter_left"]
    assert "No bound is drawn" in other
    assert "RMSE / bound" not in other
    assert "with creep_share = 0.3, unknown to the filter" in other


def test_one_entry_and_one_patient_make_a_whole_file_and_names_are_escaped(tmp_path):
    whole = study(patients=1)
    evil = "</script><script>alert(1)</script>"
    strange = whole.about | {"command": evil}
    rows, curves = whole.of(GOOD).assign(entry=evil), whole.curves[whole.curves["entry"] == GOOD].assign(entry=evil)
    one = type(whole)(rows, curves, strange)
    path = write(one, rank(one), tmp_path / "new" / "report.html")
    text = path.read_text()
    assert "<script>alert" not in text
    assert text.rstrip().endswith("</html>")
    assert [file.name for file in path.parent.iterdir()] == ["report.html"]


@pytest.mark.parametrize(
    ("env", "number", "muscle"),
    [
        ("jawenv/JawHinge-v3", 2, "closers"),
        ("jawenv/JawSagittal-v3", 6, "masseter"),
        ("jawenv/JawSides-v3", 4, "left"),
        ("jawenv/JawPortions-v3", 24, "superficial masseter"),
    ],
)
def test_the_report_follows_the_parameters_of_the_environment(env, number, muscle):
    made = study(patients=5, env=env)
    page = render(made, rank(made))
    assert f"<title>{env}: " in page
    for words in (f"worst of the {number} sd", f"calibrated: {number}<", f"known<br>of {number}<"):
        assert words in page
    outside_scripts = re.sub(r"<script.*?</script>", "", page, flags=re.DOTALL)
    assert not re.search(r"\b(of|all|the) 12\b", outside_scripts, re.IGNORECASE)
    assert len(page) < 3_000_000
    titles = [each["title"] for each in data_of(page)["parameters"]]
    assert len(set(titles)) == number and titles[0].startswith(f"F_o of {muscle}")
