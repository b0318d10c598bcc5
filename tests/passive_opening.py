"""Opening of a relaxed jaw under a slow vertical pull: what a clinician measures, of simulated patients."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from jawenv.anatomy import MuscleSet, muscle_set
from jawenv.base.errors import InputError, shown
from jawenv.base.numeric_fields import real_number
from jawenv.kernels.records import record_zeros
from jawenv.mechanics.building import build_jaw
from jawenv.mechanics.dynamics import linear_dtype
from jawenv.mechanics.equilibrium import settle
from jawenv.mechanics.opening import opening_of

STEP_MM = 0.5
WIDEST_MM = 60.0
"""A jaw that opens further under a pull is said to open so far."""


def passive_opening(theta: ArrayLike, pulls_N: Sequence[float] = (0.0, 20.0, 40.0)) -> NDArray[np.float64]:
    """Openings at the incisors (mm) at which relaxed jaws come to rest under vertical pulls on the mouthpiece.

    The mouth is opened by a stiff spring whose end moves down in steps of ``STEP_MM``, and the opening is read where
    the spring's force first reaches the pull; where the branch of equilibria ends before, the jaw snaps through, and
    the last opening counts.

    Args:
        theta: (n, p) natural-log parameters of patients, or (p,) of one.
        pulls_N: 0 is the rest position; below 0 the teeth are pressed together.

    Returns:
        (n, pulls) or (pulls,); not-a-number where a jaw has no rest position.
    """
    return _read(theta, ("pulls_N", pulls_N), read_opening=True)


def pull_to_open(theta: ArrayLike, openings_mm: Sequence[float] = (35.0,)) -> NDArray[np.float64]:
    """Vertical pulls on the mouthpiece (N) under which relaxed jaws come to rest so far open at the incisors.

    Args:
        theta: (n, p) natural-log parameters of patients, or (p,) of one.
        openings_mm: at the incisors.

    Returns:
        (n, openings) or (openings,): 0 where the jaw rests so far open, the largest pull before a jaw that snaps
        through earlier, not-a-number where a jaw has no rest position.
    """
    return _read(theta, ("openings_mm", openings_mm), read_opening=False)


def _read(theta: ArrayLike, asked: tuple[str, Sequence[float]], *, read_opening: bool) -> NDArray[np.float64]:
    """Openings at the asked pulls, or pulls at the asked openings, of one patient or of many."""
    lines = muscle_set()
    jaw, (name, values) = build_jaw(lines), asked
    rows, size = np.asarray(theta, dtype=np.float64), len(lines.parameter_names)
    if rows.ndim not in (1, 2) or rows.shape[-1] != size or not np.isfinite(rows).all():
        raise InputError(f"theta is {shown(theta)}; allowed: finite natural-log parameters, ({size},) or (n, {size})")
    numbers = [real_number(value) for value in values]
    if not numbers or any(number is None or number < 0.0 for number in numbers):
        raise InputError(f"{name} is {shown(values)}; allowed: one or more numbers, 0 or more")
    found = []
    for row in np.atleast_2d(rows):
        openings, pulls = _curve(jaw, lines, row, max(values), read_opening)
        found.append(np.interp(values, *((pulls, openings) if read_opening else (openings, pulls))))
    return np.array(found if rows.ndim == 2 else found[0])


def _curve(jaw: Any, lines: MuscleSet, row: NDArray[np.float64], most: float, read_opening: bool) -> tuple[Any, Any]:
    """Openings (mm) and the largest pull so far (N), up to a largest pull or, with ``read_opening`` off, opening."""
    law = np.exp(row).reshape(-1, 2)[list(lines.muscle)]
    scratch = record_zeros(1, linear_dtype(len(lines.muscle)))[0], np.empty((5, 5)), np.empty(5)
    pose = np.array([3e-3, 0.0, 0.05, 0.0, 0.0])
    _, settled = settle(jaw, law, pose, 0.0, False, *scratch)
    if not settled:
        return [0.0], [np.nan]
    openings, forces = [1e3 * opening_of(jaw, pose)], [0.0]
    asked = max(openings[0], 0.0)
    while (forces if read_opening else openings)[-1] < most and asked < WIDEST_MM:
        asked += STEP_MM
        force, settled = settle(jaw, law, pose, 1e-3 * asked, True, *scratch)
        if not settled:
            break
        openings.append(1e3 * opening_of(jaw, pose))
        forces.append(force)
    return openings, np.maximum.accumulate(forces)
