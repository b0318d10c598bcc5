"""What docs/environment.md tabulates is what the code does, and links lead somewhere."""

import re
from pathlib import Path

import pytest

import jawenv
from jawenv.controls import CONTROLS
from jawenv.device.comfort import COMFORT_LIMITS
from jawenv.envs.observation import OBSERVATION_LAYOUT

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
TEXT = (ROOT / "docs" / "environment.md").read_text(encoding="utf-8")


def table(heading: str) -> list[list[str]]:
    """Cells of the rows of the first table that follows a heading."""
    lines = TEXT.split(f"\n## {heading}\n")[1].splitlines()
    start = next(i for i, line in enumerate(lines) if line.startswith("|"))
    rows = []
    for line in lines[start + 2 :]:
        if not line.startswith("|"):
            break
        rows.append([cell.strip() for cell in line.strip("|").split("|")])
    return rows


def named(cell: str) -> list[str]:
    return re.findall(r"`([^`]+)`", cell)


def test_what_an_action_means() -> None:
    stated = {named(row[0])[0].strip('"'): row[1].removesuffix(", see below") for row in table("Action")}
    assert stated == {name: mode.full_action for name, mode in CONTROLS.items()}


def test_observation() -> None:
    stated = {}
    for indices, name, _ in table("Observation"):
        first, _, last = indices.partition("–")
        stated[named(name)[0]] = slice(int(first), int(last or first) + 1)
    assert stated == OBSERVATION_LAYOUT


def test_comfort_limits() -> None:
    rows = table("Comfort")
    assert tuple(named(row[0])[0] for row in rows) == COMFORT_LIMITS
    hard = [getattr(jawenv.Comfort(), f"{name}_hard") for name in COMFORT_LIMITS]
    assert [float(row[3]) for row in rows] == hard


def rows_of(text: str) -> list[list[str]]:
    """Cells of the first table of a text."""
    lines = text[text.index("\n|") :].strip().splitlines()
    ends = next((i for i, line in enumerate(lines) if not line.startswith("|")), len(lines))
    return [[cell.strip(" *`") for cell in line.strip("|").split("|")] for line in lines[:ends]]


def test_readmes_seconds_are_those_of_the_table() -> None:
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    study = (ROOT / "docs" / "tables" / "kept_budget.md").read_text(encoding="utf-8")
    (heading, _, *rows), said = rows_of(readme.split("## Results")[1]), readme.split("--cohorts ")[1].split("\n")[0]
    for cohort, (_, *seconds) in zip(said.split(), rows, strict=True):
        names, _, *entries = rows_of(study.split(f"**{cohort}**")[1])
        of = {row[0]: f"{float(row[names.index('s to 5 %')]):.1f}" for row in entries}
        assert seconds == [of[entry.replace("slow opening", "slow_opening")] for entry in heading[1:]], cohort
    paper = " ".join((ROOT / "paper" / "paper.md").read_text(encoding="utf-8").split())
    policy, replay, searched, random, slow = seconds
    assert (
        f"needs {slow} s until" in paper and f"random motion {random} s and a searched movement {searched} s" in paper
    )
    assert f"needs {policy} s, and its own replay {replay} s" in paper


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_lead_somewhere(page: Path) -> None:
    for target in re.findall(r"\]\(([^)#:]+)(?:#[^)]*)?\)", page.read_text(encoding="utf-8")):
        assert (page.parent / target).exists(), f"{page.name} links to {target}"
