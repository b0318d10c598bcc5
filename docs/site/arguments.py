"""Write the table of the environments' arguments in docs/environment.md: ``python docs/site/arguments.py``.

It is made of the fields of ``Configuration``; a test fails when it is out of date.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Mapping
from dataclasses import fields
from pathlib import Path
from types import MappingProxyType
from typing import Any

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT))

from jawenv.envs.configuration import Configuration  # noqa: E402

PAGE = ROOT / "docs" / "environment.md"
_BLOCK = re.compile(r"(<!-- table: arguments -->\n).*?(<!-- end of table -->)", re.S)


def table(changed: Mapping[str, Any] = MappingProxyType({}), types: bool = False) -> str:
    """The arguments in their order, with or without types; some environments have other defaults."""
    rows = [["argument", *["type"][:types], "default", "meaning"]]
    for argument in fields(Configuration):
        kind, meaning = str(argument.type).replace("|", "or"), argument.metadata["help"].rstrip(".")
        default = changed.get(argument.name, argument.default)
        rows.append([f"`{argument.name}`", *[f"`{kind}`"][:types], f"`{default!r}`", meaning])
    head, *body = (f"| {' | '.join(row)} |\n" for row in rows)
    return "".join((head, "|" + "---|" * len(rows[0]) + "\n", *body))


def renewed(text: str) -> str:
    """The page with the table of the sources."""
    return _BLOCK.sub(lambda block: block[1] + table() + block[2], text)


if __name__ == "__main__":
    PAGE.write_text(renewed(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
