"""Rooms import one way, and docs/tables/rooms.md tells which."""

from graphlib import TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


@pytest.fixture
def sources(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.syspath_prepend(str(ROOT / "docs" / "site"))
    import imports

    return imports


def test_the_table_is_that_of_the_sources(sources) -> None:
    text = sources.PAGE.read_text(encoding="utf-8")
    assert sources.table() in text, "run: python docs/site/imports.py"
    assert sources.renewed(text.replace(sources.table(), "| old |\n")) == text


def test_every_room_has_its_place_and_imports_only_from_before_it(sources) -> None:
    imports = sources.room_imports()
    assert sorted(imports) == sorted(sources.ORDER)
    assert sources.upward(imports) == []
    assert sources.upward({"jawenv.filter": {"jawenv.recordings", "jawenv.kernels"}}) == [
        "jawenv.filter imports jawenv.recordings"
    ]


def test_modules_do_not_import_in_a_circle(sources) -> None:
    graph = {module: sources.imports_of(module) for module in sources.module_files()}
    assert len(tuple(TopologicalSorter(graph).static_order())) == len(graph)


def test_folders_within_a_room_do_not_import_in_a_circle(sources) -> None:
    """What lies at the top of a room is a folder too; in packages of the clone each module there is one."""
    modules = sources.module_files()

    def folder(module: str) -> str:
        own: str = module if modules[module].name == "__init__.py" else module.rpartition(".")[0]
        return module if own in sources.CLONE else own

    graphs: dict[str, dict[str, set[str]]] = {}
    for module in modules:
        others = {
            folder(other) for other in sources.imports_of(module) if sources.room_of(other) == sources.room_of(module)
        }
        graph = graphs.setdefault(sources.room_of(module), {})
        graph.setdefault(folder(module), set()).update(others - {folder(module), *sources.CLONE})
    for graph in graphs.values():
        assert len(tuple(TopologicalSorter(graph).static_order())) == len(graph)
    assert len(graphs["jawenv.filter"]) > 7 and len(graphs["jawenv.envs"]) == 3 and len(graphs["eval"]) > 10


def test_the_page_tells_every_folder(sources) -> None:
    text = sources.PAGE.read_text(encoding="utf-8")
    assert sources.folders() in text, "run: python docs/site/imports.py"
    for package in ("jawenv/filter", "jawenv/envs", "eval"):
        folders = {str(path.parent.relative_to(ROOT)) for path in (ROOT / package).glob("*/__init__.py")}
        assert folders
        for name in (folder.removeprefix("jawenv/") for folder in folders):
            assert f"| `{name}` |" in text, f"no row for {name}"


def test_the_table_of_arguments_is_that_of_the_sources(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(ROOT / "docs" / "site"))
    import arguments

    text = arguments.PAGE.read_text(encoding="utf-8")
    assert arguments.renewed(text) == text, "run: python docs/site/arguments.py"
