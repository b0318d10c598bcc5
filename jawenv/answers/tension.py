"""Closing force at the incisors and its stiffness, by muscle, side and in all, at openings that a recording reached.

What the muscles pull with at openings that were seen needs no word about the closed jaw or the law beyond them.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from scipy.linalg import block_diag
from scipy.special import ndtr

from jawenv.filter.model.basis import MIDDLE_POSE
from jawenv.mechanics.kinematics import contact_point, rotation
from jawenv.mechanics.opening import muscle_lengths, opening_of
from jawenv.metrics.diagnosis import CONFIDENCE, STIFF_F_O_N, whole_muscles_per_line
from jawenv.recordings.defaults import motion_of_reading
from jawenv.recordings.estimate import Array
from jawenv.recordings.record import Record
from jawenv.recordings.untold.learnt import JointBelief

OPENINGS_MM = (10.0, 20.0, 30.0)
LEVER_SD = 0.01
"""Sd of a line's growth with the opening where nothing was learnt of its ends: that of temporalis changes its sign."""
USUAL_B = 8.5
"""Between the cohorts healthy and trismus, as `STIFF_F_O_N` is: so is each of their forces at any opening, in logs."""
_ROWS, _STEPS, _FEWEST = 400, 61, 3


class Tension(NamedTuple):
    """Closing force at the incisors along the recorded way of opening, where it balances a muscle's pull."""

    opening_mm: float
    force_N: float
    force_sd_N: float
    stiffness_N_mm: float  # growth with the opening
    stiffness_sd_N_mm: float
    raised: float  # probability that the force is nearer to that of trismus than to a healthy one
    word: str  # ``raised`` or ``normal``; empty where neither is sure


class Way(NamedTuple):
    """The midline's motion from the closed jaw to the widest that was recorded, in K poses."""

    poses: Array  # (K, 5)
    opening: Array  # (K,) m, which only grows
    strain: Array  # (K, lines)
    growth: Array  # (K, lines) of the lines with the opening


def tensions_of(
    record: Record, log_mean: Array, log_cov: Array, joint: JointBelief | None = None
) -> dict[str, list[Tension]]:
    """Forces of each muscle, ``left``, ``right`` and ``all`` at ``OPENINGS_MM``, as far as the recording went.

    The force at the incisors does the work of the muscle's: its tension times the line's growth with the opening
    (virtual work). Error bars are those of parameters, ends and laws together, carried on linearly: readings hold the
    force, so that an end that is off is made up for by F_o and b. Beyond the largest opening nothing is said.

    Args:
        record: of the jaw that was believed.
        log_mean: (p,) natural logs of F_o and b.
        log_cov: (p, p) their covariance.
        joint: what is believed of lines and laws beside them; None where nothing was learnt.
    """
    way = along_the_way(record)
    asked = [] if len(way.opening) < _FEWEST else [mm for mm in OPENINGS_MM if mm <= 1e3 * way.opening.max()]
    names = [name.removeprefix("log_F_o/") for name in record.parameter_names[::2]]
    groups = {name: np.array([one == name for one in names]) for name in names}
    sides = {side: np.array([name.endswith(side) for name in names]) for side in ("left", "right")}
    groups |= {side: members for side, members in sides.items() if members.any()}
    groups["all"] = np.ones(len(names), dtype=bool)
    found: dict[str, list[Tension]] = {group: [] for group in groups}
    if not asked:
        return found
    curves, cov = _curves(record.jaw, way, log_mean, log_cov, joint)
    usual = STIFF_F_O_N * whole_muscles_per_line(record.parameter_names) * np.exp(USUAL_B * way.strain) * way.growth
    limits = usual @ np.eye(len(names))[record.jaw["muscle"]]
    both = curves, 1e-3 * np.gradient(curves, way.opening, axis=1, edge_order=2)
    for mm in asked:
        weights = np.array([np.interp(1e-3 * mm, way.opening, row) for row in np.eye(len(way.opening))])
        there = [np.einsum("s,nsm->nm", weights, values) for values in both]
        for group, members in groups.items():
            sums = [values[:, members].sum(axis=1) for values in there]
            sds = [float(np.sqrt(each[1:] @ cov @ each[1:])) for each in sums]
            limit = float((weights @ limits)[members].sum())
            raised = float(ndtr(np.sign(limit) * (sums[0][0] - limit) / max(sds[0], 1e-12)))
            word = "raised" if raised >= CONFIDENCE else "normal" if raised <= 1.0 - CONFIDENCE else ""
            found[group].append(Tension(mm, float(sums[0][0]), sds[0], float(sums[1][0]), sds[1], raised, word))
    return found


def along_the_way(record: Record) -> Way:
    """The way of opening, on which the condyles slide with the pitch as they did in the recording."""
    jaw, read = record.jaw, np.flatnonzero(np.isfinite(record.measured).any(axis=1))
    rows = record.measured[read[np.linspace(0, len(read) - 1, min(_ROWS, len(read))).astype(int)]]
    recorded = np.array([motion_of_reading(jaw, row, record.measurement_sd)[:5] for row in rows])
    pitch = recorded[:, 2]
    if not np.isfinite(rows[:, :3]).any():  # angles alone do not show how far the condyles slide
        recorded[:, 0] = MIDDLE_POSE[0] / MIDDLE_POSE[2] * pitch
    shapes = np.column_stack([pitch, pitch**2])
    slide = np.linalg.lstsq(shapes, recorded[:, 0], rcond=None)[0]
    theta = np.linspace(0.0, max(float(pitch.max()), 1e-3), _STEPS)
    poses = np.zeros((_STEPS, 5))
    poses[:, 2], poses[:, 0] = theta, np.column_stack([theta, theta**2]) @ slide
    opening = np.array([opening_of(jaw, pose) for pose in poses])
    opens = np.append(True, np.diff(np.maximum.accumulate(opening)) > 0.0)
    opening, poses = opening[opens], poses[opens]
    if len(opening) < _FEWEST:
        return Way(poses, opening, opening, opening)
    lengths = np.array([muscle_lengths(jaw, pose) for pose in poses])
    return Way(poses, opening, lengths / jaw["l_o"] - 1.0, np.gradient(lengths, opening, axis=0, edge_order=2))


def _curves(jaw: Any, way: Way, log_mean: Array, log_cov: Array, joint: JointBelief | None) -> tuple[Array, Array]:
    """Force of each muscle along the way, N, and its derivatives by n unknowns, (1 + n, K, M); their cov (n, n)."""
    muscle, p = jaw["muscle"], len(log_mean)
    F_o, b = np.exp(log_mean.reshape(-1, 2)[muscle]).T
    tension = F_o * np.exp(b * way.strain)
    by_log = np.zeros((p, *tension.shape))
    lines = np.arange(len(muscle))
    by_log[2 * muscle, :, lines], by_log[2 * muscle + 1, :, lines] = tension.T, (b * way.strain * tension).T
    if joint is None:
        by_end = tension * LEVER_SD * np.eye(len(muscle))[:, None]
        cov = block_diag(log_cov, np.eye(len(muscle)))
    else:
        nodes, centre = (joint.basis[name][muscle] for name in ("nodes", "centre"))
        exponentials = np.exp(nodes * (way.strain - centre)[:, :, None])
        bent = np.einsum("slj,klj->ksl", exponentials, joint.bent[:, muscle])
        strain, growth = _by_ends(jaw, way, joint.moved)
        tension = tension + bent[0]
        by_end = tension * growth + (b * strain * tension + bent[1:]) * way.growth
        cov = joint.cov
    by_line = np.concatenate([(tension * way.growth)[None], by_log * way.growth, by_end])
    return by_line @ np.eye(p // 2)[muscle], cov


def _by_ends(jaw: Any, way: Way, moved: Array) -> tuple[Array, Array]:
    """Derivatives (k, K, lines) of strain and growth by the unknowns of the ends; l_o is the closed jaw's length."""
    turned = np.array([rotation(tuple(pose)) for pose in way.poses])
    placed = np.array([contact_point(jaw, tuple(pose)) for pose in way.poses])
    along = jaw["origin"] - placed[:, None] - np.einsum("lj,sij->sli", jaw["insertion"], turned)
    length = np.linalg.norm(along, axis=2)
    along /= length[:, :, None]
    longer = np.einsum("sli,kli->ksl", along, moved[0])
    longer -= np.einsum("sli,sij,klj->ksl", along, turned, moved[1], optimize=True)
    strain = longer / jaw["l_o"] - length * longer[:, :1] / jaw["l_o"] ** 2
    return strain, np.gradient(longer, way.opening, axis=1, edge_order=2)


def in_words(found: dict[str, list[Tension]]) -> list[str]:
    """A table: force and its error bar, the stiffness, and the verdict, at each opening."""
    if not found["all"]:
        return [f"closing force at the incisors: the recording opens by less than {OPENINGS_MM[0]:g} mm"]
    title = "closing force at the incisors, N (stiffness, N/mm)"
    lines = [f"{title:32}" + "".join(f"{f'{one.opening_mm:g} mm':>29}" for one in found["all"])]
    for group, ones in found.items():
        cells = (f"{one.force_N:.2f} ± {one.force_sd_N:.2f} ({one.stiffness_N_mm:.3f}) {one.word:6}" for one in ones)
        lines.append(f"{group:32}" + "".join(f"{cell:>29}" for cell in cells).rstrip())
    return lines
