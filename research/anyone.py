"""Worth of what ``jawenv identify`` says of files as laboratories write them, and of people without a scan.

    python -m research.anyone {people,rates,late,laws,loop} --patients 24

Times, places, angles and one reading of the load cell a row: no velocities, no header, no word of the patient. The
tracker has a rate of its own; readings of a cell that is slower stand in the nearest rows, between them cells are
empty. rates: people of ``anyone`` with a scan's anatomy. people: every cohort with and without a scan, other sizes, a
head that lies back, axes laid through condyles that were felt for, a bench on which all is a little wrong. loop: what
a device would believe on its way. A row is printed as soon as it is there.
"""

from __future__ import annotations

import argparse
import csv
import sys
import tempfile
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline

import jawenv
from agents import load_agent
from eval.figures import statistics, words
from jawenv.anatomy import COHORTS
from jawenv.anatomy.description import Anatomy
from jawenv.anatomy.knowledge import BENCH, IMAGED
from jawenv.answers.answer import Answer
from jawenv.answers.tension import along_the_way
from jawenv.device.device import Device
from jawenv.filter.model.encoders import N_MEASUREMENTS, measure
from jawenv.inference.treatable import treatable
from jawenv.metrics.diagnosis import BLOCKED_B, STIFF_F_O_N
from jawenv.metrics.verdicts import BLOCKED, BOTH, FINDINGS, STIFF
from jawenv.reality.tissue import STRAIGHT_TO
from jawenv.recordings.columns import ENCODERS, READINGS, TIME
from jawenv.recordings.estimate import Array
from jawenv.recordings.record import Record
from jawenv.recordings.record_filter import TensionFilter
from jawenv.recordings.size import sized
from jawenv.recordings.untold.learnt import learnt
from research._beliefs import Beliefs, head, row

MOVEMENTS = ("refined", "slow_opening")
RATES = tuple(product((60, 120, 240), (20, 80)))
"""Hz of tracker and load cell."""
TRACKER_HZ, CELL_HZ = 120, 80
LATE_MS = (10, 20, 40)
LAW_MM = (10.0, 20.0)
NO_SCAN = {"attachment_error": 1.0}
SMALL_ERRORS = {
    "cell_bias_N": 0.1,
    "cell_bias_N_m": 0.002,
    "head_tilt_error_deg": 3.0,
    "mouthpiece_error_mm": 0.5,
    "mouthpiece_error_deg": 0.5,
    "encoder_play_mm": 0.2,
    "creep_share": 0.2,
    "cell_error_deg": 0.5,
}
_POSE = 6
QUIET = {
    "encoder_position_mm": 1e-3,
    "encoder_angle_deg": 1e-3,
    "encoder_velocity_mm_s": 0.01,
    "encoder_rate_rad_s": 2e-4,
}
"""Encoders without noise, so that shapes of the true geometry are none of noise, which would be an error that lasts."""
NOISE = np.repeat([1e-3 * Device().encoder_position_mm, np.radians(Device().encoder_angle_deg)], 3)


def lab_file(record: Record, hz: float, cell_hz: float, path: Path, seed: int = 0, late_s: float = 0.0) -> None:
    """Write a played record as a laboratory's file.

    Args:
        record: with true states, of ``QUIET`` encoders.
        hz: of the tracker, whose noise is that of the device.
        cell_hz: of the load cell.
        path: of a CSV file.
        seed: of the noise.
        late_s: by which forces are written later than they were.
    """
    assert record.states is not None
    time = np.arange(int(record.time[-1] * hz + 1e-9) + 1) / hz
    states = CubicSpline(record.time, record.states)(time)
    off = np.linalg.lstsq(_shapes(record.states, record), record.measured[:, :_POSE] - _poses(record, record.states))[0]
    noise = NOISE * np.random.default_rng(seed).standard_normal((len(time), _POSE))
    pose = _poses(record, states) + _shapes(states, record) @ off + noise
    at = np.arange(int(record.time[-1] * cell_hz + 1e-9) + 1) / cell_hz
    moments = (record.time[:-1, None] + record.dt * np.array([0.0, 0.5])).ravel()
    forces = np.full((len(time), len(READINGS)), np.nan)
    rows = np.minimum(np.round(at * hz).astype(int), len(time) - 1)
    for k, values in enumerate(record.samples[:, :2].reshape(-1, len(READINGS)).T):
        forces[rows, k] = np.interp(at - late_s, moments, values)
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


class _Judged(NamedTuple):
    """The answer to one file beside the truth."""

    believed: bool
    nees: float  # over the number of parameters
    worst: float  # error bar, %
    findings: int  # on muscles
    right: int  # of these


def _answer(record: Record, seed: int, hz: float = TRACKER_HZ, cell_hz: float = CELL_HZ, late_s: float = 0.0) -> Answer:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "lab.csv"
        lab_file(record, hz, cell_hz, path, seed, late_s)
        answer = jawenv.identify(path)
    assert isinstance(answer, Answer)
    return answer


def _beside(answer: Answer, record: Record) -> _Judged:
    assert record.truth is not None
    nees = float(Beliefs.of(answer.log_mean, answer.log_cov, record.truth).nees)
    truly = np.exp(record.truth).reshape(-1, 2) > [STIFF_F_O_N, BLOCKED_B]
    pairs = zip(answer.verdicts.values(), truly, strict=True)
    given = [(verdict.word, true.tolist()) for verdict, true in pairs if verdict.word in FINDINGS]
    right = sum([word in (STIFF, BOTH), word in (BLOCKED, BOTH)] == true for word, true in given)
    return _Judged(answer.believed, nees, 100.0 * float(answer.log_sd.max()), len(given), right)


def _judged(records: Sequence[Record], **lab: float) -> tuple[str, ...]:
    """Figures of the answers to played records, each written as a laboratory's file."""
    return _figures([_beside(_answer(record, seed, **lab), record) for seed, record in enumerate(records)])


def _figures(found: list[_Judged]) -> tuple[str, ...]:
    believed = [one for one in found if one.believed]
    share = f"{len(believed)} of {len(found)}"
    if not believed:
        return share, "–", "–", "–"
    right, findings = sum(one.right for one in believed), sum(one.findings for one in believed)
    nees, worst = np.array([one.nees for one in believed]), np.median([one.worst for one in believed])
    return share, _spread(nees), f"{worst:.0f}", f"{right} of {findings}"


def _spread(nees: Array) -> str:
    return f"{words.with_interval(statistics.mean(nees), 2)}, {np.median(nees):.2f}, {nees.max():.1f}"


def recordings_of(
    arguments: argparse.Namespace, movement: str, *, tilt: float = 0.0, **world: Any
) -> tuple[Record, ...]:
    """Recordings of people drawn by a cohort, with their heads pitched, in a world with these arguments."""
    kwargs: dict[str, Any] = {
        "record": True,
        "episode_s": arguments.seconds,
        "knowledge": "imaged",
        "track_bound": False,
        "device": QUIET,
    } | world
    if tilt == 0.0:
        return _played(movement, arguments.patients, arguments.seed, kwargs)
    found = list[Record]()
    rows = COHORTS[world["cohort"]].sample(2 * arguments.patients, arguments.seed, accept=treatable)
    for number, theta in enumerate(rows):
        patient = jawenv.Patient.from_log_parameters(theta, head_tilt_deg=tilt)
        with suppress(jawenv.InputError):  # a head so pitched may let the jaw hang open
            found += _played(movement, [patient], arguments.seed + number, kwargs)
        if len(found) == arguments.patients:
            break
    return tuple(found)


def _played(movement: str, people: Any, seed: int, kwargs: dict[str, Any]) -> tuple[Record, ...]:
    played = jawenv.play(load_agent(movement), patients=people, seed=seed, env_kwargs=kwargs)
    assert played.records is not None
    return played.records


HEAD = ("believed", "NEES/12 of these, median, largest", "worst error bar, %", "findings right")


def rates(arguments: argparse.Namespace) -> None:
    """Print a row for each rate of tracker and load cell."""
    head("movement", "tracker, Hz", "cell, Hz", *HEAD)
    for movement in MOVEMENTS:
        records = recordings_of(arguments, movement, cohort="anyone")
        for hz, cell_hz in RATES:
            row(movement, hz, cell_hz, *_judged(records, hz=hz, cell_hz=cell_hz))


def people(arguments: argparse.Namespace) -> None:
    """Print a row for each kind of people."""
    both: dict[str, dict[str, Any]] = {"a scan's anatomy": {}, "the table's anatomy": {"reality": NO_SCAN}}
    kinds = [(cohort, title, world) for cohort in COHORTS for title, world in both.items()]
    kinds += [("anyone", f"size {size:g}", {"anatomy": sized(size)}) for size in (0.85, 0.93, 1.07, 1.15)]
    kinds += [("anyone", "left 6 % larger, right 6 % smaller", {"anatomy": _lopsided(0.06)})]
    kinds += [("anyone", "size 0.93, the table's anatomy", {"anatomy": sized(0.93), "reality": NO_SCAN})]
    felt = {"knowledge": replace(IMAGED, axes_mm=2.0)}
    kinds += [("anyone", f"{title}, axes off by 2 mm", felt | world) for title, world in both.items()]
    tilts = (-20.0, -45.0, -80.0)
    kinds += [("trismus", f"head at {tilt:g} degrees", {"tilt": tilt}) for tilt in tilts]
    kinds += [("anyone", "the table's anatomy, a bench's small errors", {"reality": NO_SCAN | SMALL_ERRORS})]
    head("cohort", "people", *HEAD, texts=2)
    for cohort, title, world in kinds:
        records = recordings_of(arguments, MOVEMENTS[0], cohort=cohort, **world)
        row(cohort, title, *_judged(records))


def _lopsided(part: float) -> Anatomy:
    """The table's lines of muscles, on the left by a part farther from the condyles, on the right nearer."""
    factors, table = {"left": 1.0 + part, "right": 1.0 - part}, sized(1.0)
    lines = {
        name: replace(line, origin_m=factor * line.origin_m, insertion_m=factor * line.insertion_m)
        for name, line in table.attachments.items()
        for factor in [factors[name.rsplit("_", 1)[1]]]
    }
    return replace(table, attachments=lines)


def late(arguments: argparse.Namespace) -> None:
    """Print a row for each movement and time by which forces are late."""
    row("movement", "forces late by, ms", *HEAD)
    print("|---|" + 5 * "--:|", flush=True)
    for movement in MOVEMENTS:
        records = recordings_of(arguments, movement, cohort="anyone")
        for ms in LATE_MS:
            row(movement, ms, *_judged(records, late_s=1e-3 * ms))


def loop(arguments: argparse.Namespace) -> None:
    """Print a row for each cohort of what a device would believe, in the loop, of people without a scan."""
    head("cohort", "filter: NEES/12, median, largest", "with sizes learnt")
    for cohort in ("trismus", "anyone", "severe"):
        nees = np.zeros((2, arguments.patients))
        for number, record in enumerate(recordings_of(arguments, MOVEMENTS[0], cohort=cohort, reality=NO_SCAN)):
            told = replace(record, knowledge=BENCH)
            found = TensionFilter().estimate(told)  # bit for bit what an online filter believes
            last = learnt(told, found.mean[-1], found.cov[-1])
            assert record.truth is not None and last is not None
            for k, one in enumerate(((found.mean[-1], found.cov[-1]), (last.mean, last.cov))):
                nees[k, number] = Beliefs.of(*one, record.truth).nees
        row(cohort, *(_spread(of) for of in nees))


def laws(arguments: argparse.Namespace) -> None:
    """Print a row for each cohort and share of tensions that is a straight line; anatomies are those of the table."""
    row("cohort", "straight, %", *HEAD, "law named", *(f"force at {mm:g} mm: error, %, NEES" for mm in LAW_MM))
    print("|---|" + (6 + len(LAW_MM)) * "--:|", flush=True)
    for cohort, share in product(("trismus", "healthy", "anyone"), (0.0, 0.5, 1.0)):
        law = {"straight_share": share}
        records = recordings_of(arguments, MOVEMENTS[0], cohort=cohort, knowledge="exact", reality=law)
        answers = [_answer(record, i) for i, record in enumerate(records)]
        found = [_beside(answer, record) for answer, record in zip(answers, records, strict=True)]
        believed = [pair for pair in zip(answers, records, strict=True) if pair[0].believed]
        named = sum(one.learnt is not None and one.learnt.sizes["law"] > 0.0 for one, _ in believed)
        forces = (_force_cell([_force(*pair, mm, share) for pair in believed]) for mm in LAW_MM)
        row(cohort, f"{100.0 * share:g}", *_figures(found), f"{named} of {len(believed)}", *forces)


def _force(answer: Answer, record: Record, mm: float, share: float) -> tuple[float, float]:
    """Error of the closing force at an opening, relative, and its square in error bars; NaN beyond the recording."""
    assert record.truth is not None
    _, opening, strain, growth = along_the_way(record)
    F_o, b = np.exp(record.truth).reshape(-1, 2)[record.jaw["muscle"]].T
    line = np.maximum(0.0, F_o + F_o * np.expm1(STRAIGHT_TO * b) * strain / STRAIGHT_TO)
    tension = share * line + (1.0 - share) * F_o * np.exp(b * strain)
    truth = np.interp(1e-3 * mm, opening, np.sum(tension * growth, axis=1))
    for one in answer.tension["all"]:
        if one.opening_mm == mm:
            return one.force_N / truth - 1.0, ((one.force_N - truth) / one.force_sd_N) ** 2
    return np.nan, np.nan


def _force_cell(forces: list[tuple[float, float]]) -> str:
    if not np.isfinite(forces).any():
        return "–"
    error, square = np.nanmean(forces, axis=0)
    return f"{100.0 * error:+.1f}, {square:.2f}"


TABLES = {"rates": rates, "people": people, "late": late, "laws": laws, "loop": loop}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("table", choices=TABLES)
    parser.add_argument("--patients", type=int, default=24, help="of each row")
    parser.add_argument("--seed", type=int, default=480_000)
    parser.add_argument("--seconds", type=float, default=10.0, help="of each movement")
    arguments = parser.parse_args()
    print(f"`python -m research.anyone {' '.join(sys.argv[1:])}`:\n")
    TABLES[arguments.table](arguments)


if __name__ == "__main__":
    main()
