"""pyproject.toml names what the code imports, and constraints.txt pins what it names."""

import ast
import re
import sys
import tomllib
from importlib.metadata import packages_distributions
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

ROOT = Path(__file__).parents[2]


def pins() -> dict[str, str]:
    lines = (ROOT / "constraints.txt").read_text(encoding="utf-8").splitlines()
    found = {}
    for line in lines:
        if not line.startswith("#"):
            match = re.fullmatch(r"([\w.-]+)==([\w.!]+)", line)
            assert match, f"{line!r} is not of the form name==version, without path, URL or local suffix"
            found[canonicalize_name(match[1])] = match[2]
    return found


def requirements(*names: str) -> list[Requirement]:
    """What jawenv needs, and its extras and the groups of these names."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    parts = project["project"]["optional-dependencies"] | project["dependency-groups"]
    needed = [Requirement(line) for line in project["project"]["dependencies"]]
    pending = list(names)
    while pending:
        for line in parts[pending.pop()]:
            if isinstance(line, dict):
                pending.append(line["include-group"])
            elif (requirement := Requirement(line)).name == "jawenv":  # an extra that holds others
                pending += requirement.extras
            else:
                needed.append(requirement)
    return needed


def imported(folder: Path) -> set[str]:
    """Top-level names that the modules of a folder import, also inside functions."""
    found = set()
    for path in folder.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import):
                found |= {alias.name.split(".")[0] for alias in node.names}
            elif isinstance(node, ast.ImportFrom) and node.level == 0 and node.module:
                found.add(node.module.split(".")[0])
    return found - set(sys.stdlib_module_names)


def test_numba_is_bounded_by_its_next_minor_version() -> None:
    """Private parts of it are changed, which the next one may move."""
    (numba,) = (requirement for requirement in requirements() if requirement.name == "numba")
    major, minor = map(int, pins()["numba"].split(".")[:2])
    assert f"{major}.{minor}.99" in numba.specifier
    assert f"{major}.{minor + 1}.0" not in numba.specifier


def test_every_requirement_is_pinned_within_its_range() -> None:
    pinned = pins()
    for requirement in requirements("all", "sb3", "train", "eval", "notebooks", "docs", "foreign", "sbi", "dev"):
        version = pinned.get(canonicalize_name(requirement.name))
        assert version is not None, f"{requirement.name} is not in constraints.txt"
        assert version in requirement.specifier, f"{requirement} does not allow {version}"


@pytest.mark.parametrize(
    ("folder", "own", "extras"),
    [
        # pyyaml and pyarrow only to read such a file; jawenv says so when they are missing. rich only in
        # jawenv.base.progress, for the commands, which bring it. pandas only where it is installed: jawenv.compare.
        ("jawenv", {"jawenv", "yaml", "pyarrow", "rich", "pandas"}, ["all", "sb3"]),
        ("agents", {"jawenv", "agents"}, ["all", "train"]),
        ("training", {"jawenv", "agents", "training"}, ["all", "train"]),
        ("eval", {"jawenv", "agents", "training", "eval", "examples"}, ["all", "train", "eval", "sbi"]),
        ("research", {"jawenv", "agents", "eval", "research", "tests"}, ["all", "train", "eval"]),
    ],
)
def test_what_is_imported_is_required(folder: str, own: set[str], extras: list[str]) -> None:
    required = {canonicalize_name(requirement.name) for requirement in requirements(*extras)}
    distributions = packages_distributions()
    names = imported(ROOT / folder)
    assert folder in names or "numpy" in names  # the folder was read
    for name in names - own:
        owners = {
            canonicalize_name(owner) for owner in distributions.get(name, [name])
        }  # one that is not installed has its name
        assert owners & required, f"{folder} imports {name}, which pyproject.toml does not require"
