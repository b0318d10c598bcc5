"""Tables in Markdown: texts of others stay texts."""

import re

import pytest

from eval.figures.tables import Marked, Table, code, made_by, plain

HOSTILE = (
    "<script>alert(1)</script>",
    "<img src=x onerror=alert(1)>",
    "[x](javascript:alert(1))",
    "![x](https://tracker.example/p.png)",
    "a | 0.01 | 0.01",
    "`",
    "a\\",
    "{: onclick=alert(1) }",
    "<!--",
    "*a* _b_ __c__ ~~d~~ $e$",
    "two\nlines",
    "&lt;b&gt;",
)


@pytest.mark.parametrize("text", HOSTILE)
def test_a_text_in_a_cell_has_no_meaning_in_markdown(text):
    page = Table(["agent", "score"], [[text, "1.00"]]).markdown()
    head, _, row = page.splitlines()
    assert head.count("|") == row.count("|") == 3
    assert not set(re.sub("&#[0-9]+;", "", row)) & set("<>&`*~$[]{}\\")
    assert not re.search(r"\b_|_\b", plain(text))


@pytest.mark.parametrize("text", HOSTILE)
def test_a_text_in_a_cell_is_shown_as_it_is_by_the_sites_markdown(text):
    markdown = pytest.importorskip("markdown")
    extensions = ["abbr", "attr_list", "tables", "md_in_html"]
    page = markdown.markdown(Table(["agent", "score"], [[text, "1.00"]]).markdown(), extensions=extensions)
    cells = re.findall(r"<td[^>]*>(.*?)</td>", page)
    assert len(cells) == 2 and "<" not in cells[0] and "javascript" not in re.sub(">[^<]*<", "><", page)


def test_names_with_underscores_and_texts_of_our_own_are_as_before():
    page = Table(["unmodelled_time_s"], [["refined_one_sided"], [Marked("*0 points*")], ["2 (1 … 3) %"]]).markdown()
    assert page.splitlines()[0] == "| unmodelled_time_s |"
    assert page.splitlines()[2:] == ["| refined_one_sided |", "| *0 points* |", "| 2 (1 … 3) % |"]


def test_what_a_file_says_of_its_making_stays_a_text():
    machine = {"processor": "<b>", "cores": 2, "system": "x"}
    about = {"command": "a `<i>` b", "finished": "[x](y)", "versions": {"jawenv": "1"}, "git": None, "machine": machine}
    assert made_by(about, "what") == (
        "Made by `` a `<i>` b ``, &#91;x&#93;(y): what. jawenv 1; 2 cores of &#60;b&#62;."
    )
    assert code("jawenv score refined") == "`jawenv score refined`"
