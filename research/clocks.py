"""Recordings whose forces are late: found, taken out, refused; NEES/12 with `identify --clocks` and without.

    python -m research.clocks --patients 16

Told ``bench``, 20 s. Forces are late by whole ticks, which moves rows and nothing else.
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import replace

import numpy as np

import jawenv
from agents import load_agent
from eval.figures import statistics, words
from jawenv.recordings.clocks.delay import in_time
from jawenv.recordings.record import Record
from jawenv.recordings.untold.learnt import identified_with_errors

_LATE_MS = (0, 10, 30, 50)
_HEADINGS = ("cohort, movement", "late, ms", "NEES/12 as it is", "with --clocks", "found, ms", "refused, %")


def _late(record: Record, ticks: int) -> Record:
    """The recording with forces that are read so many ticks late; those of the first ticks are held."""
    before = np.repeat(record.samples[:1, :1], ticks, axis=0).repeat(record.samples.shape[1], axis=1)
    samples = np.concatenate([before, record.samples[: len(record.samples) - ticks]])
    return replace(record, samples=samples, wrenches=None)


def _nees(record: Record) -> float:
    """NEES over the number of parameters, of what `identify` answers."""
    estimate, truth = identified_with_errors(record)[0].estimate, np.asarray(record.truth)
    error = estimate.mean[-1] - truth
    return float(error @ np.linalg.solve(estimate.cov[-1], error)) / len(error)


def _cells(records: tuple[Record, ...], late_ms: int) -> list[str]:
    """Figures of recordings that are so late."""
    rows = []
    for record in records:
        spoilt = _late(record, round(late_ms / 1e3 / record.dt))
        mended, delay = in_time(spoilt)
        with_clocks = np.nan if delay.too_late else _nees(mended)
        rows.append((_nees(spoilt), with_clocks, 1e3 * delay.seconds if delay.shown else 0.0, delay.too_late))
    plain, mended_nees, found, refused = np.array(rows, dtype=float).T
    answered = mended_nees[np.isfinite(mended_nees)]
    means = [words.with_interval(statistics.mean(one), 2) if len(one) > 1 else "–" for one in (plain, answered)]
    return [str(late_ms), *means, f"{found.mean():.0f} ± {found.std():.0f}", f"{100.0 * refused.mean():.0f}"]


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--patients", type=int, default=16, help="of a cohort (default: %(default)s)")
    parser.add_argument("--seed", type=int, default=670_000, help="of the first (default: %(default)s)")
    parser.add_argument("--cohorts", nargs="+", default=["trismus", "one_sided"])
    parser.add_argument("--movements", nargs="+", default=["opening_with_swings_and_fore_aft", "slow_opening"])
    arguments = parser.parse_args()
    print(f"| {' | '.join(_HEADINGS)} |\n|---{'|--:' * (len(_HEADINGS) - 1)}|", flush=True)
    kwargs = {"record": True, "episode_s": 20.0, "knowledge": "bench", "track_bound": False}
    for cohort in arguments.cohorts:
        for movement in arguments.movements:
            played = jawenv.play(
                load_agent(movement),
                patients=arguments.patients,
                seed=arguments.seed,
                env_kwargs=kwargs | {"cohort": cohort},
            )
            for late_ms in _LATE_MS:
                cells = (f"`{cohort}`, {movement}", *_cells(tuple(played.records or ()), late_ms))
                print(f"| {' | '.join(cells)} |", flush=True)
                print(f"{cohort}, {movement}: {late_ms} ms", file=sys.stderr)


if __name__ == "__main__":
    main()
