"""Agreement of the twin with the environment and its filter, on patients and maneuvers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import gymnasium as gym
import numpy as np
import torch
from numpy.typing import NDArray

import jawenv  # noqa: F401  registers its environments
from agents.twin.constants import Patients, Twin
from agents.twin.worlds import Worlds
from jawenv.base.errors import InputError
from jawenv.device.channels import HIGHEST, LOWEST
from jawenv.ladder import DEFAULT_ENV, env_id_of
from jawenv.playing.agents import Array
from jawenv.playing.maneuvers import Maneuver
from jawenv.playing.maneuvers.maneuver import action_of

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
"""Of the perturbations, and how often."""


@dataclass(frozen=True)
class Agreement:
    """Figures of environment and twin for N patients."""

    maneuver: NDArray[np.intp]  # (N,) index of the _perturbed maneuver in ``MANEUVERS``
    worst: NDArray[Any]  # (2, N) log of the largest sd, of the environment's filter and of the twin
    error: NDArray[Any]  # (N,) of the log parameter that the filter knows least, its estimate less the truth
    discomfort_s: NDArray[Any]  # (2, N) in 10 s

    def correlation(self) -> float:
        """Correlation between the two rows of ``worst``."""
        return float(np.corrcoef(*self.worst)[0, 1])

    def scatter_without_error(self) -> float:
        """Sd of the twin's log less the filter's, without what is linear in ``error``.

        The filter's error bars are those at its estimate, the twin's those at the truth.
        """
        less = self.worst[1] - self.worst[0]
        return float((less - np.polyval(np.polyfit(self.error, less, 1), self.error)).std())

    def table(self) -> str:
        """Markdown: scatter and offset of the twin's log of the largest sd, and discomfort, by maneuver and in all."""
        rows = ["| maneuver | correlation | scatter | offset | discomfort, s | of the twin |"]
        rows.append("|---|--:|--:|--:|--:|--:|")
        chosen = {name: self.maneuver == i for i, name in enumerate(MANEUVERS)} | {"all": self.maneuver >= 0}
        for name, part in chosen.items():
            if part.sum() > 1:
                (real, own), (felt, of_twin) = self.worst[:, part], self.discomfort_s[:, part]
                figures = f"{np.corrcoef(real, own)[0, 1]:.3f} | {(own - real).std():.3f} | {(own - real).mean():+.3f}"
                rows.append(f"| {name} | {figures} | {felt.mean():.3f} | {of_twin.mean():.3f} |")
        both = np.corrcoef(*self.discomfort_s)[0, 1]
        rows += ["", f"Scatter in all without the estimates' errors: {self.scatter_without_error():.3f}."]
        return "\n".join([*rows, f"Correlation of the patients' discomfort: {both:.3f}."])


def _perturbed(number: int, times: Array, rng: np.random.Generator) -> Array:
    """Targets (N, T, 4) of ``MANEUVERS`` in turn, varied between knots as a policy in training varies them."""
    base = np.stack([Maneuver.named(MANEUVERS[i % len(MANEUVERS)]).targets(times).value for i in range(number)])
    knots = np.arange(0.0, HORIZON_S + KNOT_S, KNOT_S)
    between = np.clip(1.0 - np.abs(times[:, None] - knots) / KNOT_S, 0.0, None)
    size = rng.choice(SIZES, size=(number, 1, 1), p=SHARES) * np.array(SPREAD)
    varied: Array = base + between @ rng.standard_normal((number, len(knots), 4)) * size
    return np.clip(varied, LOWEST, HIGHEST)


def agreement(world: Mapping[str, Any], patients: int, seed: int) -> Agreement:
    """Play _perturbed maneuvers in the environment and in the twin.

    Args:
        world: arguments of the environment, ``env`` among them.
        patients: how many.
        seed: of the first.
    """
    arguments = {"episode_s": HORIZON_S, **world}
    env_id = env_id_of(arguments.pop("env", DEFAULT_ENV))
    if patients < 2:
        raise InputError(f"patients is {patients}; allowed: 2 or more")
    env: Any = gym.make_vec(env_id, patients, autoreset_mode="disabled", **arguments)
    env.reset(seed=seed)
    simulation = env.unwrapped.simulation
    twin = Twin(simulation)
    worlds = Worlds(twin, Patients.of_worlds(simulation.worlds), torch.Generator().manual_seed(seed))
    steps = round(HORIZON_S / twin.decision_s)
    times = twin.decision_s * np.arange(1, steps + 1, dtype=np.float64)
    targets = _perturbed(patients, times, np.random.default_rng(seed))
    discomfort, running = np.zeros((2, patients)), np.ones(patients, dtype=bool)
    for step in range(steps):
        *_, ended, _, info = env.step(action_of(targets[:, step]).astype(np.float32))
        running &= ~ended | (step == steps - 1)
        with torch.no_grad():
            discomfort += [info["cost"] * twin.decision_s, worlds.step(torch.tensor(targets[:, step])).numpy()]
    env.close()
    variances = worlds.belief.covariance.diagonal(dim1=-2, dim2=-1)[:, :12].amax(-1).numpy()
    worst = np.stack([np.log(info["belief_sd"].max(axis=1)), 0.5 * np.log(variances)])
    least = np.arange(patients), info["belief_sd"].argmax(axis=1)
    error = simulation.worlds["known"]["belief"]["mean"][least] - simulation.worlds["truth"]["log_parameters"][least]
    maneuver = np.arange(patients) % len(MANEUVERS)
    return Agreement(maneuver[running], worst[:, running], error[running], discomfort[:, running])
