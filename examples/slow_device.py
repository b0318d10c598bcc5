"""How well does the filter know the muscles from encoders that are read more seldom?

    python examples/slow_device.py open_and_hold --patients 32 --episode-s 15

Patients are played in force control at 100 Hz; their records are made slower, and divided into short ticks again. For
each rate it prints the mean NEES per parameter with its standard error (calibrated: 1), the median, and the root mean
square error.
"""

import argparse
import sys
from collections.abc import Sequence

import numpy as np
from rich.progress import track

import jawenv
from agents import load_agent
from jawenv.recordings.dividing import divided
from jawenv.recordings.record import Record
from jawenv.recordings.record_filter import TensionFilter
from jawenv.recordings.thinning import thinned

TICK_HZ = 100


def judge(estimator: TensionFilter, records: Sequence[Record], told: str) -> tuple[np.ndarray, np.ndarray]:
    """NEES per parameter (N,), and errors (N, P) of the natural logs."""
    nees, errors = [], []
    for record in track(records, told, transient=True, disable=not sys.stderr.isatty()):
        estimate = estimator.estimate(record)
        error = estimate.mean[-1] - record.truth
        nees.append(error @ np.linalg.solve(estimate.cov[-1], error) / len(error))
        errors.append(error)
    return np.array(nees), np.array(errors)


def main() -> None:
    """Read the command line, play, estimate and print."""
    parser = argparse.ArgumentParser(description="Judge estimators on slower recordings.")
    parser.add_argument("maneuver", nargs="?", default="opening_with_swings_and_fore_aft", help="name or maneuver file")
    parser.add_argument("--patients", type=int, default=16)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--episode-s", type=float, default=15.0)
    parser.add_argument("--every", type=int, nargs="+", default=[1, 2, 5, 10, 20], help="keep one reading of so many")
    given = parser.parse_args()

    env_kwargs = {"record": True, "episode_s": given.episode_s}
    agent = load_agent(given.maneuver, control="force")
    records = jawenv.play(agent, patients=given.patients, seed=given.seed, env_kwargs=env_kwargs).records
    estimator = TensionFilter()
    print(f"{agent.name}, {given.patients} patients, {given.episode_s:g} s\n")
    print("readings  estimator            NEES/12         median   rms error of the logs")
    for every in given.every:
        slow = [divided(thinned(record, every), every) for record in records]
        rate = f"{TICK_HZ / every:g} Hz"
        nees, errors = judge(estimator, slow, f"{rate}, {estimator.name}")
        spread = np.std(nees, ddof=1) / np.sqrt(len(nees)) if len(nees) > 1 else np.nan
        figures = f"{nees.mean():7.2f} ± {spread:5.2f}  {np.median(nees):7.2f}"
        print(f"{rate:8s}  {estimator.name:18s}  {figures}  {np.sqrt(np.mean(errors**2)):8.1%}", flush=True)


if __name__ == "__main__":
    try:
        main()
    except jawenv.InputError as error:
        print(f"error: {error}", file=sys.stderr)
        sys.exit(2)
