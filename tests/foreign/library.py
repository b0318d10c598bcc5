"""How a module of this folder says which library it is about, and which of its cases repeat others."""

from typing import Any

import pytest
from project.documented import ROOT, blocks

from jawenv.controls import CONTROLS, DEFAULT_CONTROL
from jawenv.envs.registration import ENVIRONMENTS
from jawenv.ladder import KNOWN_WITHIN_SDS

REPEATS = pytest.mark.repeats
_USUAL = "jawenv/Jaw-v3"
_IDS = (*ENVIRONMENTS, KNOWN_WITHIN_SDS)  # version 1 of an id is the same world


def library(name: str) -> list[pytest.MarkDecorator]:
    """The marks of a module's tests: in the group, of the distribution ``name``."""
    return [pytest.mark.foreign, pytest.mark.library(name)]


def recipe(package: str) -> dict[str, Any]:
    """What the recipe of docs/environment.md that imports a package leaves, run in a module of its own."""
    (block,) = (block for block in blocks(ROOT / "docs" / "environment.md", "py") if f"from {package}." in block.text)
    names: dict[str, Any] = {"__name__": "__main__"}
    exec(compile(block.text, block.place, "exec"), names)
    return names


def ids_and_controls() -> list[Any]:
    """Every id in every control: each id in one control and each control in one id, the others marked as repeats."""
    return [
        pytest.param(env_id, control, marks=() if env_id == _USUAL or control == DEFAULT_CONTROL else REPEATS)
        for env_id in _IDS
        for control in CONTROLS
    ]


def ids_controls_and_pictures() -> list[Any]:
    """The same in every render mode: controls where nothing is drawn, pictures of each id, a window once."""
    return [
        pytest.param(env_id, control, mode, marks=() if first else REPEATS)
        for env_id in _IDS
        for control in CONTROLS
        for mode, first in (
            (None, env_id == _USUAL),
            ("rgb_array", control == DEFAULT_CONTROL),
            ("human", env_id == _USUAL and control == DEFAULT_CONTROL),
        )
    ]
