"""Agreement of the twin with the environment and its filter, on patients, and maneuvers or the path of an agent.

``agreement({"cohort": "one_sided"}, 120, 5000).table()`` is the table of training/README.md, with the sds that
``COST_SD`` of agents/twin/constants.py was fitted by.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import gymnasium as gym
import numpy as np
import torch
from numpy.typing import NDArray
from scipy.optimize import brentq
from torch import Tensor

import jawenv  # noqa: F401  registers its environments
from agents.registry import load_agent
from agents.twin.constants import Patients, Twin
from agents.twin.worlds import Worlds, above
from jawenv.device.channels import HIGHEST, LOWEST
from jawenv.device.comfort import COMFORT_LIMITS
from jawenv.ladder import DEFAULT_ENV, env_id_of
from jawenv.playing.agents import Array, introduce
from jawenv.playing.maneuvers import Maneuver
from jawenv.playing.maneuvers.maneuver import action_of, goals_of

MANEUVERS = (
    "refined",
    "refined_one_sided",
    "refined_imaged",
    "information_optimal",
    "opening_with_swings",
    "slow_opening",
)
HORIZON_S = 10.0
KNOT_S = 0.4
SPREAD = (0.3, 0.5, 0.15, 0.5)
SIZES, SHARES = (0.0, 0.3, 1.0), (0.25, 0.35, 0.4)
"""Sizes of the perturbations, and how often each is drawn."""
_SDS = (1e-3, 1.0)
"""Between which the shaking of a used fraction is sought."""


@dataclass(frozen=True)
class Agreement:
    """Figures of environment and twin for N patients."""

    maneuver: NDArray[np.intp]  # (N,) index in ``names``
    worst: NDArray[Any]  # (2, N) log of the largest sd, of the environment's filter and of the twin
    discomfort_s: NDArray[Any]  # (2, N, 8) of each comfort limit, in 10 s
    names: tuple[str, ...]  # of what was played
    shaking: NDArray[Any]  # (8,) sd of each used fraction with which the twin's discomfort is the environment's, or NaN

    def correlation(self) -> float:
        """Correlation between the two rows of ``worst``."""
        return float(np.corrcoef(*self.worst)[0, 1])

    def table(self) -> str:
        """Markdown: scatter and offset of the twin's log of the largest sd, and discomfort, by maneuver and in all."""
        rows = ["| played | correlation | scatter | offset | discomfort, s | of the twin |"]
        rows.append("|---|--:|--:|--:|--:|--:|")
        felt_by = self.discomfort_s.sum(-1)
        chosen = {name: self.maneuver == i for i, name in enumerate(self.names)}
        if len(chosen) > 1:
            chosen["all"] = self.maneuver >= 0
        for name, part in chosen.items():
            if part.sum() > 1:
                (real, own), (felt, of_twin) = self.worst[:, part], felt_by[:, part]
                figures = f"{np.corrcoef(real, own)[0, 1]:.3f} | {(own - real).std():.3f} | {(own - real).mean():+.3f}"
                rows.append(f"| {name} | {figures} | {felt.mean():.3f} | {of_twin.mean():.3f} |")
        sds = ", ".join(f"{name} {sd:.3f}" for name, sd in zip(COMFORT_LIMITS, self.shaking, strict=True))
        return "\n".join([*rows, "", f"Fitted sds of the used fractions: {sds}"])


def _perturbed(number: int, times: Array, rng: np.random.Generator) -> Array:
    """Targets (N, T, 4) of ``MANEUVERS`` in turn, varied between knots as a policy in training varies them."""
    base = np.stack([Maneuver.named(MANEUVERS[i % len(MANEUVERS)]).targets(times).value for i in range(number)])
    knots = np.arange(0.0, HORIZON_S + KNOT_S, KNOT_S)
    between = np.clip(1.0 - np.abs(times[:, None] - knots) / KNOT_S, 0.0, None)
    size = rng.choice(SIZES, size=(number, 1, 1), p=SHARES) * np.array(SPREAD)
    varied: Array = base + between @ rng.standard_normal((number, len(knots), 4)) * size
    return np.clip(varied, LOWEST, HIGHEST)


def agreement(world: Mapping[str, Any], patients: int, seed: int, agent: str | None = None) -> Agreement:
    """Play perturbed maneuvers, or an agent, in the environment, and its targets in the twin.

    Args:
        world: arguments of the environment, ``env`` among them.
        patients: how many.
        seed: of the first.
        agent: what is played, as `agents.load_agent` takes it; None for perturbed maneuvers.
    """
    arguments = {"episode_s": HORIZON_S, "control": "targets", **world}
    env_id = env_id_of(arguments.pop("env", DEFAULT_ENV))
    env: Any = gym.make_vec(env_id, patients, autoreset_mode="disabled", **arguments)
    observation, _ = env.reset(seed=seed)
    simulation = env.unwrapped.simulation
    twin = Twin(simulation)
    worlds = Worlds(twin, Patients.of_worlds(simulation.worlds), torch.Generator().manual_seed(seed))
    steps = round(HORIZON_S / twin.decision_s)
    times = twin.decision_s * np.arange(1, steps + 1, dtype=np.float64)
    targets = _perturbed(patients, times, np.random.default_rng(seed))
    player = None if agent is None else load_agent(agent, env_id=env_id)
    if player is not None:
        player.reset(patients)
        introduce(player, env)
    discomfort, running = np.zeros((2, patients, len(COMFORT_LIMITS))), np.ones(patients, dtype=bool)
    used = np.zeros((patients, steps, len(COMFORT_LIMITS)))
    for step in range(steps):
        if player is not None:
            targets[:, step] = goals_of(player.predict(observation)[0])
        observation, _, ended, _, info = env.step(action_of(targets[:, step]).astype(np.float32))
        running &= ~ended | (step == steps - 1)
        discomfort[0] += np.stack([info[f"cost_{name}"] for name in COMFORT_LIMITS], -1) * twin.decision_s
        with torch.no_grad():
            worlds.step(torch.tensor(targets[:, step]))
        used[:, step] = worlds.fractions
    discomfort[1] = worlds.by_limit.numpy()
    env.close()
    variances = worlds.belief.covariance.diagonal(dim1=-2, dim2=-1)[:, :12].amax(-1).numpy()
    worst = np.stack([np.log(info["belief_sd"].max(axis=1)), 0.5 * np.log(variances)])
    names = MANEUVERS if agent is None else (agent,)
    played = np.arange(patients) % len(names)
    own = (used[running].reshape(-1, len(COMFORT_LIMITS)) - 1.0) / (twin.hard.numpy() - 1.0)
    shaking = (twin.hard.numpy() - 1.0) * _shaking(own, discomfort[0, running].mean(0) / HORIZON_S)
    return Agreement(played[running], worst[:, running], discomfort[:, running], names, shaking)


def _shaking(costs: Array, felt: Array) -> Array:
    """Sds (8,) of costs (K, 8), below 0 within a limit, with which what is above 0 of them is on average ``felt`` (8,).

    NaN where none is: nothing was felt, or more would be without any shaking.
    """
    found = np.full(len(felt), np.nan)
    for limit, mean in enumerate(felt):
        cost = torch.tensor(costs[:, limit])

        def more(sd: float, cost: Tensor = cost, mean: float = mean) -> float:
            return float(above(cost, torch.tensor(sd)).mean() - mean)

        if mean > 0.0 and more(_SDS[0]) < 0.0 < more(_SDS[1]):
            found[limit] = brentq(more, *_SDS)
    return found
