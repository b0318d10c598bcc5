"""The midline jaw in torch: generalised forces, their stiffness, and what a reading tells about the muscles.

A force f acts along the unit vector e at the arm r from the contact point. As a wrench it is f w with w = (e, r x e),
and the coordinates q = (x, y, theta, psi, alpha) move the mandible by the twists Z (5, 6): slides along the fossa and
turns about three axes a. With the stiffness S = k_e e e^T + k_1 1 of each force, G = (1, -[r]x) and M = sum r f^T,

    Q = Z sum f w                                                        generalised force
    K = -dQ/dq = Z (sum k_e w w^T + k_1 G^T G) Z^T - H                   stiffness
    H = a_i M a_j^T - tr(M) a_i a_j^T between turns, i outside of j      that of the axes, which turn too

A jaw that moves slowly is in equilibrium, Q(q) + (device) = 0, and one Newton step K^-1 Q follows it. A reading
compares both sides of that equation. It is linear in the tensions T. Its noise is the unmodelled wrench, of variance V,
and what the encoders' error of q, of covariance E, is in terms of force:

    A = L^-1 [Q_1 T_1, Q_1 T_1 b_1 s_1, ...; Q],   L L^T = J V J^T + K E K^T,   information A^T A

with s the strain and J (5, 6) the derivative of the mouthpiece's motion. The last column is the load cell's gain.

The unmodelled wrench shakes a jaw that is held still, with a covariance C of q, K C D + D C K = J V J^T dt for a
damping D. A jaw that is shaken tells how stiff it is: Q_m T_m changes by -k_m Q_m Q_m^T dq, and muscles m and n share
the information k_m k_n (Q_m^T N^-1 Q_n) (Q_m^T C Q_n), with N the noise of quick motion.
Every tensor may have leading axes of worlds, written (...).
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any, NamedTuple

import numpy as np
import torch
from torch import Tensor

N_MUSCLES, N_TEETH = 6, 3
SLOWEST_RATE = 3.0  # 1/s
_CROSS = torch.zeros(3, 3, 3, dtype=torch.float64)
for _i, _j, _k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
    _CROSS[_i, _j, _k], _CROSS[_i, _k, _j] = 1.0, -1.0
_Z = torch.tensor([0.0, 0.0, 1.0], dtype=torch.float64)


class Forces(NamedTuple):
    """Generalised forces."""

    force: Tensor  # (..., 5)
    stiffness: Tensor  # (..., 5, 5) minus their derivative by q

    def __add__(self, other: Any) -> Forces:
        """Both together."""
        return Forces(self.force + other.force, self.stiffness + other.stiffness)


class Pose(NamedTuple):
    """Place of the mandible."""

    q: Tensor  # (..., 5)
    contact: Tensor  # (..., 3) midpoint of the condyles, head axes
    turned: Tensor  # (..., 3, 3) body to head axes
    twists: Tensor  # (..., 5, 6) Z
    curvature: Tensor  # (...,) of the fossa

    def arms(self, body: Tensor) -> Tensor:
        """(..., n, 3) from the contact point to points (n, 3) of the body."""
        return body @ self.turned.mT

    def motion(self, arm: Tensor) -> Tensor:
        """J (..., 5, 6): derivative of the place and turn of a point at an arm (..., 3)."""
        slide, turn = self.twists[..., :3], self.twists[..., 3:]
        return torch.cat([slide + torch.linalg.cross(turn, arm[..., None, :].expand(turn.shape)), turn], -1)


class Passive(NamedTuple):
    """Loads that the jaw carries without the device."""

    forces: Forces  # of muscles, teeth, weight and capsule
    tension: Tensor  # (..., 6) passive tensions, N
    strain: Tensor  # (..., 6) of the lines
    columns: Tensor  # (..., 5, 12) derivatives of the generalised force by log F_o and log b of each muscle
    units: Tensor  # (..., 5, 6) generalised force of 1 N along each line, Q_m
    stretching: Tensor  # (..., 6, 2) derivatives of T and T b s by the length, k
    gap: Tensor  # (...,) of the nearest tooth, m
    bite_force: Tensor  # (...,) force of all teeth, N


def norm(vector: Tensor) -> Tensor:
    """Length of the last axis, with a derivative at zero."""
    return (vector.square().sum(-1) + 1e-12).sqrt()


def ramp(depth: Tensor, width: Tensor | float) -> tuple[Tensor, Tensor]:
    """Depth of a one-sided stop with a quadratic onset over ``width``, and its slope."""
    inside = torch.minimum(depth.clamp(min=0.0), torch.as_tensor(width, dtype=depth.dtype, device=depth.device))
    return inside * inside / (2.0 * width) + (depth - width).clamp(min=0.0), inside / width


def wrenches(arm: Tensor, e: Tensor) -> Tensor:
    """W (..., n, 6) of unit forces along ``e`` at arms (..., n, 3)."""
    e = e.expand(arm.shape)
    return torch.cat([e, torch.linalg.cross(arm, e)], -1)


def forces(pose: Pose, arm: Tensor, f: Tensor, rows: Tensor, k: Tensor) -> Forces:
    """Generalised forces of ``f`` (..., n, 3) at arms, with the wrench stiffness rows^T k rows of (..., m, 6)."""
    Z, axes = pose.twists, pose.twists[..., 2:, 3:]
    total = f.sum(-2)
    wrench = torch.cat([total, torch.linalg.cross(arm, f).sum(-2)], -1)
    moved = rows @ Z.mT
    M = arm.mT @ f
    trace = M.diagonal(dim1=-2, dim2=-1).sum(-1)[..., None, None]
    upper = (axes @ (M - trace * torch.eye(3, dtype=M.dtype, device=M.device)) @ axes.mT).triu()
    between = upper + upper.triu(1).mT
    sliding = torch.nn.functional.pad((total[..., 2] * pose.curvature)[..., None, None], (0, 4, 0, 4))
    H = torch.nn.functional.pad(between, (2, 0, 2, 0)) + sliding
    return Forces((Z @ wrench[..., None])[..., 0], moved.mT @ (k[..., None] * moved) - H)


@dataclass(frozen=True)
class Jaw:
    """Constants of one anatomy, or of one for each world, as ``jawenv.mechanics.jaw.Jaw`` has them; SI units."""

    mass: Tensor
    gravity: Tensor
    fossa_drop: Tensor
    fossa_frequency: Tensor
    tone: Tensor
    crest: Tensor
    stop_width: Tensor
    tooth_stiffness: Tensor
    condyle_stiffness: Tensor
    centre_of_mass: Tensor
    teeth: Tensor
    mouthpiece: Tensor
    origin: Tensor
    insertion: Tensor
    l_o: Tensor

    @classmethod
    def of(cls, record: Any) -> Jaw:
        """The jaw of a record or records (...) of dtype ``jaw_dtype``."""
        values = {field.name: np.array(record[field.name], dtype=np.float64) for field in fields(cls)}
        return cls(**{name: torch.tensor(value) for name, value in values.items()})

    def __getitem__(self, chosen: Any) -> Jaw:
        return Jaw(**{field.name: getattr(self, field.name)[chosen] for field in fields(self)})

    @property
    def weight(self) -> Tensor:
        """(..., 3) of the mandible."""
        return self.mass[..., None] * self.gravity

    def pose(self, q: Tensor) -> Pose:
        """Geometry of a pose (..., 5)."""
        d, f = self.fossa_drop, self.fossa_frequency
        x, y = q[..., 0], q[..., 1]
        (st, sp, sa), (ct, cp, ca) = q[..., 2:].sin().unbind(-1), q[..., 2:].cos().unbind(-1)
        stsp, ctsp = st * sp, ct * sp
        first = (ct * cp, st * sa - ctsp * ca, ctsp * sa + st * ca)
        second, third = (sp, cp * ca, -cp * sa), (-st * cp, stsp * ca + ct * sa, ct * ca - stsp * sa)
        turned = torch.stack(first + second + third, -1).reshape(*x.shape, 3, 3)
        zero, one, cosine = torch.zeros_like(x), torch.ones_like(x), (f * x).cos()
        slides = (one, zero, -d * f * (f * x).sin(), zero, zero, zero, zero, one, zero, zero, zero, zero)
        turns = (zero, zero, zero, zero, one, zero, zero, zero, zero, st, zero, ct)
        last = (zero, zero, zero, first[0], second[0], third[0])
        twists = torch.stack(slides + turns + last, -1).reshape(*x.shape, 5, 6)
        contact = torch.stack([x, y, d * (cosine - 1.0)], -1)
        return Pose(q, contact, turned, twists, -d * f * f * cosine)

    def passive(self, pose: Pose, theta: Tensor) -> Passive:
        """Muscles of natural-log parameters ``theta`` (..., 12), teeth, weight and capsule at a pose."""
        body = torch.cat([self.insertion, self.teeth, self.centre_of_mass[..., None, :]], -2)
        arm = pose.arms(body)
        places = pose.contact[..., None, :] + arm
        line = self.origin - places[..., :N_MUSCLES, :]
        length = line.norm(dim=-1)
        e = line / length[..., None]
        F_o, b = theta[..., 0::2].exp(), theta[..., 1::2].exp()
        strain = length / self.l_o - 1.0
        exponent = b * strain
        tension = F_o * exponent.exp()
        pull = tension + self.tone[..., None]
        across = pull / length  # a line's own turning; along the line the material stretches
        gaps = self.teeth[..., 2] - places[..., N_MUSCLES:-1, 2]
        stiffness = self.tooth_stiffness[..., None]
        depth, slope = ramp(-gaps, self.stop_width[..., None])
        weight = self.weight[..., None, :].expand(arm[..., :1, :].shape)
        f = torch.cat([pull[..., None] * e, -(stiffness * depth)[..., None] * _Z.to(e.device), weight], -2)
        units = wrenches(arm[..., :-1, :], torch.cat([e, _Z.to(e.device).expand(*e.shape[:-2], N_TEETH, 3)], -2))
        skew = torch.tensordot(arm[..., :N_MUSCLES, :], _CROSS.to(arm.device), 1)  # -[r]x
        G = torch.cat([torch.eye(3, dtype=skew.dtype, device=skew.device).expand(skew.shape), skew], -1).flatten(-3, -2)
        k = (tension * b / self.l_o - across, stiffness * slope, across.repeat_interleave(3, -1))
        carried = forces(pose, arm, f, torch.cat([units, G], -2), torch.cat(k, -1))
        unit = pose.twists @ units[..., :N_MUSCLES, :].mT
        columns = unit[..., None] * torch.stack([tension, tension * exponent], -1)[..., None, :, :]
        k = tension * b / self.l_o
        parts = columns.flatten(-2), unit, torch.stack([k, k * (1.0 + exponent)], -1)
        return Passive(
            carried + self._capsule(pose.q),
            tension,
            strain,
            *parts,
            gaps.amin(-1),
            self.tooth_stiffness * depth.sum(-1),
        )

    def _capsule(self, q: Tensor) -> Forces:
        back, back_slope = ramp(-q[..., 0], self.stop_width)
        front, front_slope = ramp(q[..., 0] - self.crest, self.stop_width)
        k = self.condyle_stiffness
        stiffness = (k * (back_slope + front_slope))[..., None, None]
        force = torch.nn.functional.pad((k * (back - front))[..., None], (0, 4))
        return Forces(force, torch.nn.functional.pad(stiffness, (0, 4, 0, 4)))


def force_noise(passive: Passive, J: Tensor, wrench_variance: Tensor, encoder_sd: Tensor) -> Tensor:
    """J V J^T + K E K^T (..., 5, 5).

    Args:
        passive: at the pose.
        J: (..., 5, 6) of the mouthpiece.
        wrench_variance: (..., 6) V.
        encoder_sd: (6,) of its place and turn.
    """
    K, seen = passive.forces.stiffness, J / encoder_sd
    E = torch.linalg.inv(seen @ seen.mT)
    noise: Tensor = (J * wrench_variance[..., None, :]) @ J.mT + K @ E @ K.mT
    return noise


def shaking(stiffness: Tensor, damping: Tensor, intensity: Tensor) -> Tensor:
    """C (..., 5, 5) of a jaw that white noise of so much intensity shakes; where it is unstable, of a slow one."""
    root = torch.linalg.inv(torch.linalg.cholesky(damping))
    rate, modes = torch.linalg.eigh(root @ stiffness @ root.mT)
    rate, modes = rate.clamp(min=SLOWEST_RATE), root.mT @ modes
    C: Tensor = modes @ (modes.mT @ intensity @ modes / (rate[..., None] + rate[..., None, :])) @ modes.mT
    return C


def shaken_information(passive: Passive, C: Tensor, noise: Tensor) -> Tensor:
    """Information (..., 12, 12) of a reading of a jaw that is shaken; ``noise`` (..., 5, 5) is N."""
    units = passive.units
    whitened = torch.linalg.solve_triangular(torch.linalg.cholesky(noise), units, upper=False)
    shared = (whitened.mT @ whitened) * (units.mT @ C @ units)
    k = passive.stretching.flatten(-2)
    information: Tensor = shared.repeat_interleave(2, -1).repeat_interleave(2, -2) * k[..., None] * k[..., None, :]
    return information
