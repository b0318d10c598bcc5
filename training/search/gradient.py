"""One maneuver for all patients, searched by the gradient of the twin.

Adam (Kingma & Ba 2015, arXiv:1412.6980) on offsets of the targets, one for each channel and 0.4 s: of single decisions
they would make the jaw tremble. Each update takes new patients. Discomfort has a price that is learned, so that it is
within its limit on average in the environment, which has more of it than the twin.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import torch
from torch import Tensor

import jawenv  # noqa: F401  registers its environments
from agents.twin.constants import Patients, Twin
from agents.twin.objective import log_worst, weights
from agents.twin.worlds import Worlds
from jawenv.base.seeds import TUNING
from jawenv.device.channels import FASTEST_TARGET, HIGHEST, LOWEST
from jawenv.ladder import DEFAULT_ENV
from jawenv.playing.agents import Array
from jawenv.playing.maneuvers import Maneuver
from jawenv.playing.maneuvers.maneuver import SUFFIXES, action_of
from jawenv.playing.policies.following import DECISION_HZ
from training.run.callbacks import Multiplier
from training.run.config import ComfortConfig

KNOT_S = 0.4
TARGET_DISCOMFORT_S = 0.1  # in 30 s, on average
LEARNING_RATE = 0.03  # of Adam at first; it falls to a tenth
SCALE = torch.tensor([0.25, 0.4, 0.1, 0.4], dtype=torch.float64)
"""Of the channels' steps."""
PER_30_S = 30.0
DECISION_S = 1.0 / DECISION_HZ


def search(
    refined: str,
    cohort: str,
    updates: int,
    patients: int,
    horizon_s: float,
    report: Callable[[int, float, float], None] = lambda done, worst, discomfort: None,
) -> Array:
    """Targets (T, 4) at the ends of T decisions.

    Args:
        refined: maneuver where the search begins, a name or a file.
        cohort: population of the patients.
        updates: of the targets.
        patients: new ones in each update.
        horizon_s: length of the maneuver.
        report: called with the updates done, the mean log of the largest sd and the discomfort (s in 30 s).
    """
    maneuver = Maneuver.load(refined) if Path(refined).suffix in SUFFIXES else Maneuver.named(refined)
    arguments: dict[str, Any] = {"cohort": cohort, "episode_s": horizon_s}
    env: Any = gym.make_vec(DEFAULT_ENV, patients, **arguments, autoreset_mode="disabled")
    env.reset(seed=TUNING.start)
    simulation = env.unwrapped.simulation
    twin = Twin(simulation)
    steps = round(horizon_s / twin.decision_s)
    times = twin.decision_s * np.arange(1, steps + 1, dtype=np.float64)
    knots = np.arange(0.0, horizon_s + KNOT_S, KNOT_S)
    start = torch.tensor(maneuver.targets(times).value)
    between = torch.tensor(np.clip(1.0 - np.abs(times[:, None] - knots) / KNOT_S, 0.0, None))
    x = torch.zeros(len(knots), start.shape[1], dtype=torch.float64, requires_grad=True)
    optimiser = torch.optim.Adam([x], LEARNING_RATE, betas=(0.8, 0.95))
    schedule = torch.optim.lr_scheduler.CosineAnnealingLR(optimiser, updates, 0.1 * LEARNING_RATE)
    limit = ComfortConfig(target_discomfort_s=TARGET_DISCOMFORT_S, initial_multiplier=2.0)
    price = Multiplier(limit)
    for update in range(updates):
        worlds = Worlds(twin, Patients.of_worlds(simulation.worlds))
        targets = start + between @ x * SCALE
        worst, discomfort = play(worlds, targets)
        loss = (worst + price.value * discomfort).mean()
        optimiser.zero_grad()
        loss.backward()  # type: ignore[no-untyped-call]
        optimiser.step()
        schedule.step()
        per_30_s = PER_30_S / horizon_s * _discomfort_of(env, within_reach(targets.detach(), twin.decision_s))
        price.update(per_30_s)
        report(update + 1, float(log_worst(worlds).detach().mean()), per_30_s)
        env.reset()
    env.close()
    found: Array = within_reach(start + between @ x.detach() * SCALE, twin.decision_s).numpy()
    return found


def play(worlds: Worlds, targets: Tensor) -> tuple[Tensor, Tensor]:
    """Weighted ``log_worst`` (P,) and discomfort (P,), s, of targets (T, 4)."""
    marks = weights(len(targets))
    worst = discomfort = worlds.patients.theta.new_zeros(len(worlds.patients))
    for step, target in enumerate(targets, 1):
        discomfort = discomfort + worlds.step(target.expand(len(worlds.patients), -1))
        if step in marks:
            worst = worst + marks[step] * log_worst(worlds)
    return worst, discomfort


def _discomfort_of(env: Any, targets: Tensor) -> float:
    """Mean discomfort, s, of targets (T, 4) for the patients of an environment after its ``reset``."""
    cost = 0.0
    for target in action_of(targets.numpy()):
        info = env.step(np.tile(target.astype(np.float32), (env.num_envs, 1)))[-1]
        cost += float(info["cost"].mean())
    return cost / DECISION_HZ


def within_reach(targets: Tensor, decision_s: float) -> Tensor:
    """The targets (T, 4) that a device reaches that follows these."""
    low, most = targets.new_tensor(LOWEST), decision_s * targets.new_tensor(FASTEST_TARGET)
    reached, place = [], torch.zeros_like(targets[0])
    for target in targets:
        goal = torch.maximum(target.clamp(max=HIGHEST), low)
        place = place + torch.maximum(torch.minimum(goal - place, most), -most)
        reached.append(place)
    return torch.stack(reached)
