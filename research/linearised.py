"""Cost of the filter's linearisation: NEES beside that of the same filter linearised at the truth throughout.

    python -m research.linearised random --env JawImaged --seconds 120 --patients 16 --seed 371000

At the truth the point of linearisation stays, muscles and nuisances alike, while the belief is made of all readings as
ever: the best that a filter of this form can have. Each row is a process of its own, which compiles the filter so and
runs it over the same records. Prints a table in Markdown; takes some minutes.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
from typing import Any

import gymnasium as gym
import numpy as np

import jawenv.filter.learn as learning
import jawenv.filter.tick as tick
from agents import load_agent
from jawenv.filter.belief.state import Belief, FilterSettings
from jawenv.filter.model.basis import set_coefficients
from jawenv.filter.nuisances.changed_jaw import move_jaw
from jawenv.kernels.compiled import njit
from jawenv.playing.agents import own_seed
from jawenv.recordings.of_simulation import record_of
from jawenv.recordings.online import OnlineFilter

ROWS = ("the belief", "the truth")
EVERY = 20  # ticks from one belief to the next


@njit
def stay(belief: Belief, settings: FilterSettings, scratch):
    """Stand in for ``recentre``: the point stays, and the belief's steps from it are known."""
    learning.set_steps(belief, scratch)
    belief.steps[:] = scratch.row


@njit
def _keep_nodes(belief: Belief, scratch):
    """Stand in for ``refocus`` and do nothing."""


@njit
def never(belief: Belief):
    """Stand in for ``has_moved``: readings are not filtered again."""
    return False


STAYING = ((learning, "recentre", stay), (learning, "refocus", _keep_nodes), (tick, "has_moved", never))


@njit
def _set_point(belief: Belief, settings: FilterSettings, theta, nuisances, row):
    """Move the point to the truth before the first reading."""
    first = belief.nominal.shape[0] * belief.nominal.shape[1] + 1
    set_coefficients(belief.basis, theta, belief.nominal)
    belief.point[:], belief.mean[:], belief.nuisances[:] = theta, theta, nuisances
    row[first : first + nuisances.shape[0]] = nuisances
    if nuisances.shape[0] > 0:
        move_jaw(belief.jaw, settings.nuisances, row, first)


def records(arguments: argparse.Namespace) -> tuple[list[Any], Any]:
    """Records of what the patients' devices read in an episode, and the truth of the worlds."""
    envs: Any = gym.make_vec(
        f"jawenv/{arguments.env}-v3",
        arguments.patients,
        autoreset_mode="disabled",
        cohort=arguments.cohort,
        episode_s=arguments.seconds,
        control="targets",
        record=True,
        track_bound=False,
    )
    seeds = list(range(arguments.seed, arguments.seed + arguments.patients))
    agent: Any = load_agent(arguments.agent, control="targets")
    observation, _ = envs.reset(seed=seeds)
    agent.reset(arguments.patients, own_seed())
    for _ in range(round(arguments.seconds * envs.unwrapped.simulation.configuration.steps_per_s)):
        observation, *_ = envs.step(agent.predict(observation)[0].astype(np.float32))
    simulation = envs.unwrapped.simulation
    return [record_of(simulation, i) for i in range(arguments.patients)], simulation.worlds["truth"]


def measure(arguments: argparse.Namespace, at_truth: bool) -> list[list[float]]:
    """NEES over the number of parameters, RMSE of the logs, -log det of the covariance over 2, z, of every patient."""
    if at_truth:
        for module, name, kernel in STAYING:
            setattr(module, name, kernel)
    read, truth = records(arguments)
    rows = []
    for record, theta, nuisances in zip(read, truth["log_parameters"], truth["nuisances"], strict=True):
        online = OnlineFilter.of_record(record, every=EVERY)
        if at_truth:
            row = np.zeros(online._belief["score"].size)
            _set_point(online._belief, online._settings, theta.copy(), nuisances.copy(), row)
        for k, measured in enumerate(record.measured):
            belief = online.update(measured, record.samples[k - 1] if k > 0 else None)
        error = belief.log_mean - theta
        nees = error @ np.linalg.solve(belief.log_cov, error) / error.size
        z = error / np.sqrt(np.diag(belief.log_cov))
        rows.append([nees, np.sqrt(np.mean(error**2)), -0.5 * np.linalg.slogdet(belief.log_cov)[1], *z])
    return rows


def main() -> None:
    parser = argparse.ArgumentParser(description="Measure what the filter's linearisation costs.")
    parser.add_argument("agent", help="a maneuver or policy that does not look")
    parser.add_argument("--env", default="JawImaged")
    parser.add_argument("--cohort", default="trismus")
    parser.add_argument("--seconds", type=float, default=30.0)
    parser.add_argument("--patients", type=int, default=16)
    parser.add_argument("--seed", type=int, default=6000, help="of the first patient; tuning's are 5000 to 19999")
    parser.add_argument("--row", type=int, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.row is not None:
        print(json.dumps(measure(arguments, arguments.row == 1)))
        return
    print(
        "| linearised at | NEES/p | largest | error, % | claimed nats, less the first row's | largest mean z |\n"
        "|---|--:|--:|--:|--:|--:|",
        flush=True,
    )
    first = None
    for number, name in enumerate(ROWS):
        command = [sys.executable, "-m", "research.linearised", *sys.argv[1:], "--row", str(number)]
        with tempfile.TemporaryDirectory() as cache:
            # The kernels of a filter that stays at the truth must not be taken for those of the usual one.
            places = {"JAWENV_CACHE_DIR": cache} if number else {}
            ran = subprocess.run(command, env=os.environ | places, stdout=subprocess.PIPE, text=True, check=True)
        values = np.array(json.loads(ran.stdout.splitlines()[-1]))
        mean = values.mean(axis=0)
        error = 100.0 * np.sqrt(np.mean(values[:, 1] ** 2))
        first = mean[2] if first is None else first
        bias = np.abs(mean[3:]).max()
        print(
            f"| {name} | {mean[0]:.2f} | {values[:, 0].max():.1f} | {error:.1f} | {mean[2] - first:.1f} | {bias:.2f} |",
            flush=True,
        )


if __name__ == "__main__":
    main()
