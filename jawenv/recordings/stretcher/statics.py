"""Equilibrium of the midline jaw on vertical springs, with its derivatives: the model of a force-opening log.

A stretcher that opens the mouth slowly is a stiff vertical spring whose end moves. At equilibrium u'(q, p) = 0, so an
opening o(q) changes with any number p by do/dp = -l . du'/dp, where l solves (du'/dq)^T l = do/dq.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from jawenv.anatomy import MUSCLE_NAMES, muscle_set
from jawenv.kernels.cholesky import solve_in_place
from jawenv.kernels.compiled import njit
from jawenv.kernels.records import record_zeros
from jawenv.kernels.vec3 import add, apply, apply_transposed, cross, vector3
from jawenv.mechanics.building import build_jaw
from jawenv.mechanics.dynamics import Linear, acceleration_kernel, linear_dtype, linearise_acceleration
from jawenv.mechanics.equilibrium import HOLD_STIFFNESS, fill_flow_matrix, settle
from jawenv.mechanics.jaw import Jaw
from jawenv.mechanics.kinematics import contact_point, fossa, rotation, turning_axes
from jawenv.mechanics.opening import opening_of

Array = NDArray[np.float64]

N_PARAMETERS = 2 * len(MUSCLE_NAMES)
TONE_STEP_N, TILT_STEP_RAD = 0.01, 0.01
OPENING, BY_END, BY_TONE, BY_TILT, RATE = N_PARAMETERS, N_PARAMETERS + 1, N_PARAMETERS + 2, N_PARAMETERS + 3, -1
N_FOUND = N_PARAMETERS + 5
AT_REST = 1e-2  # m/s2 or rad/s2, at most left over; the weight is 10 m/s2
GRID_MM = 2.0
SPRING_MM = 4.0
"""Beyond an opening that the spring's end is moved, so that it is reached under 40 N and more."""


@njit
def hang(jaw: Jaw, toned: Jaw, tilted: Jaw, muscles, ends, poses, steps, linear: Linear, work, found):
    """Let a jaw hang on springs with these ends (K), by Newton steps of ``poses`` (K, 5) that end at equilibrium.

    Fills ``found`` (K, 17): derivatives of the opening by the twelve log parameters, the opening (m), its derivatives
    by end, tone (1/N) and tilt (1/rad), and the acceleration that is left. ``toned`` and ``tilted`` are the jaw with
    a little more of either; ``linear`` and ``work`` (6, 5) are working memory.
    """
    matrix, right = work[:5], work[5]
    arm = vector3(jaw.mouthpiece)
    still = (0.0, 0.0, 0.0, 0.0, 0.0)
    for k in range(len(ends)):
        for step in range(steps + 1):
            q = (poses[k, 0], poses[k, 1], poses[k, 2], poses[k, 3], poses[k, 4])
            turned = rotation(q)
            place = add(contact_point(jaw, q), apply(turned, arm))
            opening = jaw.mouthpiece[2] - place[2]
            force = HOLD_STIFFNESS * (ends[k] - opening)
            down = apply_transposed(turned, (0.0, 0.0, -1.0))
            wrench = (force * down[0], force * down[1], force * down[2], 0.0, 0.0, 0.0)
            rate = linearise_acceleration(jaw, muscles, q, still, wrench, linear)
            left = max(abs(rate[0]), abs(rate[1]), abs(rate[2]), abs(rate[3]), abs(rate[4]))
            fill_flow_matrix(jaw, q, turned, down, HOLD_STIFFNESS, force, linear, matrix)
            if step == steps or left < 1e-6:
                break
            for i in range(5):
                right[i] = -rate[i]
            solve_in_place(matrix, right)
            largest = max(abs(right[0]) / 2e-3, abs(right[1]) / 1e-3)
            largest = max(largest, max(abs(right[2]) / 0.06, max(abs(right[3]), abs(right[4])) / 0.03))
            for i in range(5):
                poses[k, i] += right[i] / max(1.0, largest)
        _, slope, _, _ = fossa(jaw, q[0])
        axes = turning_axes(q)
        right[0], right[1] = -slope, 0.0
        for j in range(3):
            right[2 + j] = -apply(turned, cross(axes[j], arm))[2]
        for i in range(5):
            for j in range(i):
                matrix[i, j], matrix[j, i] = matrix[j, i], matrix[i, j]
        solve_in_place(matrix, right)
        toned_rate = acceleration_kernel(toned, muscles, q, still, wrench)
        tilted_rate = acceleration_kernel(tilted, muscles, q, still, wrench)
        for j in range(len(found[k])):
            found[k, j] = 0.0
        wrench_column = linear.by_input.shape[1] - 6
        for i in range(5):
            for j in range(wrench_column):
                found[k, j] -= right[i] * linear.by_input[i, j]
            for j in range(3):
                found[k, BY_END] -= right[i] * linear.by_input[i, wrench_column + j] * down[j] * HOLD_STIFFNESS
            found[k, BY_TONE] -= right[i] * (toned_rate[i] - rate[i]) / TONE_STEP_N
            found[k, BY_TILT] -= right[i] * (tilted_rate[i] - rate[i]) / TILT_STEP_RAD
        found[k, OPENING], found[k, RATE] = opening, left


class Statics:
    """Openings and forces of a jaw that is opened slowly, for any muscles, tone and tilt of the head."""

    def __init__(self, head_tilt_deg: float = 0.0) -> None:
        """Build the default jaw with the six whole muscles; the head looks down by ``head_tilt_deg``."""
        lines = muscle_set()
        self._lines = list(lines.muscle)
        self._jaws = [build_jaw(lines, head_tilt_deg=head_tilt_deg).copy() for _ in range(3)]
        self._gravity, self._tone = self._jaws[0]["gravity"].copy(), float(self._jaws[0]["tone"])
        self._linear = record_zeros(1, linear_dtype(len(lines.muscle), n_muscles=len(MUSCLE_NAMES)))[0]
        self._small = record_zeros(1, linear_dtype(len(lines.muscle)))[0]
        self._work = np.empty((6, 5))

    def _set(self, tone_N: float, tilt_rad: float) -> None:
        offsets = ((0.0, 0.0), (TONE_STEP_N, 0.0), (0.0, TILT_STEP_RAD))
        for jaw, (more_tone, more_tilt) in zip(self._jaws, offsets, strict=True):
            c, s = np.cos(tilt_rad + more_tilt), np.sin(tilt_rad + more_tilt)
            x, y, z = self._gravity
            jaw["tone"] = self._tone + tone_N + more_tone
            jaw["gravity"] = c * x - s * z, y, s * x + c * z

    def _law(self, theta: Array) -> Array:
        law: Array = np.exp(theta).reshape(-1, 2)[self._lines]
        return law

    def path(self, theta: Array, last_mm: float) -> tuple[Array, Array]:
        """Openings (G, mm) and poses (G, 5) along the branch from the closed jaw, relaxed."""
        self._set(0.0, 0.0)
        law, jaw = self._law(theta), self._jaws[0]
        pose, openings, poses = np.array([3e-3, 0.0, 0.05, 0.0, 0.0]), [], []
        for asked in (-0.5, 0.5, *np.arange(GRID_MM, last_mm + GRID_MM, GRID_MM)):
            _, settled = settle(jaw, law, pose, 1e-3 * asked, True, self._small, self._work[:5], self._work[5])
            if not settled:
                break
            poses.append(pose.copy())
            openings.append(1e3 * opening_of(jaw, pose))
        return np.array(openings), np.array(poses)

    def hung(
        self, theta: Array, ends: Array, poses: Array, tone_N: float = 0.0, tilt_rad: float = 0.0, steps: int = 4
    ) -> Array:
        """Results of ``hang`` (K, 17) for one patient (12); ``poses`` (K, 5) move to equilibrium."""
        self._set(tone_N, tilt_rad)
        found = np.empty((len(ends), N_FOUND))
        first, second, third = self._jaws
        hang(first, second, third, self._law(theta), ends, poses, steps, self._linear, self._work, found)
        return found

    def forces(self, theta: Array, openings_mm: Array) -> Array:
        """Vertical forces (N) that hold a relaxed jaw (12) so far open; not-a-number beyond its branch."""
        reached, poses = self.path(theta, float(openings_mm.max()) + SPRING_MM)
        if len(reached) < 2:
            return np.full(len(openings_mm), np.nan)
        start = np.stack([np.interp(openings_mm, reached, poses[:, i]) for i in range(5)], -1)
        ends = 1e-3 * openings_mm
        for _ in range(3):  # the end at which the opening, and not the end, is the asked one
            found = self.hung(theta, ends, start, steps=12)
            ends = ends + (1e-3 * openings_mm - found[:, OPENING]) / found[:, BY_END]
        found = self.hung(theta, ends, start, steps=12)
        good = (found[:, RATE] < AT_REST) & (openings_mm <= reached[-1])
        return np.where(good, HOLD_STIFFNESS * (ends - found[:, OPENING]), np.nan)
