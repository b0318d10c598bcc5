"""A combination of log-parameters in words: which muscles, which sides, F_o or b, and what against what.

'F_o: temporalis, left against right' is a direction in which one of the two can grow and the other shrink without
the data noticing.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from jawenv.errors import InputError

NAMED_SHARE = 0.75  # least share of a direction's squared length that is named
KIND, MUSCLE, SIDE = range(3)
Label = tuple[str, str, str]  # kind, muscle, side; empty where the model tells none
Item = tuple[tuple[str, ...], tuple[str, ...], tuple[str, ...]]  # all combinations of some kinds, muscles and sides


def parse_name(name: str) -> Label:
    """Kind, muscle and side of a parameter's name, as ``log_F_o/masseter_left``."""
    symbol, _, muscle = name.partition("/")
    for side in ("left", "right"):
        if muscle == side:
            return symbol.removeprefix("log_"), "", side
        if muscle.endswith("_" + side):
            return symbol.removeprefix("log_"), muscle.removesuffix("_" + side).replace("_", " "), side
    return symbol.removeprefix("log_"), muscle.replace("_", " "), ""


def in_words(direction: ArrayLike, names: Sequence[str]) -> str:
    """Say what a combination of parameters is about.

    The largest parts that make up ``NAMED_SHARE`` of the squared length are named, parts of equal size together. Parts
    of one sign are set against those of the other. What all have in common is said once: the kind before the colon,
    muscle and side after it.

    Args:
        direction: (p,) weights of the log-parameters; its length and sign do not matter.
        names: (p,) parameter names, ``log_F_o/<muscle>_<side>``.

    Returns:
        Such as 'F_o: temporalis, left against right', 'F_o: masseter against medial pterygoid, left',
        'F_o against b: masseter, left' or 'b: all'.

    Raises:
        InputError: the direction does not have one finite number for each name, or is zero.
    """
    weights = np.asarray(direction, dtype=np.float64)
    if weights.shape != (len(names),) or not np.isfinite(weights).all() or not weights.any():
        raise InputError(
            f"direction: {np.array2string(weights, threshold=6)} given, "
            f"allowed are {len(names)} finite numbers that are not all 0"
        )
    order = np.argsort(-np.abs(weights), kind="stable")
    shares = np.cumsum(weights[order] ** 2) / np.sum(weights**2)
    number = int(np.searchsorted(shares, NAMED_SHARE)) + 1
    smallest = abs(weights[order[number - 1]]) * (1.0 - 1e-6)
    chosen = [int(i) for i in order if abs(weights[i]) >= smallest]
    sign = np.sign(weights[min(chosen)])  # F_o before b and left before right, whichever sign came out of a solver
    all_labels = [parse_name(name) for name in names]
    positive = [all_labels[i] for i in sorted(chosen) if np.sign(weights[i]) == sign]
    negative = [all_labels[i] for i in sorted(chosen) if np.sign(weights[i]) != sign]
    return _phrase(positive, negative, all_labels) if negative else _one_group(positive, all_labels)


def _values(labels: Sequence[Label], respect: int) -> tuple[str, ...]:
    """The different kinds, muscles or sides, in their first order."""
    return tuple(dict.fromkeys(label[respect] for label in labels))


def _is_product(labels: Sequence[Label]) -> bool:
    """Whether the labels are all combinations of their kinds, muscles and sides."""
    return len(labels) == int(np.prod([len(_values(labels, respect)) for respect in range(3)]))


def _joined(values: Sequence[str]) -> str:
    return ", ".join(values[:-1]) + " and " + values[-1] if len(values) > 1 else values[0]


def _part(values: Sequence[str], respect: int, all_labels: Sequence[Label]) -> str:
    """Some kinds, muscles or sides as words; nothing where all are meant and it goes without saying."""
    complete = set(values) == set(_values(all_labels, respect))
    if respect == MUSCLE and complete and len(values) > 2:
        return "all muscles"
    if respect == SIDE and complete and len(values) > 1:
        return "both sides"
    return _joined(values)


def _sentence(kind: str, muscle: str, side: str) -> str:
    subject = ", ".join(text for text in (muscle, side) if text)
    return f"{kind}: {subject}" if subject else kind


def _one_group(labels: Sequence[Label], all_labels: Sequence[Label]) -> str:
    if not _is_product(labels):
        return _listed(labels, [], all_labels)
    return _sentence(*(_part(_values(labels, respect), respect, all_labels) for respect in range(3)))


def _phrase(positive: Sequence[Label], negative: Sequence[Label], all_labels: Sequence[Label]) -> str:
    """Two groups against each other: one sentence if they differ in one respect, else a list."""
    different = [respect for respect in range(3) if _values(positive, respect) != _values(negative, respect)]
    if len(different) != 1 or not (_is_product(positive) and _is_product(negative)):
        return _listed(positive, negative, all_labels)
    parts = [_part(_values(positive, respect), respect, all_labels) for respect in range(3)]
    respect = different[0]
    parts[respect] = f"{parts[respect]} against {_part(_values(negative, respect), respect, all_labels)}"
    return _sentence(*parts)


def _listed(positive: Sequence[Label], negative: Sequence[Label], all_labels: Sequence[Label]) -> str:
    """Every part by itself; kind and sides once if all parts share them."""
    groups = [_items(group) for group in (positive, negative) if group]
    items = [item for group in groups for item in group]
    kinds, sides = {item[KIND] for item in items}, {item[SIDE] for item in items}
    texts = []
    for group in groups:
        words = [
            (
                f"{_joined(kind)} of " if len(kinds) > 1 and any(muscles) else _joined(kind) * (len(kinds) > 1),
                _joined(muscles),
                f" {_part(side, SIDE, all_labels)}" if len(sides) > 1 else "",
            )
            for kind, muscles, side in group
        ]
        texts.append(_joined(["".join(word) for word in words]))
    front = f"{_joined(next(iter(kinds)))}: " if len(kinds) == 1 else ""
    back = f", {_part(next(iter(sides)), SIDE, all_labels)}" if len(sides) == 1 and any(next(iter(sides))) else ""
    return front + " against ".join(texts) + back


def _items(labels: Sequence[Label]) -> list[Item]:
    """One sign's parts as few products of kinds, muscles and sides: sides are put together first, then kinds."""
    items: list[Item] = [((kind,), (muscle,), (side,)) for kind, muscle, side in labels]
    for respect in (SIDE, KIND, MUSCLE):
        merged: dict[tuple[tuple[str, ...], ...], list[str]] = {}
        for item in items:
            remaining = tuple(values for i, values in enumerate(item) if i != respect)
            merged.setdefault(remaining, []).extend(item[respect])
        items = []
        for remaining, values in merged.items():
            first, second = remaining
            parts = [first, second]
            parts.insert(respect, tuple(values))
            items.append((parts[0], parts[1], parts[2]))
    return items
