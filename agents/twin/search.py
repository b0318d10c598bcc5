"""Targets that are best for each patient, for patients whom a belief allows, or for a cohort, down the twin's gradient.

Adam (Kingma & Ba 2015, arXiv:1412.6980) moves knots of the targets: single decisions would make the jaw tremble.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import torch
from torch import Tensor

from agents.twin.constants import Patients, Twin
from agents.twin.objective import log_worst, weights
from agents.twin.worlds import Worlds
from jawenv.device.channels import HIGHEST, LOWEST
from jawenv.playing.agents import Array

_KNOT_S = 0.4
_SCALE = np.array([0.25, 0.4, 0.1, 0.4])
"""Sizes of the channels' steps."""
_LEARNING_RATE = 0.03  # of Adam, in parts of ``_SCALE``
PRICE = 8.0  # nats that a second of the twin's discomfort is worth


def searched(
    twin: Twin,
    patients: Patients | Callable[[], Patients],
    base: Array,
    updates: int,
    *,
    asked: Array | None = None,
    beliefs: tuple[Array, Array] | None = None,
    price: Callable[[], float] = lambda: PRICE,
    report: Callable[[int, Array, float], None] = lambda done, targets, worst: None,
) -> Array:
    """Targets (N, T, 4) with the smallest error bars and discomfort, one row for each group of patients.

    Args:
        twin: constants.
        patients: N groups of equal size, the patients of a group side by side; their mean cost counts. Or what gives
            new ones for each update.
        base: (N, T, 4) targets that the search begins with.
        updates: steps of Adam.
        asked: (P, 6) the muscles asked for of each patient; all by default.
        beliefs: (N, 12) means and (N, 12, 12) precisions that the groups' beliefs begin with; the prior's by default.
        price: nats that a second of the twin's discomfort is worth in the next update.
        report: called after each update with the updates done, the targets (N, T, 4) that it tried, and the mean over
            patients of their ``log_worst`` at the end.
    """
    start = torch.tensor(np.asarray(base))
    times = twin.decision_s * np.arange(1, start.shape[1] + 1)
    knots = np.arange(0.0, times[-1] + _KNOT_S, _KNOT_S)
    between = np.clip(1.0 - np.abs(times[:, None] - knots) / _KNOT_S, 0.0, None)
    moves = torch.tensor(between[..., None] * _SCALE)
    x = start.new_zeros(len(start), len(knots), start.shape[2], requires_grad=True)
    wanted = None if asked is None else torch.tensor(asked).double()
    optimiser = torch.optim.Adam([x], _LEARNING_RATE, betas=(0.8, 0.95))
    for update in range(updates):
        targets = start + torch.einsum("tkc,nkc->ntc", moves, x)
        treated = patients() if callable(patients) else patients
        together = len(treated) // len(start)
        worlds = Worlds(twin, treated, asked=wanted)
        if beliefs is not None:
            worlds.belief.know(*(torch.tensor(part).repeat_interleave(together, 0) for part in beliefs))
        cost = cost_of(worlds, targets.repeat_interleave(together, 0), price())
        optimiser.zero_grad()
        cost.reshape(len(start), together).mean(-1).sum().backward()  # type: ignore[no-untyped-call]
        optimiser.step()
        report(update + 1, targets.detach().numpy(), float(log_worst(worlds).detach().mean()))
    found = start + torch.einsum("tkc,nkc->ntc", moves, x.detach())
    targets_found: Array = np.clip(found.numpy(), np.array(LOWEST), HIGHEST)
    return targets_found


def cost_of(worlds: Worlds, targets: Tensor, price: float) -> Tensor:
    """Weighted ``log_worst`` (P,) of targets (P, T, 4), with the price of their discomfort, nats."""
    marks, cost = weights(targets.shape[1]), targets.new_zeros(len(targets))
    for number, target in enumerate(targets.unbind(1), 1):
        cost = cost + price * worlds.step(target)
        if number in marks:
            cost = cost + marks[number] * log_worst(worlds)
    return cost
