"""Files and modules that pages and docstrings name exist."""

import importlib.util
import re
from importlib import import_module
from pathlib import Path

import pytest
from documented import PAGES, ROOT

PACKAGES = ("jawenv", "agents", "training", "eval")
FROM = (ROOT, ROOT / "jawenv", ROOT / "jawenv" / "filter")  # folders from which pages name files
FOLDERS = {path.name for folder in FROM for path in folder.iterdir() if path.is_dir()}
A_PATH = re.compile(r"(?<![\w/<.:*-])(?:[\w.]+/)+[\w.]*|(?<![\w/.])\w+\.py\b")
A_MODULE = re.compile(rf"(?<![\w/.])(?:{'|'.join(PACKAGES)})(?:\.[A-Za-z_]\w*)+")


def named_on(page: Path) -> list[str]:
    """What stands between backticks, outside of blocks of code."""
    text = re.sub(r"^```.*?^```", "", page.read_text(encoding="utf-8"), flags=re.M | re.S)
    return re.findall(r"`([^`]+)`", text)


def exists(name: str) -> bool:
    """Whether a dotted name is a module, or something in one."""
    parts = name.split(".")
    for last in range(len(parts), 0, -1):
        module = ".".join(parts[:last])
        try:
            if not importlib.util.find_spec(module):
                continue
        except ModuleNotFoundError:
            continue
        value = import_module(module)
        for part in parts[last:]:
            if not hasattr(value, part):
                return False
            value = getattr(value, part)
        return True
    return False


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_what_a_page_names_exists(page: Path) -> None:
    for span in named_on(page):
        for path in A_PATH.findall(span):
            if not path.startswith(("runs/", ".venv/", "jawenv/Jaw")) and (
                path.split("/")[0] in FOLDERS or path.endswith(".py")
            ):
                assert any((folder / path).exists() for folder in (*FROM, page.parent)), f"no file {path}"
        for name in A_MODULE.findall(span):
            assert exists(name) or (ROOT / name).exists(), f"no module {name}"
