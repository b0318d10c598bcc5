"""What the repository's host runs and asks is of this repository as it is."""

import re
import tomllib
from importlib import import_module
from pathlib import Path

import pytest
import yaml

import jawenv

ROOT = Path(__file__).parents[2]
WORKFLOWS = sorted((ROOT / ".github" / "workflows").glob("*.yml"))
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]


def steps(path: Path) -> list[dict[str, object]]:
    jobs = yaml.safe_load(path.read_text(encoding="utf-8"))["jobs"]
    return [step for job in jobs.values() for step in job["steps"]]


@pytest.mark.parametrize("path", WORKFLOWS, ids=lambda path: path.stem)
def test_a_workflow_makes_what_there_is_to_make_and_may_only_read(path: Path) -> None:
    targets = set(re.findall(r"^([a-z]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), flags=re.M))
    made = {target for step in steps(path) for target in re.findall(r"\bmake (\w+)", str(step.get("run", "")))}
    assert made and made <= targets
    assert yaml.safe_load(path.read_text(encoding="utf-8"))["permissions"] == {"contents": "read"}


def test_every_python_that_is_named_is_tested() -> None:
    tested = yaml.safe_load((ROOT / ".github/workflows/test.yml").read_text(encoding="utf-8"))
    versions = tested["jobs"]["test"]["strategy"]["matrix"]["python"]
    named = [line.rsplit(" ", 1)[1] for line in PROJECT["classifiers"] if re.search(r":: 3\.\d+$", line)]
    assert versions == named == ["3.11", "3.12", "3.13"]


def test_the_citation_has_the_version() -> None:
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert str(citation["version"]) == PROJECT["version"]


@pytest.mark.parametrize("name", ["bug.yml", "idea.yml"])
def test_forms_ask_something_of_each_field_once(name: str) -> None:
    form = yaml.safe_load((ROOT / ".github" / "ISSUE_TEMPLATE" / name).read_text(encoding="utf-8"))
    fields = [field["id"] for field in form["body"]]
    assert form["name"] and form["description"] and len(set(fields)) == len(fields) > 0


def test_public_modules_exist() -> None:
    page = (ROOT / "docs" / "environment.md").read_text(encoding="utf-8")
    policy = page.split("\n## What stays as it is\n")[1]
    names = [name for name in re.findall(r"`(jawenv(?:\.[a-z]+)+)`", policy)]
    assert len(names) == 8
    for name in names:
        assert import_module(name).__doc__
    assert all(hasattr(jawenv, name) for name in jawenv.__all__)


@pytest.mark.parametrize("page", ["CONTRIBUTING.md", "SECURITY.md", ".github/pull_request_template.md"])
def test_files_that_the_pages_name_exist(page: str) -> None:
    text = (ROOT / page).read_text(encoding="utf-8")
    named = re.findall(r"`((?:jawenv|agents|tests|docs)/[\w/.]+)`", text)
    links = [link.split("#")[0] for link in re.findall(r"\]\(([^)]+)\)", text)]
    for name in named + links:
        assert (ROOT / name).exists(), name
