"""The planners that come with the project, by name; each is imported when it is made."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Protocol

from jawenv.controls import Control

if TYPE_CHECKING:
    from agents.planning import Planner


class _MakesPlanner(Protocol):
    """Makes a planner for a control mode, or raises ``InputError``."""

    def __call__(self, *, control: Control) -> Planner: ...  # noqa: D102


def _clairvoyant(*, control: Control) -> Planner:
    from agents.clairvoyant import Clairvoyant

    return Clairvoyant("clairvoyant", control=control)


PLANNERS: Mapping[str, _MakesPlanner] = MappingProxyType(
    {
        "clairvoyant": _clairvoyant,
    }
)
"""Name -> what makes it."""
