"""One result of the thesis: its statement, our draws and their judgement."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
import pandas as pd

from eval.figures.statistics import Interval

Verdict = Literal["reproduced", "partly", "not reproduced"]
NO_NUMBER = "The thesis gives no number."
Draw = Callable[[Sequence[np.random.Generator]], Iterator[pd.DataFrame]]
"""Rows of each draw, from its own random numbers."""


@dataclass(frozen=True)
class Judgement:
    """Judgement of an item by its draws."""

    verdict: Verdict
    figures: dict[str, Interval]  # what was measured, by a name with its unit


def judged(fully: bool, partly: bool, figures: dict[str, Interval]) -> Judgement:
    """Judgement of a result that the draws reproduce as a whole, or in part."""
    return Judgement("reproduced" if fully else "partly" if partly else "not reproduced", figures)


@dataclass(frozen=True)
class Item:
    """One result."""

    key: str  # short name, in files
    title: str  # a few words
    where: str  # figure or section of Young (2016)
    says: str  # statement of the thesis; with its number if it gives one
    how: str  # our setting, where the thesis names none
    draw: Draw
    judge: Callable[[pd.DataFrame], Judgement]  # the finding, from the rows of all draws
    same_draws_as: str = ""  # key of the item with the same draws; empty for draws of its own

    @property
    def drawn_as(self) -> str:
        """Key of the item that owns the draws."""
        return self.same_draws_as or self.key


def one_by_one(draw: Callable[[np.random.Generator], pd.DataFrame]) -> Draw:
    """An item's ``draw`` from a function of a single draw."""
    return lambda rngs: map(draw, rngs)
