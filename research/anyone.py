"""Worth of what ``jawenv identify`` says of files as laboratories write them.

    python -m research.anyone --patients 24 >> docs/tables/anyone.md

Times, places, angles and one reading of the load cell a row: no velocities, no header. The tracker has a rate of its
own; readings of a cell that is slower stand in the nearest rows, between them cells are empty. Patients are anyone
with the anatomy of a scan. A row is printed as soon as it is there.
"""

from __future__ import annotations

import argparse
import csv
import tempfile
from itertools import product
from pathlib import Path

import numpy as np
from scipy.interpolate import CubicSpline

import jawenv
from agents import load_agent
from eval.figures import statistics, words
from jawenv.filter.model.encoders import N_MEASUREMENTS, measure
from jawenv.recordings.columns import ENCODERS, READINGS, TIME
from jawenv.recordings.defaults import BENCH
from jawenv.recordings.estimate import Array
from jawenv.recordings.files import load_record
from jawenv.recordings.record import Record
from jawenv.recordings.untold.learnt import identified_with_errors

MOVEMENTS = ("refined", "slow_opening")
RATES = tuple(product((60, 120, 240), (20, 80)))
"""Hz of tracker and load cell."""
_POSE = 6


def lab_file(record: Record, hz: float, cell_hz: float, path: Path, seed: int = 0) -> None:
    """Write a played record as a laboratory's file.

    Args:
        record: with true states.
        hz: of the tracker, whose readings have noise of their own.
        cell_hz: of the load cell.
        path: of a CSV file.
        seed: of the noise.
    """
    assert record.states is not None
    time = np.arange(int(record.time[-1] * hz + 1e-9) + 1) / hz
    states = CubicSpline(record.time, record.states)(time)
    off = np.linalg.lstsq(_shapes(record.states, record), record.measured[:, :_POSE] - _poses(record, record.states))[0]
    noise = record.measurement_sd[:_POSE] * np.random.default_rng(seed).standard_normal((len(time), _POSE))
    pose = _poses(record, states) + _shapes(states, record) @ off + noise
    at = np.arange(int(record.time[-1] * cell_hz + 1e-9) + 1) / cell_hz
    moments = (record.time[:-1, None] + record.dt * np.array([0.0, 0.5])).ravel()
    forces = np.full((len(time), len(READINGS)), np.nan)
    rows = np.minimum(np.round(at * hz).astype(int), len(time) - 1)
    for k, values in enumerate(record.samples[:, :2].reshape(-1, len(READINGS)).T):
        forces[rows, k] = np.interp(at, moments, values)
    table = np.column_stack([time, pose * [column.scale for column in ENCODERS[:_POSE]], forces])
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow([TIME, *(column.name for column in (*ENCODERS[:_POSE], *READINGS))])
        writer.writerows([["" if np.isnan(value) else f"{value:.9g}" for value in row] for row in table])


def _poses(record: Record, states: Array) -> Array:
    """(N, 6) readings of the encoders without noise, for the geometry that is believed."""
    rows, expected, poses = np.zeros((N_MEASUREMENTS, states.shape[1])), np.zeros(N_MEASUREMENTS), []
    for state in states:
        measure(record.jaw, state, rows, expected)
        poses.append(expected[:_POSE].copy())
    return np.array(poses)


def _shapes(states: Array, record: Record) -> Array:
    """(N, 21) shapes of the pose by which the true geometry's readings differ from those of the believed one."""
    assert record.states is not None
    pose = states[:, :5] / (np.abs(record.states[:, :5]).max(axis=0) + 1e-9)
    return np.column_stack([np.ones(len(pose)), pose, *(pose[:, [i]] * pose[:, i:] for i in range(5))])


def _row(*cells: object) -> None:
    print(f"| {' | '.join(map(str, cells))} |", flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--patients", type=int, default=24, help="of each row")
    parser.add_argument("--seed", type=int, default=480_000)
    parser.add_argument("--seconds", type=float, default=10.0, help="of each movement")
    arguments = parser.parse_args()
    print("\n## Files of a laboratory\n\nTimes, places, angles and one reading of the load cell a row, no velocities.")
    print(f"`python -m research.anyone --patients {arguments.patients} --seed {arguments.seed}`:\n")
    _row("movement", "tracker, Hz", "cell, Hz", "believed", "NEES/12, median, largest", "worst error bar, %")
    print("|---|" + 5 * "--:|", flush=True)
    world = {"record": True, "episode_s": arguments.seconds, "cohort": "anyone", "knowledge": "imaged"}
    for movement in MOVEMENTS:
        played = jawenv.play(
            load_agent(movement),
            patients=arguments.patients,
            seed=arguments.seed,
            env_kwargs=world | {"track_bound": False},
        )
        assert played.records is not None
        for hz, cell_hz in RATES:
            believed, nees, worst = [], [], []
            for number, record in enumerate(played.records):
                with tempfile.TemporaryDirectory() as folder:
                    lab_file(record, hz, cell_hz, Path(folder) / "lab.csv", number)
                    found, _ = identified_with_errors(load_record(Path(folder) / "lab.csv", BENCH))
                assert record.truth is not None
                error, cov = found.estimate.mean[-1] - record.truth, found.estimate.cov[-1]
                nees.append(float(error @ np.linalg.solve(cov, error)) / len(error))
                worst.append(100.0 * float(found.estimate.sd[-1].max()))
                believed.append(found.believable)
            of_believed = np.array(nees)[np.array(believed)]
            figures = f"{words.with_interval(statistics.mean(of_believed), 2)}, {np.median(of_believed):.2f}"
            share = f"{sum(believed)} of {len(believed)}"
            _row(movement, hz, cell_hz, share, f"{figures}, {of_believed.max():.1f}", f"{np.median(worst):.0f}")


if __name__ == "__main__":
    main()
