"""The command ``jawenv list``."""

from __future__ import annotations

from collections.abc import Callable

from jawenv.errors import InputError, shown


def print_list(what: str) -> None:
    """Print all of one kind, one a line.

    Raises:
        InputError: no such kind.
    """
    if what not in _LISTS:
        raise InputError(f"list: {shown(what)} given, allowed are {', '.join(_LISTS)}")
    for line in _LISTS[what]():
        print(line)


def _maneuvers() -> list[str]:
    from jawenv.playing.maneuvers import Maneuver, maneuver_names

    return [f"{name:34s} {Maneuver.named(name).title}" for name in maneuver_names()]


def _agents() -> list[str]:
    from jawenv.playing.maneuvers import maneuver_names

    rest = (
        "these come with the library; trained policies and planners run from a clone of the project (agents/README.md)"
    )
    return [f"{name:34s} maneuver" for name in maneuver_names()] + [rest]


def _cohorts() -> list[str]:
    from jawenv.anatomy import COHORTS

    return list(COHORTS)


def _models() -> list[str]:
    from jawenv.ladder import MODELS

    return [f"{name:10s} {model.env_id:24s} {model.shows}" for name, model in MODELS.items()]


_LISTS: dict[str, Callable[[], list[str]]] = {
    "maneuvers": _maneuvers,
    "agents": _agents,
    "cohorts": _cohorts,
    "models": _models,
}
