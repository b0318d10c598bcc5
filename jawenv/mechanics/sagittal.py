"""The jaw in the sagittal plane as a rigid body in contact: pymunk moves it, the compiled kernels give the forces.

The condyle is a circle that slides, rolls and may lift off a fossa made of segments; contact is one-sided and has
Coulomb friction. The midline model's condyle is bound to a smooth path without friction. The circle's centre follows
that same path z = d (cos f x - 1) while it touches, because the segments lie on the path's parallel curve. The teeth
are the midline model's springs.

Plane and signs: x forward, z up; theta and moments turn about +y (left), so theta > 0 opens: the chin goes down and
back. pymunk turns the other way, from x to z. Its space is in mm, kg and s, hence mN and mN mm: condyle and fossa are
then some units large, as its tolerances expect. Everything else here is SI.
"""

from __future__ import annotations

from collections.abc import Callable
from math import exp, isfinite
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from jawenv.anatomy import load_quantities
from jawenv.base.errors import InputError
from jawenv.base.extras import needs
from jawenv.mechanics.sagittal_forces import passive_forces, turned
from jawenv.mechanics.sagittal_shapes import CONDYLE, FOSSA, SLOP, BodyMotion, add_fossa, add_mandible, motion_of

with needs("JawSagittal", "pymunk", "sagittal"):
    import pymunk

__all__ = ["_CondyleContact", "Plane", "SagittalJaw", "WrenchAt"]

Plane = tuple[float, float]
WrenchAt = Callable[[Plane, Plane, float, float, float], tuple[float, float, float]]
"""``wrench_at(place, velocity, theta, theta_rate, since)`` -> (force forward, force up, pitch moment): place (m) and
velocity (m/s) of the mouthpiece in head axes, opening angle (rad) and its rate, seconds since ``advance`` was called;
force (N) in head axes on the mouthpiece, moment (N m) about +y at the mouthpiece."""

MM = 1e3
# By convergence of a slow opening's condyle path (tests/validation): 0.24 % of its range off the smooth path's, 0.12 %
# with half the segment; half the step changes it by 0.01 %.
STEP = 0.5e-3
SEGMENT = 0.01e-3
# Corner contacts have almost parallel normals, on which Gauss-Seidel is slow; there are never more than a few.
ITERATIONS = 20
# Overlap beyond the slop decays within 10 ms, by displacement alone: it gives the body no speed.
OVERLAP_TIME = 0.01


class _CondyleContact(NamedTuple):
    """Contact of condyle and fossa during the last ``advance``."""

    touching: bool  # at the last step
    share: float  # of the steps with contact, 0 to 1
    normal: float  # mean normal force (N), at least 0
    friction: float  # mean friction on the condyle (N), positive forward along the fossa


class SagittalJaw:
    """A mandible in the sagittal plane, in contact with its fossa.

    Args:
        jaw: Record from ``jawenv.mechanics.build_jaw``. Of lines outside the plane y = 0 the lateral force is left
            out, as it cancels between the sides.
        muscles: (n, 2) F_o (N) and b of the record's first n lines.
        friction: Coulomb's coefficient of condyle on fossa; a healthy joint's by default.
        condyle_radius: of the condyle (m); ``mandible.toml``'s by default.
        step: Time step (s).
        segment: Length of a fossa's segment along the condyle's path (m).
    """

    def __init__(
        self,
        jaw: Any,
        muscles: ArrayLike,
        *,
        friction: float | None = None,
        condyle_radius: float | None = None,
        step: float = STEP,
        segment: float = SEGMENT,
    ) -> None:
        bones, joint = load_quantities("mandible.toml"), load_quantities("fossa.toml")
        self.jaw = jaw.copy()
        self.muscles = np.array(muscles, dtype=np.float64)
        if self.muscles.ndim != 2 or self.muscles.shape[1] != 2 or len(self.muscles) > len(jaw["l_o"]):
            raise InputError(f"muscles has shape {self.muscles.shape}; allowed: (n, 2), n at most {len(jaw['l_o'])}")
        self.friction = float(joint["joint_friction"].si() if friction is None else friction)
        self.condyle_radius = float(bones["condyle_radius"].si() if condyle_radius is None else condyle_radius)
        self.step, self.segment = step, segment
        if not (isfinite(self.friction) and self.friction >= 0):
            raise InputError(f"friction is {self.friction}; allowed: numbers from 0 on")
        for name in ("step", "segment"):
            if not getattr(self, name) > 0:
                raise InputError(f"{name} is {getattr(self, name)}; allowed: numbers above 0")
        tightest = 1.0 / (self.jaw["fossa_drop"] * self.jaw["fossa_frequency"] ** 2)
        if not SLOP / MM < self.condyle_radius < tightest:
            raise InputError(f"condyle_radius is {self.condyle_radius}; allowed: 0 to the path's {tightest:.4g}")
        self.place(np.zeros(6))

    def place(self, state: ArrayLike) -> None:
        """Put the jaw at (x, z, theta, x', z', theta') of the condyle's centre: m, rad, m/s, rad/s.

        The space is built anew: what it remembers of former contacts would make equal episodes differ.
        """
        x, z, theta, x_rate, z_rate, theta_rate = np.asarray(state, dtype=np.float64).tolist()
        arm_x, arm_z = turned(self.jaw["centre_of_mass"], theta)
        position = MM * (x + arm_x), MM * (z + arm_z)
        velocity = MM * (x_rate + theta_rate * arm_z), MM * (z_rate - theta_rate * arm_x)
        self._build(BodyMotion(position, -theta, velocity, -theta_rate))
        self._touched, self._impulse, self._rub = False, 0.0, 0.0
        self._contact = _CondyleContact(False, 0.0, 0.0, 0.0)

    def _build(self, motion: BodyMotion) -> None:
        """A space with the fossa, and the mandible in ``motion``."""
        space = pymunk.Space()
        space.iterations = ITERATIONS
        space.collision_slop = SLOP
        space.collision_bias = exp(-1.0 / OVERLAP_TIME)  # the share of an overlap that is left after 1 s
        add_fossa(space, self.jaw, self.condyle_radius, self.segment)
        body = add_mandible(space, self.jaw, self.condyle_radius, self.friction, motion)
        space.on_collision(CONDYLE, FOSSA, post_solve=self._keep_contact)
        self._space, self._body = space, body

    def forget_contacts(self) -> None:
        """Go on from the present motion alone.

        pymunk remembers the last step's impulses, what is left of an overlap and the order of the contacts. None of it
        can be read, so a copy of the jaw goes on exactly like its original from here on, and not before.
        """
        motion = motion_of(self._body)
        self._space.remove(*self._body.shapes, self._body)
        self._body = add_mandible(self._space, self.jaw, self.condyle_radius, self.friction, motion)

    def __getstate__(self) -> dict[str, Any]:
        """All but pymunk's objects, of which the motion is kept: its own copies of a fossa have other corners."""
        state = {name: value for name, value in vars(self).items() if name not in ("_space", "_body")}
        return state | {"motion": motion_of(self._body)}

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Build the space anew around the motion."""
        motion = state.pop("motion")
        vars(self).update(state)
        self._build(motion)

    @property
    def state(self) -> NDArray[np.float64]:
        """(6,) x, z (m) of the condyle's centre, theta (rad) and their rates."""
        return np.array(self._state_after(0.0))

    @property
    def contact(self) -> _CondyleContact:
        """Contact of condyle and fossa during the last ``advance``."""
        return self._contact

    def advance(self, duration: float, wrench_at: WrenchAt | None = None) -> None:
        """Move the jaw.

        Args:
            duration: s, a multiple of the step.
            wrench_at: The device's force and moment on the mouthpiece at each step; none by default.
        """
        steps = round(duration / self.step)
        if steps < 1 or abs(steps * self.step - duration) > 1e-9:
            raise InputError(f"duration is {duration}; allowed: multiples of the step, {self.step}")
        touches = 0
        self._impulse = self._rub = 0.0
        for i in range(steps):
            self._touched = False
            self._apply_forces(wrench_at, (i + 1) * self.step)
            self._space.step(self.step)
            touches += self._touched
        newton = 1.0 / (MM * self.step * steps)
        self._contact = _CondyleContact(self._touched, touches / steps, newton * self._impulse, newton * self._rub)

    def _state_after(self, dt: float) -> tuple[float, float, float, float, float, float]:
        """State when the body has moved on for ``dt`` at its present speed."""
        body = self._body
        (x, z), (x_rate, z_rate), theta_rate = body.position, body.velocity, -body.angular_velocity
        theta = -body.angle + dt * theta_rate
        x, z, x_rate, z_rate = (x + dt * x_rate) / MM, (z + dt * z_rate) / MM, x_rate / MM, z_rate / MM
        arm_x, arm_z = turned(self.jaw["centre_of_mass"], theta)
        return x - arm_x, z - arm_z, theta, x_rate - theta_rate * arm_z, z_rate + theta_rate * arm_x, theta_rate

    def _apply_forces(self, wrench_at: WrenchAt | None, since: float) -> None:
        # A step of pymunk moves the body first and changes its speed then. With the forces of the place to which it
        # is about to move, this is the semi-implicit Euler method; those of the old place would feed energy in.
        x, z, theta, x_rate, z_rate, theta_rate = state = self._state_after(self.step)
        force_x, force_z, moment = passive_forces(self.jaw, self.muscles, state)
        if wrench_at is not None:
            arm_x, arm_z = turned(self.jaw["mouthpiece"], theta)
            velocity = (x_rate + theta_rate * arm_z, z_rate - theta_rate * arm_x)
            pull_x, pull_z, turn = wrench_at((x + arm_x, z + arm_z), velocity, theta, theta_rate, since)
            force_x, force_z = force_x + pull_x, force_z + pull_z
            moment += turn + arm_z * pull_x - arm_x * pull_z
        arm_x, arm_z = turned(self.jaw["centre_of_mass"], theta)
        self._body.force = MM * force_x, MM * force_z
        self._body.torque = -MM * MM * (moment - arm_z * force_x + arm_x * force_z)

    def _keep_contact(self, arbiter: pymunk.Arbiter, space: pymunk.Space, data: Any) -> None:
        self._touched = True
        outward, impulse = arbiter.normal, arbiter.total_impulse
        across = outward.dot(impulse)
        self._impulse += abs(across)
        # The impulse on the condyle points away from the fossa; the same sign holds for its share along the surface.
        along = outward.y * impulse.x - outward.x * impulse.y
        self._rub += -along if across > 0.0 else along
