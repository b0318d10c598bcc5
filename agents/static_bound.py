"""A bound on what an episode can tell: readings of held poses within comfort, shared out in the best way.

Poses are drawn; those within all soft limits are kept, and the readings of an episode are shared among them so that the
largest sd is smallest: an optimal experiment in continuous weights (Kiefer & Wolfowitz 1960). No way between poses is
counted, and a held jaw's readings have the least noise that lasts. So it is below what any movement reaches, but for
poses that were not drawn. Five to seven poses are visited. Where the anatomy is not known exactly disturbances last:
a jaw that moves tells more, and it is no bound.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import torch
from torch import Tensor

from agents.twin.belief import Belief
from agents.twin.constants import Patients, Twin
from agents.twin.objective import POWER
from agents.twin.worlds import Worlds
from jawenv.base.errors import InputError
from jawenv.device.channels import HIGHEST, LOWEST, N_CHANNELS
from jawenv.device.comfort import SPEED
from jawenv.device.device import TICK
from jawenv.playing.agents import Array

_POSES = 192
"""Drawn for each patient."""
_DECISIONS = 12
"""In which a jaw reaches a pose and comes to rest there."""
_TOGETHER = 600
"""Poses that are held at once."""
_UPDATES, _LEARNING_RATE = 250, 0.1
_VISITED = 0.02
"""Share of the readings from which on a pose counts as visited."""
_SWAY = 1e-2
"""Speed at which a held jaw's readings repeat their errors least, over the limit of comfort."""


class _StaticBound(NamedTuple):
    """The bound of N patients."""

    log_worst: Array  # (N,) of the largest sd
    targets: Array  # (N, _POSES, 4) of the poses
    shares: Array  # (N, _POSES) of the readings, 0 where a limit is crossed

    def visited(self, patient: int) -> list[tuple[float, Array]]:
        """Shares and targets (4) of the poses that a patient's optimum visits, the largest share first."""
        order = [int(i) for i in np.argsort(-self.shares[patient]) if self.shares[patient, i] > _VISITED]
        return [(float(self.shares[patient, i]), self.targets[patient, i]) for i in order]


def static_bound(simulation: Any, seconds: float, poses: int = _POSES, seed: int = 0) -> _StaticBound:
    """The bound for the patients of a simulation after its ``reset``.

    Args:
        simulation: of an environment of the midline model.
        seconds: of readings.
        poses: drawn for each patient.
        seed: of the draw.

    Raises:
        InputError: another model, or an anatomy that is not known exactly.
    """
    if not simulation.knowledge.exact:
        raise InputError("knowledge is not exact; allowed for a static bound: exact, as disturbances must not last")
    twin, patients = Twin(simulation), Patients.of_worlds(simulation.worlds)
    number = len(patients)
    drawn = np.random.default_rng(seed).uniform(LOWEST, HIGHEST, (number, poses, N_CHANNELS))
    of_patient, targets = np.repeat(np.arange(number), poses), torch.tensor(drawn.reshape(-1, N_CHANNELS))
    parts = np.array_split(np.arange(len(of_patient)), -(-len(of_patient) // _TOGETHER))
    with torch.no_grad():
        found = [_information(twin, patients[of_patient[part]], targets[part]) for part in parts]
    information = torch.cat([told for told, _ in found])
    information = information.reshape(number, poses, *information.shape[1:])
    allowed = torch.cat([within for _, within in found]).reshape(number, poses)
    asked = torch.tensor(simulation.asked).double().repeat_interleave(2, -1)
    prior = Belief(twin, patients).precision
    worst, shares = _shared_out(prior, seconds / TICK * information, allowed, asked)
    return _StaticBound(worst.numpy(), drawn, shares.numpy())


def _information(twin: Twin, patients: Patients, targets: Tensor) -> tuple[Tensor, Tensor]:
    """Information (P, n, n) of a reading in a held pose, and whether (P,) it is within all soft limits but speed's."""
    worlds = Worlds(twin, patients)
    for _ in range(_DECISIONS):
        worlds.step(targets)
    held, one = worlds.held(), targets.new_ones(len(targets))
    moving = held._replace(speeds=torch.zeros_like(held.speeds))
    moving.speeds[:, 0] = _SWAY * twin.speed
    belief = Belief(twin, patients)
    before = belief.precision
    belief.learn(moving, one)
    belief.learn_from_shaking(moving)
    used = worlds.fractions.clone()
    used[:, SPEED] = 0.0
    return (belief.precision - before) * worlds.seen()[:, None, None], used.amax(-1) <= 1.0


def _shared_out(prior: Tensor, information: Tensor, allowed: Tensor, asked: Tensor) -> tuple[Tensor, Tensor]:
    """Log (N,) of the largest sd that is asked for, and shares (N, poses) of the readings."""
    x = torch.zeros(allowed.shape, dtype=torch.float64, requires_grad=True)
    optimiser = torch.optim.Adam([x], _LEARNING_RATE)
    for update in range(_UPDATES + 1):
        shares = x.masked_fill(~allowed, -60.0).softmax(-1) * allowed
        whole = prior + torch.einsum("np,npij->nij", shares, information)
        variances = torch.linalg.inv(whole).diagonal(dim1=-2, dim2=-1)[:, : asked.shape[1]]
        if update < _UPDATES:
            optimiser.zero_grad()
            ((asked * variances).pow(POWER / 2.0).sum(-1).log() / POWER).sum().backward()
            optimiser.step()
    return 0.5 * (asked * variances).detach().amax(-1).log(), shares.detach()
