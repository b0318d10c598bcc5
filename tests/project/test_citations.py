"""Modules that the sources cite exist, and hold what is cited of them."""

import ast
import re
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PACKAGES = ("jawenv", "agents", "training", "eval")
SOURCES = sorted(
    file for package in PACKAGES for file in (ROOT / package).rglob("*.py") if "notebooks" not in file.parts
)
CITED = re.compile(r"(`{1,2})([a-z]\w*(?:\.\w+)+)(?:\([^`]*\))?\1")


def module_name(file: Path) -> str:
    return ".".join(file.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")


MODULES = {module_name(file): file for file in SOURCES}
STEMS = {name.rpartition(".")[2] for name in MODULES} - {"world", "belief"}  # which records are called, too
FILE_ENDINGS = {".csv", ".py", ".md", ".yaml", ".json", ".toml", ".npz", ".zip"}


@cache
def names_in(module: str) -> frozenset[str]:
    """What a module defines or imports, and the modules in its package."""
    found = {name.rpartition(".")[2] for name in MODULES if name.rpartition(".")[0] == module}
    for node in ast.walk(ast.parse(MODULES[module].read_text(encoding="utf-8"))):
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            found.add(node.name)
        elif isinstance(node, ast.Import | ast.ImportFrom):
            found |= {(alias.asname or alias.name).split(".")[0] for alias in node.names}
        elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            found.add(node.id)
    return frozenset(found)


def resolves(cited: str) -> bool:
    """Whether a text names a module, or something in one, by its whole name or the end of it."""
    parts = cited.split(".")
    for count in range(len(parts), 0, -1):
        end = ".".join(parts[:count])
        modules = [name for name in MODULES if name == end or name.endswith(f".{end}")]
        if modules:
            return any(count == len(parts) or parts[count] in names_in(module) for module in modules)
    return False


def cited_in(text: str) -> list[str]:
    """Names that begin with a package or a module of the project; no file names."""
    every = (match[2] for match in CITED.finditer(text))
    return [
        name for name in every if name.split(".")[0] in {*PACKAGES, *STEMS} and Path(name).suffix not in FILE_ENDINGS
    ]


@pytest.mark.parametrize("package", PACKAGES)
def test_what_is_cited_exists(package: str) -> None:
    missing = [
        f"{file.relative_to(ROOT)}: {name}"
        for file in SOURCES
        if file.relative_to(ROOT).parts[0] == package
        for name in cited_in(file.read_text(encoding="utf-8"))
        if not resolves(name)
    ]
    assert not missing, "\n".join(missing)


def test_a_citation_of_nothing_is_found() -> None:
    assert resolves("eval.kept.parts.finish") and resolves("kept.parts") and resolves("parts.finish")
    assert not resolves("eval.kept.chunks") and not resolves("parts.nothing")
    assert cited_in("see `eval.kept.chunks`, ``jawenv.lost.Name``, `numpy.ndarray`") == [
        "eval.kept.chunks",
        "jawenv.lost.Name",
    ]
