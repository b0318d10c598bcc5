"""The filter's belief in the twin: Gaussian about the parameters, the load cell's gain and the nuisances.

A reading is linear in them, y = A p + noise, and adds A^T A to the precision once A is whitened. The noise is the
unmodelled wrench and what the encoders' error is in terms of force (``mechanics``); a wrench that lasts is filtered
beside (``disturbance``).
"""

from __future__ import annotations

from math import exp
from typing import NamedTuple

import torch
from torch import Tensor
from torch.nn.functional import pad

from agents.twin.constants import Patients, Twin
from agents.twin.disturbance import Disturbance
from agents.twin.mechanics import Passive, Pose, force_noise, norm, shaken_information, shaking
from jawenv.device.device import TICK
from jawenv.filter.readings.model_error import ALIKE, DRIFT_S, ERROR_ARM, MOST_TICKS, SLOWEST, SLOWEST_DRIFT
from jawenv.filter.readings.teeth import TOOTH_NOISE

N_PARAMETERS = 12
QUICKLY = 10.0**-0.5
"""Share of the encoders' sd that is left for a shaking at 30 1/s, whose velocities are read too."""
FEWEST = 1e-6


class Held(NamedTuple):
    """A jaw as the device holds it."""

    pose: Pose  # of the jaw
    passive: Passive  # at the pose
    arm: Tensor  # (P, 3) of the mouthpiece
    device: Tensor  # (P, 6) force and moment at the mouthpiece
    servos: Tensor  # (P, 4, 6) wrenches of the motors' unit forces
    stiffness: Tensor  # (P, 5, 5) of jaw and device together
    speeds: Tensor  # (P, 5)


class Belief:
    """Beliefs about P patients, from the prior on.

    Args:
        twin: constants.
        patients: P.
        generator: of the readings' noise; without one the belief goes to the truth as far as information reaches.
        prior: (P, 12) means and sds; the environment's by default.

    Attributes:
        precision: (P, n, n) of 12 parameters, the load cell's gain and the nuisances.
        covariance: (P, n, n) its inverse, as of the last ``renew``.
        mean: (P, 12) believed parameters, as of the last ``renew``.
    """

    def __init__(
        self,
        twin: Twin,
        patients: Patients,
        generator: torch.Generator | None = None,
        prior: tuple[Tensor, Tensor] | None = None,
    ) -> None:
        self._twin, self._patients, self._generator = twin, patients, generator
        others = twin.prior_sd.new_tensor([twin.gain_sd] + [1.0] * len(twin.nuisances))
        number = len(patients)
        self._prior_mean, prior_sd = (twin.prior_mean, twin.prior_sd.expand(number, -1)) if prior is None else prior
        sd = torch.cat([prior_sd, others.expand(number, -1)], -1)
        self.precision = torch.diag_embed(sd**-2)
        self._score = torch.zeros_like(sd)
        self._readings, self._drift = sd.new_zeros(number), sd.new_zeros(number, 5)
        self._truth = pad(patients.theta - self._prior_mean, (0, len(others)))
        if generator is not None:
            self._truth[:, N_PARAMETERS:] = others * self._noise(number, len(others))
        self._disturbance = None
        if twin.memory > 0.0:
            self._disturbance = Disturbance(twin.disturbance_variance, twin.memory, number, sd.shape[-1])
        self.renew()

    def know(self, mean: Tensor, precision: Tensor) -> None:
        """Begin with means (P, 12) and precisions (P, 12, 12) of the parameters in the place of the prior's."""
        self.precision = self.precision.clone()
        self.precision[:, :N_PARAMETERS, :N_PARAMETERS] = precision
        moved = pad(mean - self._prior_mean, (0, self.precision.shape[-1] - N_PARAMETERS))
        self._score = (self.precision @ moved[..., None])[..., 0]
        self.renew()

    def renew(self) -> None:
        """Follow what was learnt."""
        self.covariance = torch.linalg.inv(self.precision)
        moved = self.covariance @ self._score[..., None]
        self.mean = self._prior_mean + moved[:, :N_PARAMETERS, 0]

    def learn(self, held: Held, readings: Tensor) -> None:
        """Take so many readings (P,), as if all were of one pose."""
        jaw = self._patients.jaw
        carried = norm(held.device[:, :3]) + norm(jaw.weight)
        rows = self._rows(held, readings, self._process_noise(held, carried))
        if not self._twin.first_ticks_count:
            rows = rows * self._reading_weight(held, carried).sqrt()[:, None, None]
        self._readings = self._readings + readings
        seen = rows @ self._truth[..., None]
        if self._generator is not None:
            seen = seen + self._noise(*seen.shape)
        self.precision = self.precision + rows.mT @ rows
        self._score = self._score + (rows.mT @ seen)[..., 0]

    def learn_from_shaking(self, held: Held) -> None:
        """Take what the unmodelled wrench made of the jaw since it was last asked."""
        twin, Z = self._twin, held.pose.twists
        with torch.no_grad():
            J = held.pose.motion(held.arm)
            servos = held.servos @ Z.mT
            slides, turns = Z[..., :3], Z[..., 3:]
            damping = twin.servo_damping * servos.mT @ servos
            damping = damping + twin.sliding_damping * slides @ slides.mT + twin.turning_damping * turns @ turns.mT
            C = shaking(held.stiffness, damping, TICK * (J * twin.wrench_variance) @ J.mT)
            noise = force_noise(held.passive, J, twin.wrench_variance, QUICKLY * twin.encoder_sd)
        information = shaken_information(held.passive, C, noise) * self._readings[:, None, None]
        self._readings = torch.zeros_like(self._readings)
        others = self._truth.shape[-1] - N_PARAMETERS
        self.precision = self.precision + pad(information, (0, others, 0, others))
        learnt = (information @ self._truth[:, :N_PARAMETERS, None])[..., 0]
        self._score = self._score + pad(learnt, (0, others))

    def _noise(self, *shape: int) -> Tensor:
        return self.precision.new_empty(shape).normal_(generator=self._generator)

    def _rows(self, held: Held, readings: Tensor, variance: Tensor) -> Tensor:
        """Whitened rows of readings of whose wrench so much (P, 6) is new in each."""
        twin, passive, J = self._twin, held.passive, held.pose.motion(held.arm)
        many = readings.clamp(min=FEWEST)[:, None, None]
        noise = force_noise(passive, J, variance, twin.encoder_sd) / many
        columns, unexplained = torch.cat([passive.columns, passive.forces.force[..., None]], -1), None
        if len(twin.nuisances):
            jaw, theta = self._patients.jaw, self._patients.theta
            by = twin.nuisances.columns(jaw, held.pose, passive, theta, held.device, twin.encoder_sd)
            columns, unexplained = torch.cat([columns, by.force], -1), pad(by.readings, (N_PARAMETERS + 1, 0))
        if self._disturbance is None:
            rows = torch.linalg.solve_triangular(torch.linalg.cholesky(noise), columns, upper=False)
        else:
            rows = self._disturbance.innovation_rows(columns, J, noise)
        return rows if unexplained is None else torch.cat([rows, unexplained * many.sqrt()], -2)

    def _process_noise(self, held: Held, carried: Tensor) -> Tensor:
        """Variance (P, 6) of the wrench that is new in a reading, as ``jawenv.filter.readings`` has it."""
        twin, speeds = self._twin, held.speeds.abs()
        moved = speeds[:, 0] + self._patients.jaw.mouthpiece[..., 0] * speeds[:, 2:].sum(-1)
        speed = (moved.square() + twin.shaking**2).sqrt()
        ticks = (ALIKE / (TICK * speed.clamp(min=SLOWEST))).clamp(max=MOST_TICKS)
        model_error = ticks * (twin.model_error * carried).square()
        arms = model_error.new_tensor([1.0] * 3 + [ERROR_ARM**2] * 3)
        bite_force = (held.passive.bite_force[:, None] * model_error.new_tensor(TOOTH_NOISE)).square()
        variance: Tensor = twin.wrench_variance + model_error[:, None] * arms + bite_force
        return variance

    def _reading_weight(self, held: Held, carried: Tensor) -> Tensor:
        """(P,) what readings count for, as ``reading_weight`` of the filter has it, but for earlier visits."""
        twin = self._twin
        self._drift = self._drift + (1.0 - exp(-twin.dt / DRIFT_S)) * (held.speeds - self._drift)
        moved = norm(self._drift[:, :2]) + self._patients.jaw.mouthpiece[..., 0] * norm(self._drift[:, 2:])
        dwell = ALIKE / (TICK * moved.clamp(min=SLOWEST_DRIFT))
        noise = (twin.wrench_variance + twin.disturbance_variance)[:3].mean()
        weight: Tensor = noise / (noise + dwell * (twin.systematic_error * carried).square())
        return weight
