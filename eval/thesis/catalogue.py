"""All items, in the order of the thesis. Importing this compiles nothing."""

from __future__ import annotations

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


def chosen(keys: list[str] | None) -> list[Item]:
    """Items of these keys, or all."""
    for key in keys or []:
        if key not in ITEMS:
            raise InputError(f"only is {key!r}; allowed: {', '.join(ITEMS)}")
    return [item for key, item in ITEMS.items() if not keys or key in keys]
