"""The muscles' moments from the jaw's measured motion: d = g(p), Young (2016), eqs. 5.4, 5.5, 5.11-5.13.

From motion and measured wrench the equations of motion leave only the muscles unknown. Corrected: moments are taken
about the contact point with arms measured from it; gravity, damping and the mass's acceleration m rho x C a_* are in;
the spurious m v_c x v_* is not. Young has the three moments only. The two equations of force along the fossa do not
know the normal force either, and need no more measurements: rows "all".

The dominant noise of d is force noise, independent in each tick. Momentum gained in a tick is the mean force in it
exactly, so accelerations are differences of the measured rates over a tick, and all else is the mean over it. All are
then smoothed by one and the same filter of Savitzky & Golay (1964), a local parabola, so that the equation holds of the
smoothed values too, but for the curvature of g over the window; and thinned.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from scipy.signal import savgol_coeffs, savgol_filter

from eval.thesis.methods.inverse_kinematics import (
    N_COORDINATES,
    acceleration_from_mouthpiece,
    motion_from_pose,
)
from jawenv.base.errors import InputError
from jawenv.kernels.compiled import njit
from jawenv.kernels.vec3 import add, apply, apply_transposed, cross, scale, subtract, vector3
from jawenv.mechanics.dynamics import N_WRENCH, body_moment, inertia_times
from jawenv.mechanics.forces import muscle_pull, resultant
from jawenv.mechanics.jaw import Jaw
from jawenv.mechanics.kinematics import contact_point, fossa, rotation, split
from jawenv.recordings.record import Record

Array = NDArray[np.float64]
Rows = Literal["moment", "all"]
FORCE_ROWS, MOMENT_ROWS = (0, 1), (2, 3, 4)
SMOOTHING_S = 0.2
"""Window of the smoothing, made an odd number of ticks, at least 3, which smooth nothing."""
SIMPSON = np.array([1.0, 4.0, 1.0]) / 6.0


@njit
def _fill_balance(jaw: Jaw, no_muscles, motions, needed, by_wrench, pull, strain):
    """Rows of N times: ``needed`` (N, 5), ``by_wrench`` (N, 5, 6), ``pull`` (N, lines, 5), ``strain`` (N, lines).

    Rows 0, 1: force along the two tangents of the fossa (N); rows 2 to 4: moment about the contact point, body axes
    (N m). ``no_muscles`` (lines, 2) is zeros: all forces but the muscles' and the device's then remain. ``motions`` are
    states (N, 10), accelerations (N, 5) and wrenches (N, 6).
    """
    states, accelerations, wrenches = motions
    rho, mouthpiece = vector3(jaw.centre_of_mass), vector3(jaw.mouthpiece)
    units = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    no_wrench = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    for n in range(states.shape[0]):
        q, u = split(states[n])
        body_to_head = rotation(q)
        _, slope, curvature, _ = fossa(jaw, q[0])
        omega = (u[2], u[3], u[4])
        turning = (accelerations[n, 2], accelerations[n, 3], accelerations[n, 4])
        swing = add(cross(turning, rho), cross(omega, cross(omega, rho)))
        ahead, aside = accelerations[n, 0], accelerations[n, 1]
        contact_acceleration = (ahead, aside, slope * ahead + curvature * u[0] * u[0])
        centre_acceleration = add(contact_acceleration, apply(body_to_head, swing))
        force, moment = resultant(jaw, no_muscles, q, u, body_to_head)
        net = subtract(scale(jaw.mass, centre_acceleration), force)
        turn = add(inertia_times(jaw, turning), cross(omega, inertia_times(jaw, omega)))
        turn = add(turn, scale(jaw.mass, cross(rho, apply_transposed(body_to_head, centre_acceleration))))
        turn = subtract(turn, body_moment(jaw, body_to_head, moment, omega, no_wrench))
        needed[n, 0], needed[n, 1] = net[0] + slope * net[2], net[1]
        for i in range(3):
            needed[n, 2 + i] = turn[i]
        for j in range(3):
            push = apply(body_to_head, units[j])
            twist = cross(mouthpiece, units[j])
            by_wrench[n, 0, j], by_wrench[n, 1, j] = push[0] + slope * push[2], push[1]
            by_wrench[n, 0, 3 + j], by_wrench[n, 1, 3 + j] = 0.0, 0.0
            for i in range(3):
                by_wrench[n, 2 + i, j] = twist[i]
                by_wrench[n, 2 + i, 3 + j] = units[j][i]
        for i in range(5):
            for j in range(6):
                needed[n, i] -= by_wrench[n, i, j] * wrenches[n, j]
        contact = contact_point(jaw, q)
        for line in range(no_muscles.shape[0]):
            arm, direction, length, _ = muscle_pull(jaw, no_muscles, line, contact, body_to_head)
            twist = apply_transposed(body_to_head, cross(arm, direction))
            pull[n, line, 0], pull[n, line, 1] = direction[0] + slope * direction[2], direction[1]
            for i in range(3):
                pull[n, line, 2 + i] = twist[i]
            strain[n, line] = length / jaw.l_o[line] - 1.0


@dataclass(frozen=True, eq=False)
class Balance:
    """N times r equations needed = sum over lines of pull times tension, of m muscles with one or more lines each."""

    needed: Array  # (N, r) what the muscles must have exerted: force (N) or moment (N m)
    noise: Array  # (r, r) covariance of the noise that the unknown wrench alone makes of one time's rows
    pull: Array  # (N, lines, r) what a line with 1 N exerts
    strain: Array  # (N, lines) (l - l_o)/l_o
    muscle: NDArray[np.int64]  # (lines,) whose F_o and b a line has

    @property
    def muscles(self) -> int:
        """M."""
        return int(self.muscle.max()) + 1

    def whitened(self, noise: Array) -> Balance:
        """The same with rows of unit noise that is independent of each other's; ``noise`` (r, r) as it is now."""
        inverse = np.linalg.inv(np.linalg.cholesky(noise))
        return replace(
            self,
            needed=self.needed @ inverse.T,
            pull=self.pull @ inverse.T,
            noise=inverse @ self.noise @ inverse.T,
        )

    def select(self, times: NDArray[np.bool_]) -> Balance:
        """The equations of some of the times (N,)."""
        arrays = {name: getattr(self, name)[times] for name in ("needed", "pull", "strain")}
        return replace(self, **arrays)

    def sum_lines(self, per_line: Array) -> Array:
        """Sum over the lines of each muscle: (N, lines, r) to (N, m, r)."""
        result = np.zeros((len(per_line), self.muscles, per_line.shape[2]))
        for line, muscle in enumerate(self.muscle):
            result[:, muscle] += per_line[:, line]
        return result


def balance(jaw: Any, states: Array, accelerations: Array, wrenches: Array) -> tuple[Array, Array, Array, Array]:
    """The equations at N times, of motion and wrench as given.

    Args:
        jaw: Record from ``build_jaw`` of the midline model.
        states: (N, 10) motion (q, u).
        accelerations: (N, 5) u'.
        wrenches: (N, 6) of the device on the mouthpiece, body axes (N, N m).

    Returns:
        (N, 5) needed, (N, 5, 6) its derivative by the wrench with the sign changed, (N, lines, 5) pull of 1 N,
        (N, lines) strain. Rows as in ``_fill_balance``.
    """
    number, lines = len(states), len(jaw["l_o"])
    needed, by_wrench = np.empty((number, N_COORDINATES)), np.empty((number, N_COORDINATES, N_WRENCH))
    pull, strain = np.empty((number, lines, N_COORDINATES)), np.empty((number, lines))
    motions = tuple(np.ascontiguousarray(array) for array in (states, accelerations, wrenches))
    _fill_balance(jaw, np.zeros((lines, 2)), motions, needed, by_wrench, pull, strain)
    return needed, by_wrench, pull, strain


def balance_of(record: Record, *, rows: Rows = "all") -> Balance:
    """The equations that a record gives, smoothed, at times half a smoothing window apart.

    Args:
        record: of the midline model, with the whole pose measured.
        rows: the three moments (Young 2016) or the two forces along the fossa too; of a coordinate that cannot move
            there is none, whatever holds it being unknown.
    """
    record.require_exact("balance of moments")
    if not (np.isfinite(record.measured).all() and np.isfinite(record.samples).all()):
        raise InputError("record holds a value that was not read; allowed: pose and rates at all times, and wrenches")
    ticks = len(record.samples)
    window = max(3, 2 * round(SMOOTHING_S / record.dt / 2) + 1)
    if window > ticks:
        raise InputError(f"record has {ticks * record.dt:g} s; allowed: {SMOOTHING_S:g} s or more")
    half = window // 2

    def smooth(values: Array) -> Array:
        smoothed = savgol_filter(values, window, 2, axis=0)
        thinned: Array = smoothed[half : ticks - half : half]
        return thinned

    measured = smooth(0.5 * (record.measured[1:] + record.measured[:-1]))
    rates = record.measured[:, 6:]
    accelerations = smooth((rates[1:] - rates[:-1]) / record.dt)
    wrenches = smooth(np.einsum("s,tsk->tk", SIMPSON, record.samples))
    states = motion_from_pose(record.jaw, measured, record.measurement_sd, record.start_mean, record.start_sd)
    # Of the speeds, so that they stand for x', y' and body axes 1, 2, 3 in this order.
    free = record.start_sd[N_COORDINATES:] > 0.0
    turned = acceleration_from_mouthpiece(record.jaw, states, accelerations, record.measurement_sd[6:], free)
    needed, by_wrench, pull, strain = balance(record.jaw, states, turned, wrenches)
    used_rows = [i for i in (*FORCE_ROWS, *MOMENT_ROWS) if free[i] and (rows == "all" or i in MOMENT_ROWS)]
    noise = np.einsum("nij,j,nkj->ik", by_wrench, record.wrench_sd**2, by_wrench) / len(states)
    noise *= np.sum(savgol_coeffs(window, 2) ** 2)
    return Balance(
        needed=needed[:, used_rows],
        noise=noise[np.ix_(used_rows, used_rows)],
        pull=pull[:, :, used_rows],
        strain=strain,
        muscle=np.asarray(record.jaw["muscle"], dtype=np.int64),
    )
