"""Closing force at the incisors and its stiffness, by muscle, side and in all, at openings that a recording reached.

What the muscles pull with at openings that were seen needs no word about the closed jaw or the law beyond them.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from jawenv.mechanics.opening import muscle_lengths, opening_of
from jawenv.recordings.defaults import motion_of_reading
from jawenv.recordings.estimate import Array
from jawenv.recordings.record import Record

OPENINGS_MM = (10.0, 20.0, 30.0)
LEVER_SD = 0.01
"""Sd of a line's growth with the opening where ends are as a scan leaves them: that of temporalis changes its sign."""
_ROWS, _STEPS, _FEWEST = 60, 61, 3


class Tension(NamedTuple):
    """Closing force at the incisors along the recorded way of opening, where it balances a muscle's pull."""

    opening_mm: float
    force_N: float
    force_sd_N: float
    stiffness_N_mm: float  # growth with the opening
    stiffness_sd_N_mm: float


def tensions_of(record: Record, log_mean: Array, log_cov: Array, lever_sd: float = 0.0) -> dict[str, list[Tension]]:
    """Forces of each muscle, ``left``, ``right`` and ``all`` at ``OPENINGS_MM``, as far as the recording went.

    The force at the incisors does the work of the muscle's: its tension times the line's growth with the opening
    (virtual work). Error bars are those of belief and growth, carried on linearly; beyond the largest opening nothing
    is said.

    Args:
        record: of the jaw that was believed.
        log_mean: (p,) natural logs of F_o and b.
        log_cov: (p, p) their covariance.
        lever_sd: sd of each line's growth, see ``LEVER_SD``.
    """
    opening, strain, growth = along_the_way(record)
    asked = [] if len(opening) < _FEWEST else [mm for mm in OPENINGS_MM if mm <= 1e3 * opening.max()]
    muscle = record.jaw["muscle"]
    by_log = [_by_parameters(1e-3 * mm, opening, strain, growth, log_mean, muscle) for mm in asked]
    names = [name.removeprefix("log_F_o/") for name in record.parameter_names[::2]]
    groups = {name: np.array([one == name for one in names]) for name in names}
    for side in ("left", "right"):
        if any(name.endswith(side) for name in names):
            groups[side] = np.array([name.endswith(side) for name in names])
    groups["all"] = np.ones(len(names), dtype=bool)
    found: dict[str, list[Tension]] = {}
    for group, members in groups.items():
        chosen = np.repeat(members, 2)
        found[group] = []
        for mm, (values, gradients, pulls) in zip(asked, by_log, strict=True):
            rows = gradients * chosen
            of_levers = lever_sd**2 * np.square(pulls[:, members]).sum(axis=1)
            sds = np.sqrt(np.einsum("ki,ij,kj->k", rows, log_cov, rows) + of_levers)
            force, stiffness = values[:, members].sum(axis=1)
            found[group].append(Tension(mm, float(force), float(sds[0]), float(stiffness), float(sds[1])))
    return found


def along_the_way(record: Record) -> tuple[Array, Array, Array]:
    """Opening (K,) m, strains (K, lines) and growth of the lines with the opening (K, lines), of the midline's motion.

    The condyles slide with the pitch as they did in the recording.
    """
    jaw, read = record.jaw, np.flatnonzero(np.isfinite(record.measured).any(axis=1))
    rows = record.measured[read[np.linspace(0, len(read) - 1, min(_ROWS, len(read))).astype(int)]]
    poses = np.array([motion_of_reading(jaw, row, record.measurement_sd)[:5] for row in rows])
    pitch = poses[:, 2]
    shapes = np.column_stack([pitch, pitch**2])
    slide = np.linalg.lstsq(shapes, poses[:, 0], rcond=None)[0]
    theta = np.linspace(0.0, max(float(pitch.max()), 1e-3), _STEPS)
    way = np.zeros((_STEPS, 5))
    way[:, 2], way[:, 0] = theta, np.column_stack([theta, theta**2]) @ slide
    opening = np.array([opening_of(jaw, pose) for pose in way])
    opens = np.append(True, np.diff(np.maximum.accumulate(opening)) > 0.0)
    opening, way = opening[opens], way[opens]
    if len(opening) < _FEWEST:
        return opening, opening, opening
    lengths = np.array([muscle_lengths(jaw, pose) for pose in way])
    return opening, lengths / jaw["l_o"] - 1.0, np.gradient(lengths, opening, axis=0)


def _by_parameters(
    at: float, opening: Array, strain: Array, growth: Array, log_mean: Array, muscle: Array
) -> tuple[Array, Array, Array]:
    """Force, N, and stiffness, N/mm, (2, M) of each muscle at an opening, m; their derivatives (2, p) by the logs.

    Behind these both of the muscle's tension itself, (2, M).
    """
    F_o, b = np.exp(log_mean.reshape(-1, 2)[muscle]).T
    tension = F_o * np.exp(b * strain)
    pulled = tension * growth
    steeper = b * strain * pulled  # by log b
    count = len(log_mean) // 2
    values, gradients, pulls = np.zeros((2, count)), np.zeros((2, len(log_mean))), np.zeros((2, count))
    for row, scale in ((0, 1.0), (1, 1e-3)):
        curves = [pulled, steeper, tension]
        if row == 1:
            curves = [np.gradient(curve, opening, axis=0) for curve in curves]
        for line, owner in enumerate(muscle):
            force, by_b, pull = (scale * float(np.interp(at, opening, curve[:, line])) for curve in curves)
            values[row, owner] += force
            pulls[row, owner] += pull
            gradients[row, 2 * owner] += force
            gradients[row, 2 * owner + 1] += by_b
    return values, gradients, pulls


def in_words(found: dict[str, list[Tension]]) -> list[str]:
    """A table: force and its error bar, and the stiffness, at each opening."""
    reached = next(iter(found.values()))
    if not reached:
        return [f"closing force at the incisors: the recording opens by less than {OPENINGS_MM[0]:g} mm"]
    title = "closing force at the incisors, N (stiffness, N/mm)"
    lines = [f"{title:32}" + "".join(f"{f'{one.opening_mm:g} mm':>22}" for one in reached)]
    for group, ones in found.items():
        cells = (f"{one.force_N:.2f} ± {one.force_sd_N:.2f} ({one.stiffness_N_mm:.3f})" for one in ones)
        lines.append(f"{group:32}" + "".join(f"{cell:>22}" for cell in cells))
    return lines
