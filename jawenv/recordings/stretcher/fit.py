"""Posterior of the muscles from a force-opening log, by randomised maximum likelihood (Oliver, He & Reynolds 1996).

Unknown beside the twelve natural-log parameters are gain of the force, viscous drag, the teeth's place in the opening,
tone and tilt of the head. All are z, N(0, 1) before the log. Each draw solves

    min |(readings + noise - model(z, ends)) / sd|^2 + |z - z0|^2,  z0 ~ N(0, 1)

by Levenberg-Marquardt steps. The ends of the springs, one a window, are free, so both columns have errors. Of a linear
model the solutions are draws of the posterior. A normal about the best z is not: the posterior is a bent shell.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from jawenv.mechanics.equilibrium import HOLD_STIFFNESS
from jawenv.recordings.stretcher.log import Windows
from jawenv.recordings.stretcher.statics import (
    AT_REST,
    BY_END,
    BY_TILT,
    BY_TONE,
    N_FOUND,
    N_PARAMETERS,
    OPENING,
    RATE,
    Statics,
)

Array = NDArray[np.float64]

GAIN, DRAG, REFERENCE, TONE, TILT = range(N_PARAMETERS, N_PARAMETERS + 5)
N_UNKNOWN = N_PARAMETERS + 5
STARTS, START_SD = 6, 0.7
ITERATIONS, SMALL_GAIN, SMALL_DAMPING, LARGE_DAMPING = 60, 1e-3, 0.03, 1e3
LARGEST_STEP, LARGEST_END_STEP_M = 1.2, 3e-3
FLOOR_MM, FLOOR_N = 0.1, 0.1
"""Sds of errors of statics in a window."""
NO_REST_SDS = 3.0
"""Residual of a window without an equilibrium: the jaw runs over the crest."""
AS_GOOD = 3.0
"""Excess of cost up to which another mode begins draws too."""


@dataclass(frozen=True)
class Assumed:
    """Sds within which all but the muscles is known."""

    gain: float = 0.01  # of the force, 1
    drag_N_s_mm: float = 0.05
    reference_mm: float = 2.0  # where the teeth meet
    tone_N: float = 0.3  # of each muscle line
    tilt_deg: float = 5.0  # of the head

    @property
    def sds(self) -> Array:
        """(5,) in the order of the unknowns, tilt in rad."""
        return np.array([self.gain, self.drag_N_s_mm, self.reference_mm, self.tone_N, np.deg2rad(self.tilt_deg)])


@dataclass(frozen=True, eq=False)
class Solution:
    """Solved problems, one a row."""

    z: Array  # (D, 17)
    cost: Array  # (D,) half of the sum of squares
    poses: Array  # (D, K, 5)
    ends: Array  # (D, K) m

    def __getitem__(self, rows: NDArray[np.intp]) -> Solution:
        return Solution(self.z[rows], self.cost[rows], self.poses[rows], self.ends[rows])


class Fit:
    """Problems of one log under one normal prior of the muscles."""

    def __init__(self, statics: Statics, seen: Windows, mean: Array, sd: Array, assumed: Assumed) -> None:
        """Prepare; ``mean`` and ``sd`` (12) are of the natural logs."""
        self._statics, self._seen, self._mean, self._sd, self._sds = statics, seen, mean, sd, assumed.sds
        self._so, self._sf = np.hypot(seen.opening_sd, FLOOR_MM), np.hypot(seen.force_sd, FLOOR_N)

    def theta(self, z: Array) -> Array:
        """Natural-log parameters (..., 12)."""
        muscles: Array = self._mean + self._sd * z[..., :N_PARAMETERS]
        return muscles

    def modes(self, rng: np.random.Generator) -> Solution:
        """Best z from several beginnings, the best first; none where no jaw of this prior opens so far."""
        z = np.vstack([np.zeros(N_UNKNOWN), START_SD * rng.standard_normal((STARTS - 1, N_UNKNOWN))])
        begun = [self._begin(row) for row in z]
        opens = [i for i, poses in enumerate(begun) if poses is not None]
        seen, number = self._seen, len(opens)
        poses = np.array([begun[i] for i in opens]).reshape(number, len(seen.opening), 5)
        readings = np.repeat([[seen.opening, seen.force]], number, axis=0)
        ends = 1e-3 * np.maximum(readings[:, 0], 0.0) + readings[:, 1] / HOLD_STIFFNESS
        found = self._solve(z[opens], ends, poses, np.zeros((number, N_UNKNOWN)), readings)
        return found[np.argsort(found.cost)]

    def draws(self, modes: Solution, number: int, rng: np.random.Generator) -> Solution:
        """Solutions of perturbed problems, begun at the modes that are as good as the best."""
        good = np.flatnonzero(modes.cost < modes.cost[0] + AS_GOOD)
        start = modes[good[np.arange(number) % len(good)]]
        z0 = rng.standard_normal((number, N_UNKNOWN))
        noise = rng.standard_normal((number, 2, len(self._so))) * [self._so, self._sf]
        return self._solve(start.z, start.ends, start.poses, z0, [self._seen.opening, self._seen.force] + noise)

    def log_evidence(self, mode: Solution) -> float:
        """Laplace's, up to what all priors of one log share; ``mode`` is one row."""
        found = self._found(mode.z, mode.ends, mode.poses.copy(), 2)
        across, _, _ = self._linear(mode.z, found, self._forces(mode.ends, found))
        curvature = across[0].T @ across[0] + np.eye(N_UNKNOWN)
        return float(-mode.cost[0] - 0.5 * np.linalg.slogdet(curvature)[1])

    def _begin(self, z: Array) -> Array | None:
        """Poses (K, 5) of a jaw that is as far open as was read; None where its branch is too short to tell."""
        wanted = self._seen.opening
        reached, poses = self._statics.path(self.theta(z), float(wanted.max()))
        if len(reached) < 3:
            return None
        return np.stack([np.interp(wanted, reached, poses[:, i]) for i in range(5)], -1)

    def _found(self, z: Array, ends: Array, poses: Array, steps: int) -> Array:
        """Equilibria (D, K, 17); poses move."""
        found = np.empty((*ends.shape, N_FOUND))
        theta, tone, tilt = self.theta(z), self._sds[3] * z[:, TONE], self._sds[4] * z[:, TILT]
        for i in range(len(z)):
            found[i] = self._statics.hung(theta[i], ends[i], poses[i], float(tone[i]), float(tilt[i]), steps)
        return found

    def _forces(self, ends: Array, found: Array) -> Array:
        forces: Array = HOLD_STIFFNESS * (ends - found[..., OPENING])
        return forces

    def _residuals(self, z: Array, found: Array, force: Array, readings: Array) -> Array:
        """Opening and force less their readings, in sds (2, D, K)."""
        gain, drag, reference = (self._sds[i] * z[:, GAIN + i, None] for i in range(3))
        opening = 1e3 * found[..., OPENING] + reference - readings[:, 0]
        pull = (1.0 + gain) * force + drag * self._seen.speed - readings[:, 1]
        rests = found[..., RATE] < AT_REST
        return np.stack([np.where(rests, opening / self._so, NO_REST_SDS), np.where(rests, pull / self._sf, 0.0)])

    def _linear(self, z: Array, found: Array, force: Array) -> tuple[Array, Array, Array]:
        """Derivatives of the residuals by z across the curve (D, K, 17); by z of both; directions along the curve."""
        sds, shape = self._sds, (*force.shape, N_UNKNOWN)
        gain = (1.0 + sds[0] * z[:, GAIN])[:, None, None]
        opening = np.zeros(shape)
        opening[..., :N_PARAMETERS] = found[..., :N_PARAMETERS] * self._sd
        opening[..., TONE], opening[..., TILT] = found[..., BY_TONE] * sds[3], found[..., BY_TILT] * sds[4]
        by_force = -gain * HOLD_STIFFNESS * opening
        by_force[..., GAIN], by_force[..., DRAG] = sds[0] * force, sds[1] * self._seen.speed
        by_opening = 1e3 * opening
        by_opening[..., REFERENCE] = sds[2]
        both = np.stack([by_opening / self._so[:, None], by_force / self._sf[:, None]])
        both *= (found[..., RATE] < AT_REST)[..., None]
        by_end = found[..., BY_END]
        along = np.stack([1e3 * by_end / self._so, gain[..., 0] * HOLD_STIFFNESS * (1.0 - by_end) / self._sf])
        return _across(both, along), both, along

    def _solve(self, z: Array, ends: Array, poses: Array, z0: Array, readings: Array) -> Solution:
        """Levenberg-Marquardt steps of all problems at once, each until it gains no more."""
        z, ends, poses = z.copy(), ends.copy(), poses.copy()
        found = self._found(z, ends, poses, 12)
        force = self._forces(ends, found)
        residuals = self._residuals(z, found, force, readings)
        cost, damping = _cost(z - z0, residuals), np.full(len(z), 0.3)
        open_ = np.ones(len(z), dtype=bool)
        for _ in range(ITERATIONS):
            on = np.flatnonzero(open_)
            if not len(on):
                break
            step, end_step = self._step(z[on], z0[on], found[on], force[on], residuals[:, on], damping[on])
            tried, tried_ends, moved = z[on] + step, ends[on] + end_step, poses[on]
            new = self._found(tried, tried_ends, moved, 4)
            new_force = self._forces(tried_ends, new)
            new_residuals = self._residuals(tried, new, new_force, readings[on])
            new_cost = _cost(tried - z0[on], new_residuals)
            moved = np.where((new[..., RATE] < AT_REST)[..., None], moved, poses[on])
            good = new_cost < cost[on]
            done = (cost[on] - new_cost < SMALL_GAIN) & (damping[on] < SMALL_DAMPING)
            open_[on] = np.where(good, ~done, damping[on] < LARGE_DAMPING)
            damping[on] = np.where(good, 0.25 * damping[on], 4.0 * damping[on] + 1e-3).clip(1e-6, 1e4)
            to = on[good]
            z[to], ends[to], poses[to], found[to] = tried[good], tried_ends[good], moved[good], new[good]
            force[to], cost[to], residuals[:, to] = new_force[good], new_cost[good], new_residuals[:, good]
        return Solution(z, cost, poses, ends)

    def _step(
        self, z: Array, z0: Array, found: Array, force: Array, residuals: Array, damping: Array
    ) -> tuple[Array, Array]:
        """Damped Gauss-Newton steps of z (D, 17) and of the ends (D, K), which are eliminated."""
        across, both, along = self._linear(z, found, force)
        left = _across(residuals[..., None], along)
        curvature = across.swapaxes(1, 2) @ across + np.eye(N_UNKNOWN)
        diagonal = curvature[:, range(N_UNKNOWN), range(N_UNKNOWN)]
        curvature[:, range(N_UNKNOWN), range(N_UNKNOWN)] = (1.0 + damping[:, None]) * diagonal
        slope = (across.swapaxes(1, 2) @ left)[..., 0] + z - z0
        step = np.asarray(-np.linalg.solve(curvature, slope[..., None])[..., 0], dtype=np.float64)
        step *= np.minimum(1.0, LARGEST_STEP / np.abs(step).max(axis=1, keepdims=True))
        after = residuals + (both @ step[..., None])[..., 0]
        end_step = -(along * after).sum(axis=0) / (along**2).sum(axis=0)
        return step, end_step.clip(-LARGEST_END_STEP_M, LARGEST_END_STEP_M)


def _cost(off: Array, residuals: Array) -> Array:
    """Half of the sums of squares (D,) of what z is off and of the residuals (2, D, K)."""
    cost: Array = 0.5 * ((off**2).sum(axis=1) + (residuals**2).sum(axis=(0, 2)))
    return cost


def _across(both: Array, along: Array) -> Array:
    """Parts of (opening, force) vectors (2, D, K, n) that moving an end along the curve (2, D, K) cannot undo."""
    unit = along / np.sqrt((along**2).sum(axis=0))
    across: Array = unit[1][..., None] * both[0] - unit[0][..., None] * both[1]
    return across
