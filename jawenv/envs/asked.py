"""The muscles that an episode asks for: their parameters alone are paid for by ``reward="worst"``, and judged."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from jawenv.base.errors import not_among
from jawenv.kernels.noise import philox

RANDOM = "random"
_COUNTER: tuple[Any, Any, Any, Any] = (np.uint64(1), np.uint64(0), np.uint64(0), np.uint64(0))
# The next after that of the episode's other random numbers.


def checked_asked(asked: object, muscles: Sequence[str], name: str = "asked") -> str | None:
    """A question that muscles of these names can answer; None asks for all."""
    if asked is None or (isinstance(asked, str) and (asked == RANDOM or _named(asked, muscles).any())):
        return asked
    raise not_among(name, asked, (RANDOM, *muscles), ", or a word of these, as left")


def asked_muscles(asked: str | None, muscles: Sequence[str], key: NDArray[np.uint64]) -> NDArray[np.bool_]:
    """Mask (M,) of the muscles that a question asks for.

    Args:
        asked: a muscle, a word of several names, "random" for one that the key draws, or None for all.
        muscles: M names.
        key: (2,) of the episode.
    """
    if asked is None:
        return np.ones(len(muscles), dtype=np.bool_)
    if asked != RANDOM:
        return _named(asked, muscles)
    chosen = np.zeros(len(muscles), dtype=np.bool_)
    chosen[int(philox(tuple(key), _COUNTER)[0]) % len(muscles)] = True
    return chosen


def _named(asked: str, muscles: Sequence[str]) -> NDArray[np.bool_]:
    return np.array([f"_{asked}_" in f"_{muscle}_" for muscle in muscles])
