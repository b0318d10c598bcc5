"""What the repository's host runs and asks is of this repository as it is."""

import re
import tomllib
from pathlib import Path

import pytest
import yaml

from jawenv.kernels.cache import LEVELS

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


@pytest.mark.parametrize("path", WORKFLOWS, ids=lambda path: path.stem)
def test_actions_of_others_are_pinned_by_commit(path: Path) -> None:
    used = [str(step["uses"]) for step in steps(path) if "uses" in step]
    assert used and all(re.fullmatch(r"[\w/-]+@[0-9a-f]{40}", action) for action in used)


def test_what_is_released_is_built_apart_with_pinned_tools() -> None:
    text = (ROOT / ".github/workflows/release.yml").read_text(encoding="utf-8")
    jobs = yaml.safe_load(text)["jobs"]
    (build,) = [job for job in jobs.values() if any("-m build" in str(step.get("run")) for step in job["steps"])]
    assert "permissions" not in build and not any("make test" in str(step.get("run")) for step in build["steps"])
    commands = "\n".join(str(step.get("run", "")) for step in build["steps"])
    assert "SOURCE_DATE_EPOCH=" in commands
    assert all("==" in tool for tool in re.findall(r"pip install (.+)", commands)[0].split())
    checkouts = [step for job in jobs.values() for step in job["steps"] if "checkout@" in str(step.get("uses"))]
    assert all(step["with"]["persist-credentials"] is False for step in checkouts)
    for name, job in jobs.items():
        if "id-token" in job.get("permissions", {}):
            assert all("run" not in step for step in job["steps"]), name


def test_every_python_that_is_named_is_tested() -> None:
    tested = yaml.safe_load((ROOT / ".github/workflows/test.yml").read_text(encoding="utf-8"))
    versions = tested["jobs"]["test"]["strategy"]["matrix"]["python"]
    named = [line.rsplit(" ", 1)[1] for line in PROJECT["classifiers"] if re.search(r":: 3\.\d+$", line)]
    assert versions == named == ["3.11", "3.12", "3.13"]


def test_kernels_that_are_kept_between_runs_fit_every_runner() -> None:
    job = yaml.safe_load((ROOT / ".github/workflows/test.yml").read_text(encoding="utf-8"))["jobs"]["test"]
    assert LEVELS[job["env"]["NUMBA_CPU_NAME"]] == job["env"]["NUMBA_CPU_FEATURES"]
    (kept,) = [step["with"] for step in job["steps"] if "actions/cache@" in str(step.get("uses"))]
    assert "hashFiles(" in kept["key"] and "matrix.python" in kept["key"]


def test_the_citation_has_the_version() -> None:
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert str(citation["version"]) == PROJECT["version"]
