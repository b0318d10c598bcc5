"""Combinations of parameters in words."""

from __future__ import annotations

from collections.abc import Sequence
from math import prod

import numpy as np
from numpy.typing import ArrayLike, NDArray

from jawenv.base.errors import InputError

Array = NDArray[np.float64]
_Label = tuple[str, str, str]  # kind, muscle and side of a parameter
NAMED_SHARE = 0.75  # least share of a direction's squared length that is named


def in_words(direction: ArrayLike, names: Sequence[str]) -> str:
    """Say what a combination of parameters is about.

    The largest parts that make up ``NAMED_SHARE`` of the squared length are named, those of one sign against those of
    the other.

    Args:
        direction: (p,) weights of the log-parameters; its length and sign do not matter.
        names: (p,) parameter names, ``log_F_o/<muscle>_<side>``.

    Returns:
        Such as 'F_o: temporalis, left against right', 'F_o against b: masseter, left' or, where more than one of kind,
        muscle and side differs, 'F_o masseter left against b temporalis right'.
    """
    weights = np.asarray(direction, dtype=np.float64)
    if weights.shape != (len(names),) or not np.isfinite(weights).all() or not weights.any():
        raise InputError(
            f"direction is {np.array2string(weights, threshold=6)}; "
            f"allowed: {len(names)} finite numbers that are not all 0"
        )
    labels = [_label(name) for name in names]
    groups = _named(weights, labels)
    values = [_values(group) for group in groups]
    products = all(prod(map(len, own)) == len(group) for own, group in zip(values, groups, strict=True))
    by_part = list(zip(*values, strict=True))  # kinds, muscles and sides, of each sign
    if not products or sum(len(set(own)) > 1 for own in by_part) > 1:
        return " against ".join(" and ".join(" ".join(filter(None, label)) for label in group) for group in groups)
    kind, *rest = map(_against, by_part, _values(labels), ("", "all muscles", "both sides"))
    return ": ".join(filter(None, (kind, ", ".join(filter(None, rest)))))


def _named(weights: Array, labels: Sequence[_Label]) -> list[list[_Label]]:
    """Labels of the largest weights: those of the first one's sign, whichever came out of a solver, and the others."""
    size = np.sort(np.abs(weights))[::-1]
    smallest = size[np.searchsorted(np.cumsum(size**2), NAMED_SHARE * np.sum(size**2))] * (1.0 - 1e-6)
    named = np.flatnonzero(np.abs(weights) >= smallest)
    like_first = np.sign(weights[named]) == np.sign(weights[named[0]])
    signs = named[like_first], named[~like_first]
    return [[labels[i] for i in sign] for sign in signs if len(sign)]


def _values(labels: Sequence[_Label]) -> list[tuple[str, ...]]:
    """The different kinds, muscles and sides of some labels."""
    return [tuple(dict.fromkeys(part)) for part in zip(*labels, strict=True)]


def _against(parts: Sequence[tuple[str, ...]], every: tuple[str, ...], all_of: str) -> str:
    """Kinds, muscles or sides of one sign against those of the other; once where they are the same."""
    return " against ".join(dict.fromkeys(_joined(part, every, all_of) for part in parts))


def _label(name: str) -> _Label:
    """Kind, muscle and side of a parameter's name; empty where the model tells none."""
    kind, _, muscle = name.removeprefix("log_").partition("/")
    side = muscle.rpartition("_")[2] if muscle.endswith(("left", "right")) else ""
    return kind, muscle.removesuffix(side).replace("_", " ").strip(), side


def _joined(values: tuple[str, ...], every: tuple[str, ...], all_of: str) -> str:
    """Some kinds, muscles or sides in words."""
    if all_of and len(every) > 1 and set(values) == set(every):
        return all_of
    return " and ".join(filter(None, (", ".join(values[:-1]), values[-1])))
