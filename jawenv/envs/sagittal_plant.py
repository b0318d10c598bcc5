"""pymunk's jaw as a plant: it asks for the wrench of the place to which it is about to move."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from jawenv.envs.moved_plants import WrenchOn
from jawenv.kernels.compiled import njit
from jawenv.kernels.vec3 import apply
from jawenv.mechanics.kinematics import rotation
from jawenv.mechanics.plant import BodyMotion, PatientJaw, body_motion
from jawenv.mechanics.sagittal import Plane, SagittalJaw
from jawenv.mechanics.sagittal_forces import turned


class SagittalPlant:
    """A ``SagittalJaw``, of the patient of the episode."""

    def begin(self, patient: PatientJaw, rng: np.random.Generator) -> BodyMotion:
        """Put the jaw on its fossa, at rest where the midline model rests."""
        self._jaw = SagittalJaw(patient.jaw, np.column_stack([patient.F_o_N, patient.b]))
        (x, _, z, theta, _, _), _ = body_motion(patient.rest, patient.jaw["mouthpiece"])
        self._jaw.place((x, z, theta, 0.0, 0.0, 0.0))
        return self._motion()

    def advance(self, duration: float, wrench_on: WrenchOn) -> BodyMotion:
        """Move the jaw through ``duration`` (s)."""
        mouthpiece, step = self._jaw.jaw["mouthpiece"], self._jaw.step

        def wrench_at(place: Plane, velocity: Plane, theta: float, rate: float, since: float) -> Any:
            x, z, x_rate, z_rate = _condyle_motion(mouthpiece, place, velocity, theta, rate)
            return in_plane(
                wrench_on(_in_space(x, z, theta, x_rate, z_rate, rate), since, since - 0.5 * step, step), theta
            )

        self._jaw.advance(duration, wrench_at)
        return self._motion()

    def begin_step(self) -> None:
        """So that a copy of the environment, made between two steps, goes on alike."""
        self._jaw.forget_contacts()

    def take_muscles(self, muscles: NDArray[np.float64]) -> None:
        """F_o and b (lines, 2) of the coming tick."""
        self._jaw.muscles[:] = muscles

    def _motion(self) -> BodyMotion:
        return _in_space(*self._jaw.state.tolist())


def _in_space(x: float, z: float, theta: float, x_rate: float, z_rate: float, theta_rate: float) -> BodyMotion:
    """A motion in the sagittal plane as that of a free mandible."""
    return (x, 0.0, z, theta, 0.0, 0.0), (x_rate, 0.0, z_rate, 0.0, theta_rate, 0.0)


@njit
def _condyle_motion(mouthpiece: Any, place: Any, velocity: Any, theta: Any, theta_rate: Any) -> Any:
    """Place and velocity in the plane of the condyle's centre, of a mouthpiece's."""
    arm_x, arm_z = turned(mouthpiece, theta)
    x_rate, z_rate = velocity[0] - theta_rate * arm_z, velocity[1] + theta_rate * arm_x
    return place[0] - arm_x, place[1] - arm_z, x_rate, z_rate


@njit
def in_plane(wrench: Any, theta: Any) -> Any:
    """Force forward and up (N, head axes) and pitch moment (N m) of a wrench (6, body axes)."""
    force = apply(rotation((0.0, 0.0, theta, 0.0, 0.0)), (wrench[0], wrench[1], wrench[2]))
    return force[0], force[2], wrench[4]
