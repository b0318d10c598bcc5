"""All items, in the order of the thesis. Importing this compiles nothing."""

from __future__ import annotations

from collections.abc import Iterable

from eval.thesis import kalman, kinematics, least_squares, maneuver, rates, two_stage
from eval.thesis.item import Item
from jawenv.base.errors import InputError

ITEMS: dict[str, Item] = {
    item.key: item
    for item in (
        kinematics.ITEM,
        least_squares.LINEAR,
        least_squares.PLANE,
        least_squares.FULL,
        least_squares.PHYSICIAN,
        kalman.SIDES,
        kalman.FULL,
        kalman.NOISE,
        maneuver.ITEM,
        rates.ITEM,
        two_stage.ITEM,
    )
}


def chosen(keys: Iterable[str]) -> list[Item]:
    """Items of these keys."""
    for key in keys:
        if key not in ITEMS:
            raise InputError(f"results is {key!r}; allowed: {', '.join(ITEMS)}")
    return [item for key, item in ITEMS.items() if key in keys]
