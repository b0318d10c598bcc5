"""Write the tables of rooms, imports and folders in docs/tables/rooms.md: ``python docs/site/imports.py``.

What a room or folder is about is the first paragraph of its docstring; what it imports is read from the sources,
imports within functions too. A test fails when a table is out of date, when rooms import in a circle, or when one
imports upwards.
"""

from __future__ import annotations

import ast
import re
import sys
from collections.abc import Iterable
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "tables" / "rooms.md"

SHARED = ("base", "controls")
"""Rooms that every other one may import."""
LOOP = ("kernels", "anatomy", "mechanics", "ladder", "device", "reality", "filter", "rendering", "envs")
"""Rooms of which something runs in every step of an environment."""
STUDY = (
    "recordings",
    "analysis",
    "references",
    "trackers",
    "playing",
    "metrics",
    "answers",
    "inference",
    "design",
    "suggesting",
    "sb3",
    "live",
    "commands",
)
"""Rooms that study the loop."""
CLONE = ("agents", "training", "eval")
"""Packages that run from the clone."""
ORDER = (*(f"jawenv.{name}" for name in (*SHARED, *LOOP, *STUDY)), "jawenv", *CLONE)
"""All rooms: each imports only from rooms before it."""

DIVIDED = ("jawenv.filter", "jawenv.envs", "eval")
"""Rooms whose folders have a table of their own."""

_BLOCK = re.compile(r"(<!-- table: (imports|folders) -->\n).*?(<!-- end of table -->)", re.S)


@cache
def module_files() -> dict[str, Path]:
    """Name of each module -> its file."""
    files = (path for package in ("jawenv", *CLONE) for path in (ROOT / package).rglob("*.py"))
    return {".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__"): path for path in files}


@cache
def imports_of(module: str) -> frozenset[str]:
    """The modules of this project that a module imports, wherever in its file the import stands."""
    found: set[str] = set()
    for node in ast.walk(ast.parse(module_files()[module].read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            if node.level:
                raise ValueError(f"{module}: line {node.lineno}: a relative import; this project names modules in full")
            members = {f"{node.module}.{alias.name}" for alias in node.names}
            found |= {member if member in module_files() else str(node.module) for member in members}
    return frozenset(found & module_files().keys())


def room_of(module: str) -> str:
    """The room that a module belongs to: its package, in ``jawenv`` that of the second level."""
    parts = module.split(".")
    return ".".join(parts[: 2 if parts[0] == "jawenv" else 1])


def room_imports() -> dict[str, set[str]]:
    """Each room -> the other rooms that it imports."""
    found: dict[str, set[str]] = {}
    for module in module_files():
        found.setdefault(room_of(module), set()).update(room_of(other) for other in imports_of(module))
    return {room: others - {room} for room, others in found.items()}


def about(room: str) -> str:
    """The first paragraph of the docstring of a room or a folder."""
    doc = ast.get_docstring(ast.parse(module_files()[room].read_text(encoding="utf-8"))) or ""
    return doc.split("\n\n")[0].replace("\n", " ").rstrip(".").replace("``", "`")


def table() -> str:
    """The rooms in their order, by storey."""
    imports = room_imports()
    shared = {f"jawenv.{name}" for name in SHARED}

    def row(room: str) -> str:
        others = sorted(imports[room] - shared - {"jawenv"}, key=ORDER.index)
        return f"| `{room}` | {about(room)} | {', '.join(_short(other) for other in others) or '–'} |"

    lines = ["| room | what it is about | imports |", "|---|---|---|"]
    for title, rooms in (("for all others", SHARED), ("in the loop", LOOP), ("studies the loop", STUDY)):
        lines += [f"| **{title}** | | |", *(row(f"jawenv.{name}") for name in rooms)]
    lines += ["| **runs from the clone** | | |", *(row(name) for name in CLONE)]
    return "\n".join(lines) + "\n"


def folders() -> str:
    """The folders of the rooms that are divided."""
    names = sorted(name for name, path in module_files().items() if path.name == "__init__.py")
    inner = [name for room in DIVIDED for name in names if name.rpartition(".")[0] == room]
    rows = [f"| `{name.removeprefix('jawenv.').replace('.', '/')}` | {about(name)} |" for name in inner]
    return "\n".join(("| folder | what it is about |", "|---|---|", *rows)) + "\n"


def _short(room: str) -> str:
    return room.removeprefix("jawenv.")


def upward(imports: dict[str, Iterable[str]]) -> list[str]:
    """Imports that do not go down the order of rooms."""
    return [
        f"{room} imports {other}"
        for room, others in imports.items()
        for other in others
        if ORDER.index(other) >= ORDER.index(room)
    ]


def renewed(text: str) -> str:
    """The page with the tables as the sources have them."""
    return _BLOCK.sub(lambda block: block[1] + {"imports": table, "folders": folders}[block[2]]() + block[3], text)


if __name__ == "__main__":
    if sys.argv[1:]:
        raise SystemExit("usage: python docs/site/imports.py")
    PAGE.write_text(renewed(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
