"""Share of honest recordings that are called unbelievable, and of recordings spoilt as people spoil files.

    python -m research.recordings            # judged on seeds 20000 and on
    python -m research.recordings --tuning   # on seeds 5000 and on, for the thresholds

Prints for each kind how many are called unbelievable, with the statistics that the thresholds of
``jawenv.recordings.identification`` are about. Honest are recordings as they are, with anatomy known as an image gives
it, at 20 Hz, and with 5 % of the readings lost; patients and maneuvers follow each other. A spoilt recording is an
exact one with its numbers changed; at a third of the strength, a third of the way from what they were.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

import jawenv
from agents import load_agent
from jawenv.base.seeds import REPORTS, TUNING
from jawenv.recordings.identification import identified
from jawenv.recordings.record import Record
from jawenv.recordings.thinning import thinned
from research._beliefs import head, row

Array = NDArray[np.float64]

MANEUVERS = ("opening_with_swings_and_fore_aft", "refined", "slow_opening", "chirp")
HONEST = ("exact", "imaged", "20 Hz", "5 % lost")
Spoil = Callable[[Array, Array], tuple[Array, Array]]


def _spoilings(start: Array) -> dict[str, Spoil]:
    """Common faults in ``measured`` (T + 1, 12) and ``samples`` (T, 3, 6); ``start`` (3) is the first position."""
    right = np.array([1.0, -1.0, 1.0])
    pitch = np.array([1, 1, 1, -1, 1, 1, 1, 1, 1, 1, -1, 1.0])
    radians = np.repeat([1.0, np.pi / 180.0, 1.0, np.pi / 180.0], 3)
    metres = np.repeat([1e-3, 1.0, 1e-3, 1.0], 3)
    origin = np.concatenate([start, np.zeros(9)])
    force, moment = np.repeat([1.0, 0.0], 3), np.repeat([0.0, 1.0], 3)
    return {
        "forces of the jaw on the device": lambda m, s: (m, -s),
        "degrees written in radians": lambda m, s: (m * radians, s),
        "metres in mm columns": lambda m, s: (m * metres, s),
        "forces in grams": lambda m, s: (m, s * (moment + force * 1e3 / 9.80665)),
        "kilogram-force": lambda m, s: (m, s * (moment + force / 9.80665)),
        "moments in N mm": lambda m, s: (m, s * (force + moment * 1e3)),
        "the tracker's own origin": lambda m, s: (m - origin, s),
        "y to the right": lambda m, s: (
            m * np.concatenate([right, np.ones(3), right, np.ones(3)]),
            s * np.concatenate([right, np.ones(3)]),
        ),
        "pitch opens negative": lambda m, s: (m * pitch, s),
        "a cell's gain of 1.2": lambda m, s: (m, 1.2 * s),
    }


RATES = {"frame numbers as s": 100.0, "ms as s": 1e3, "us as s": 1e6}


def spoilt(record: Record, strength: float) -> Iterator[tuple[str, Record]]:
    """The record, spoilt in each way."""
    m, s = record.measured, record.samples
    for name, change in _spoilings(record.measured[0, :3]).items():
        measured, samples = change(m, s)
        yield (
            name,
            replace(record, measured=m + strength * (measured - m), samples=s + strength * (samples - s)),
        )
    if strength == 1.0:
        for name, factor in RATES.items():
            yield name, replace(record, time=record.time * factor)


def _honest(kind: str, seed: int, episode_s: float) -> Record:
    """A simulated patient's record."""
    kwargs: dict[str, Any] = {
        "record": True,
        "episode_s": episode_s,
        "knowledge": "imaged" if kind == "imaged" else "exact",
    }
    if kind == "5 % lost":
        kwargs["reality"] = {"lost_share": 0.05}
    agent = load_agent(MANEUVERS[seed // len(HONEST) % len(MANEUVERS)])
    records = jawenv.play(agent, patients=1, seed=seed, env_kwargs=kwargs).records
    assert records is not None
    record = records[0]
    return thinned(record, 5) if kind == "20 Hz" else record


def judged(record: Record) -> tuple[bool, float, float, float, float]:
    """Judge a record: unbelievable or not; misfit, share of rows refused, of numbers left out; largest error in sds."""
    if not 20.0 <= 1.001 / record.dt <= 1001.0:  # ``jawenv identify`` refuses the file
        return True, np.nan, np.nan, np.nan, np.nan
    result = identified(record)
    assert record.truth is not None
    off = float((np.abs(result.estimate.mean[-1] - record.truth) / result.estimate.sd[-1]).max())
    shares = result.refused / max(result.rows, 1), result.left_out / max(result.numbers, 1)
    return not result.believable, result.misfit, *shares, off


def _rows(seeds: range, number: int, spoilt_number: int, episode_s: float) -> dict[str, list[tuple[float, ...]]]:
    """Judgements of every recording, by kind."""
    results: dict[str, list[tuple[float, ...]]] = {}
    for i in range(number):
        kind = HONEST[i % len(HONEST)]
        record = _honest(kind, seeds[i], episode_s)
        results.setdefault(f"honest, {kind}", []).append(judged(record))
        if kind == "exact" and i // len(HONEST) < spoilt_number:
            for strength, label in ((1.0, ""), (1.0 / 3.0, ", a third")):
                for name, changed in spoilt(record, strength):
                    results.setdefault(f"{name}{label}", []).append(judged(changed))
    return results


def _table(results: dict[str, list[tuple[float, ...]]]) -> None:
    """Print medians, with the largest in brackets."""
    head("recording", "unbelievable", "misfit, median (largest)", "rows refused", "numbers left out", "error, sds")
    for kind, judgements in results.items():
        values = np.array(judgements, dtype=np.float64)
        cells = [f"{int(values[:, 0].sum())} of {len(values)}"]
        for column, factor, unit in ((1, 1.0, ""), (2, 100.0, " %"), (3, 100.0, " %"), (4, 1.0, "")):
            scaled = factor * values[:, column]
            cells.append("–" if np.isnan(scaled).all() else f"{np.median(scaled):.3g}{unit} ({scaled.max():.3g}{unit})")
        row(kind, *cells)


def main() -> None:
    """Judge the recordings, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--tuning", action="store_true", help="seeds of tuning in place of those of judging")
    parser.add_argument("--honest", type=int, default=200, help="how many honest recordings")
    parser.add_argument("--spoilt", type=int, default=8, help="how many recordings are spoilt in each way")
    parser.add_argument("--episode-s", type=float, default=10.0)
    arguments = parser.parse_args()
    seeds = TUNING if arguments.tuning else REPORTS[1]
    _table(_rows(seeds, arguments.honest, arguments.spoilt, arguments.episode_s))


if __name__ == "__main__":
    main()
