"""Nuisances, known within sds only: how one sd of each changes the generalised force and the encoders' readings.

A nuisance v has the prior N(0, 1), and what one sd of it changes in the jaw is read from the filter's settings. The
encoders read y = h(q, v) with the variance R. With the derivatives h_q and h_v, and E = (h_q^T R^-1 h_q)^-1, a pose
that is read depends on v by -E h_q^T R^-1 h_v. So the force left over at given readings depends on it by

    dQ/dv + K E h_q^T R^-1 h_v,   and what no pose explains is   (1 - h_q E h_q^T R^-1) h_v.

A line from its insertion p to its origin o, along e, l long, of tension T, has dl = e (do - dp) and pulls by

    df = T b (dl / l_o - l dl_o / l_o^2) e + (T + tone) / l (1 - e e^T) (do - dp),   moment r x df + dp x (T + tone) e

more. Every tensor may have leading axes of worlds, written (...); m is the number of nuisances that a jaw at rest
shows.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import Any, NamedTuple

import numpy as np
import torch
from torch import Tensor

from agents.twin.mechanics import Jaw, Passive, Pose

STEP = 1e-2
"""Sds of the differences that stand for derivatives by the fossa."""


class Columns(NamedTuple):
    """Derivatives by the nuisances, in sds."""

    force: Tensor  # (..., 5, m) of the generalised force left over at given readings
    readings: Tensor  # (..., 6, m) of what no pose explains in the encoders' place and angles, in their sds


@dataclass(frozen=True)
class Nuisances:
    """Changes per sd, named as ``jawenv.filter.belief.state.Nuisances``: tensors with m leading."""

    mass: Tensor
    first_moment: Tensor
    gravity: Tensor
    tone: Tensor
    fossa_drop: Tensor
    fossa_frequency: Tensor
    mouthpiece: Tensor
    origin: Tensor
    insertion: Tensor
    l_o: Tensor
    offset: Tensor
    turn: Tensor
    cell_turn: Tensor
    line: Tensor

    @classmethod
    def of(cls, record: Any) -> Nuisances:
        """The nuisances in a record of dtype ``nuisance_dtype`` that a jaw at rest shows: the twin is quasi-static."""
        shown = record["at_rest"].astype(bool)
        return cls(**{field.name: torch.tensor(np.array(record[field.name][shown])) for field in fields(cls)})

    def __len__(self) -> int:
        return len(self.mass)

    def columns(
        self, jaw: Jaw, pose: Pose, passive: Passive, theta: Tensor, device: Tensor, encoder_sd: Tensor
    ) -> Columns:
        """The derivatives at a pose.

        Args:
            jaw: the anatomy, or that of each world.
            pose: of the jaw.
            passive: at the pose.
            theta: (..., 12) parameters.
            device: (..., 6) force and moment at the mouthpiece, head axes.
            encoder_sd: (6,) of place and angles.
        """
        arm = pose.arms(jaw.mouthpiece[..., None, :])[..., 0, :]
        J = pose.motion(arm)
        wrench = self._of_lines(jaw, pose, theta) + self._of_body(jaw, pose, device)
        force = pose.twists @ wrench.mT + J @ self._of_cell(pose, device).mT + self._of_tone(passive)
        readings = self._seen(jaw, pose)
        with torch.no_grad():
            force = force + self._of_fossa(jaw, pose, passive, theta, device)
        by_pose = torch.cat(
            [J[..., :3], torch.eye(5, dtype=J.dtype, device=J.device)[:, 2:].expand(*J.shape[:-2], 5, 3)], -1
        ).mT
        by_pose, seen = by_pose / encoder_sd[:, None], readings / encoder_sd[:, None]
        explained = torch.linalg.solve(by_pose.mT @ by_pose, by_pose.mT @ seen)
        return Columns(force + passive.forces.stiffness @ explained, seen - by_pose @ explained)

    def _of_lines(self, jaw: Jaw, pose: Pose, theta: Tensor) -> Tensor:
        """(..., m, 6) force and moment about the contact point of the lines whose ends move."""
        chosen = (self.line >= 0).nonzero()[:, 0]
        line = self.line[chosen]
        arm = pose.arms(jaw.insertion[..., line, :])
        way = jaw.origin[..., line, :] - pose.contact[..., None, :] - arm
        length = way.norm(dim=-1, keepdim=True)
        e, l_o = way / length, jaw.l_o[..., line, None]
        F_o, b = theta[..., 0::2][..., line, None].exp(), theta[..., 1::2][..., line, None].exp()
        tension = F_o * (b * (length / l_o - 1.0)).exp()
        whole = tension + jaw.tone[..., None, None]
        origin, insertion = (ends.reshape(len(self), -1, 3)[chosen, line] for ends in (self.origin, self.insertion))
        shift = pose.arms(insertion)
        change = origin - shift
        longer = (e * change).sum(-1, keepdim=True)
        stretch = longer / l_o - length * self.l_o[chosen, line, None] / l_o**2
        pull = tension * b * stretch * e + whole / length * (change - longer * e)
        moment = torch.linalg.cross(arm, pull) + torch.linalg.cross(shift, whole * e)
        result = arm.new_zeros(*arm.shape[:-2], len(self), 6)
        return result.index_copy(-2, chosen, torch.cat([pull, moment], -1))

    def _of_body(self, jaw: Jaw, pose: Pose, device: Tensor) -> Tensor:
        """(..., m, 6) the same of weight, of the head's tilt, and of a mouthpiece that sits elsewhere."""
        force = self.mass[:, None] * jaw.gravity[..., None, :] + jaw.mass[..., None, None] * self.gravity
        shape = (*pose.contact.shape[:-1], len(self), 3)
        moment = torch.linalg.cross(pose.arms(self.first_moment), jaw.gravity[..., None, :].expand(shape))
        centre = pose.arms((jaw.mass[..., None] * jaw.centre_of_mass)[..., None, :])
        moment = moment + torch.linalg.cross(centre.expand(shape), self.gravity.expand(shape))
        moment = moment + torch.linalg.cross(pose.arms(self.mouthpiece), device[..., None, :3].expand(shape))
        return torch.cat([force.expand(shape), moment], -1)

    def _of_cell(self, pose: Pose, device: Tensor) -> Tensor:
        """(..., m, 6) force and moment at the mouthpiece that an offset and turned axes hide."""
        body = torch.stack([device[..., :3], device[..., 3:]], -2) @ pose.turned
        shape = (*body.shape[:-2], len(self), 3)
        axes = self.cell_turn.expand(shape)
        force, moment = (torch.linalg.cross(axes, body[..., k : k + 1, :].expand(shape)) for k in range(2))
        x, y, opening, yaw = (pose.q[..., k] / scale for k, scale in enumerate((5e-3, 3e-3, 0.2, 0.05)))
        shapes = torch.stack([torch.ones_like(x), opening, opening**2, x, y, yaw], -1)  # as ``filter.nuisances.turned``
        offset = torch.einsum("...s,msk->...mk", shapes, self.offset.reshape(len(self), -1, 6))
        force, moment = force - offset[..., :3], moment - offset[..., 3:]
        return torch.cat([pose.arms(force), pose.arms(moment)], -1)

    def _of_tone(self, passive: Passive) -> Tensor:
        return passive.units.sum(-1, keepdim=True) * self.tone

    def _of_fossa(self, jaw: Jaw, pose: Pose, passive: Passive, theta: Tensor, device: Tensor) -> Tensor:
        """(..., 5, m) by differences: the fossa moves all lines and turns the slide."""
        arm = pose.arms(jaw.mouthpiece[..., None, :])[..., 0, :]
        before = passive.forces.force + (pose.motion(arm) @ device[..., None])[..., 0]
        columns = before.new_zeros(*before.shape, len(self))
        for name in ("fossa_drop", "fossa_frequency"):
            for j in getattr(self, name).nonzero()[:, 0]:
                moved = replace(jaw, **{name: getattr(jaw, name) + STEP * getattr(self, name)[j]})
                there = moved.pose(pose.q)
                after = moved.passive(there, theta).forces.force + (there.motion(arm) @ device[..., None])[..., 0]
                columns[..., j] = (after - before) / STEP
        return columns

    def _seen(self, jaw: Jaw, pose: Pose) -> Tensor:
        """(..., 6, m) derivative of the encoders' place and angles (pitch, yaw, roll) at the same pose."""
        place = pose.arms(self.mouthpiece) - self.mouthpiece
        x = pose.q[..., 0, None]
        drop, turn = jaw.fossa_drop[..., None], jaw.fossa_frequency[..., None] * x
        sunk = (turn.cos() - 1.0) * self.fossa_drop - drop * x * turn.sin() * self.fossa_frequency
        place = place + torch.nn.functional.pad(sunk[..., None], (2, 0))
        angles = pose.q[..., [4, 2, 3]][..., None, :].expand(place.shape)
        turned = -torch.linalg.cross(self.turn.expand(place.shape), angles)
        return torch.cat([place, turned[..., [1, 2, 0]]], -1).mT
