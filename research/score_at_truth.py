"""Is the filter right where it is linearised at the truth? ``python -m research.score_at_truth severe slow_opening``.

The filter runs over records of patients with the tensions of the true muscles throughout, and nothing is learnt. One
step of Newton's method from there, at the true gain of the load cell, is the error that the claim is about. If it is
as large as claimed, what is wrong elsewhere is the point of linearisation; if its mean over patients is not zero, the
score itself has a bias.
"""

from __future__ import annotations

import argparse
from typing import Any

import gymnasium as gym
import numpy as np
from numpy.typing import NDArray

import jawenv
from agents.registry import load_agent
from jawenv.filter.model.basis import set_coefficients, set_derivatives
from jawenv.filter.tick import begin_filter, take_readings
from jawenv.kernels.compiled import njit
from jawenv.laboratory.record_filter import FilterRun

FIRST_SEED, PATIENTS, EPISODE_S = 374_000, 48, 30.0


@njit
def run_at(jaw, belief, rows, settings, scratch, log_parameters, until):
    """Filter rows up to ``until``, linearised at ``log_parameters`` (p,)."""
    begin_filter(jaw, belief, rows[0].believed, settings)
    belief.point[:] = log_parameters
    set_coefficients(belief.basis, belief.point, belief.nominal)
    for tick in range(until):
        take_readings(jaw, belief, rows[tick].measured, rows[tick].samples, tick, settings, scratch)


def step_from_truth(record: Any, gain: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(p,) the step from the true parameters, and its covariance (p, p), with the prior's width about the truth."""
    run = FilterRun(record).arguments
    run_at(run.jaw, run.belief, run.rows, run.settings, run.scratch, record.truth, len(run.rows))
    size, coefficients = len(record.truth), run.belief["nominal"].size
    columns = coefficients + 1  # and the load cell's gain
    upper = np.triu(run.belief["information"])[:columns, :columns]
    information = upper + np.triu(upper, 1).T
    by_log = np.zeros((len(run.belief["score"]), size))
    set_derivatives(run.belief["basis"], record.truth, by_log)
    turned = np.zeros((columns, size + 1))
    turned[:coefficients, :size], turned[coefficients, size] = by_log[:coefficients], 1.0
    about_logs = turned.T @ information @ turned
    score = turned.T @ run.belief["score"][:columns] - gain * about_logs[:, size]
    prior = np.append(record.prior.sd**2, record.gain_sd**2)
    covariance = np.linalg.inv(about_logs + np.diag(1.0 / prior))
    return (covariance @ score)[:size], covariance[:size, :size]


def main() -> None:
    """Print mean z and mean square of the whitened error over patients."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("cohort", nargs="?", default="severe")
    parser.add_argument("maneuver", nargs="?", default="slow_opening")
    options = parser.parse_args()
    cohort, maneuver = options.cohort, options.maneuver
    kwargs: dict[str, Any] = {"cohort": cohort, "episode_s": EPISODE_S, "control": "targets"}
    seeds = [FIRST_SEED + i for i in range(PATIENTS)]
    env_id = jawenv.ladder.DEFAULT_ENV
    agent = load_agent(maneuver, control="targets")
    played = jawenv.play(agent, patients=PATIENTS, seed=FIRST_SEED, env_id=env_id, env_kwargs=kwargs | {"record": True})
    worlds: Any = gym.make_vec(env_id, num_envs=PATIENTS, autoreset_mode="disabled", **kwargs)
    worlds.reset(seed=seeds)
    gains = worlds.unwrapped.simulation.worlds["truth"]["cell_gain"]
    steps = [step_from_truth(record, gain) for record, gain in zip(played.records or (), gains, strict=True)]
    z = np.array([error / np.sqrt(np.diag(covariance)) for error, covariance in steps])
    nees = np.mean([error @ np.linalg.solve(covariance, error) / len(error) for error, covariance in steps])
    print(f"{cohort}, {maneuver}: NEES/12 {nees:.2f}; mean z {np.round(z.mean(axis=0), 2)}")


if __name__ == "__main__":
    main()
