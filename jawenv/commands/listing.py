"""The command ``jawenv list``."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from jawenv.base.errors import not_among
from jawenv.ladder import title_of_env

if TYPE_CHECKING:
    from jawenv.playing.policies.card import ModelCard

LONGEST_SENTENCE = 110  # characters


def print_list(what: str | None) -> None:
    """Print all of one kind, one a line with a sentence; every kind under its name where none is named."""
    if what is not None and what not in _LISTS:
        raise not_among("list", what, _LISTS)
    for kind in (what,) if what else _LISTS:
        if what is None:
            print(f"{kind}:")
        for name, says in _LISTS[kind]().items():
            print(f"{name:34s} {_sentence(says)}".rstrip())


def _sentence(text: str) -> str:
    """The first sentence of a text, cut at a word where it is long."""
    first = text.split(". ")[0].rstrip(".")
    return first if len(first) <= LONGEST_SENTENCE else first[:LONGEST_SENTENCE].rsplit(" ", 1)[0] + " ..."


def _maneuvers() -> dict[str, str]:
    from jawenv.playing.maneuvers import Maneuver, maneuver_names

    return {name: Maneuver.named(name).description for name in maneuver_names()}


def _agents() -> dict[str, str]:
    from jawenv.playing.excitation import DESCRIPTIONS
    from jawenv.playing.policies.card import SHIPPED, policy_names, read_card

    listed = {name: _scored(read_card(SHIPPED / name)) for name in policy_names()}
    others = "each maneuver plays as an agent, too; planners run from a clone (agents/README.md)"
    return listed | {name: f"test signal: {text}" for name, text in DESCRIPTIONS.items()} | {"": others}


def _scored(card: ModelCard) -> str:
    """Words for what a policy has reached on simulated patients, by its card."""
    reached = {result.metric: result.mean if result.median is None else result.median for result in card.results}
    sd = next((value for name, value in reached.items() if name.startswith("largest") and "10 s" in name), None)
    discomfort = next((value for name, value in reached.items() if name.startswith("discomfort")), None)
    world = card.environment
    asked = ", one muscle asked" if "asked" in world.others else ""
    known = "" if sd is None else f"worst sd {sd:.1f} % after 10 s, "
    cost = "" if discomfort is None else f"discomfort {discomfort:.2f} s; "
    what = "learned" if card.residual is None else f"learned, corrects {card.residual.maneuver.name}"
    return f"{title_of_env(world.id)}, {world.cohort}{asked}, {world.control}: {known}{cost}{what}"


def _cohorts() -> dict[str, str]:
    from jawenv.anatomy import COHORTS

    return {name: cohort.description for name, cohort in COHORTS.items()}


def _models() -> dict[str, str]:
    from jawenv.ladder import MODELS

    return {name: f"{model.env_id}: {model.shows}" for name, model in MODELS.items()}


_LISTS: dict[str, Callable[[], dict[str, str]]] = {
    "maneuvers": _maneuvers,
    "agents": _agents,
    "cohorts": _cohorts,
    "models": _models,
}
