"""Worth of what ``jawenv identify`` says of files without a header, for every cohort: nothing is told of the patient.

    python -m research.anyone --patients 12 > docs/tables/anyone.md

Truth is drawn with the anatomy's errors of a scan. A file has the columns alone and is read as of anyone on a bench.
Movements of 30 s, and their first 10 s. *Own prior*: the same files of 30 s of ``refined``, read as of their own
cohort. *In full*: right verdicts that leave nothing open, as `stiff` alone does where the muscle is blocked too. A row
is printed as soon as it is there.
"""

from __future__ import annotations

import argparse
import tempfile
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import jawenv
from agents import load_agent
from eval.figures import statistics, words
from jawenv.anatomy import COHORTS
from jawenv.commands.answer import UNKNOWN, judgements
from jawenv.metrics.verdicts import FINDINGS, truly
from jawenv.recordings.files import load_record, save_record
from jawenv.recordings.record import Record
from jawenv.recordings.untold.learnt import identified_with_errors

_SECONDS, _SHORT = 30.0, 10.0
_RICH, _PLAIN = "refined", "slow_opening"
_LEFT_OUT = ("wide",)


class _Answer(NamedTuple):
    """The answer to one file."""

    believed: bool
    nees: float  # over the number of parameters
    worst_sd: float
    given: int  # verdicts
    in_full: int  # right ones that leave nothing open, as `stiff` alone does where the muscle is blocked too


def _answer(record: Record, cohort: Any, folder: Path) -> _Answer:
    """The answer to the columns of a record alone, read as of a cohort."""
    path = folder / "bench.csv"
    save_record(record, path)
    lines = path.read_text(encoding="utf-8").splitlines(keepends=True)
    path.write_text("".join(line for line in lines if not line.startswith("#")), encoding="utf-8")
    read = load_record(path, replace(UNKNOWN, cohort=cohort))
    found, _ = identified_with_errors(read)
    assert record.truth is not None
    error, cov = found.estimate.mean[-1] - record.truth, found.estimate.cov[-1]
    nees = float(error @ np.linalg.solve(cov, error)) / len(error)
    said = [one.word for one in judgements(read, found)]
    whole = [truly(record.truth[2 * i : 2 * i + 2]) == word for i, word in enumerate(said) if word in FINDINGS]
    return _Answer(found.believable, nees, float(found.estimate.sd[-1].max()), len(whole), sum(whole))


def _row(*cells: object) -> None:
    print(f"| {' | '.join(map(str, cells))} |", flush=True)


def _of_cohort(cohort: str, movement: str, arguments: argparse.Namespace, folder: Path) -> None:
    kwargs = {"record": True, "episode_s": _SECONDS, "cohort": cohort, "knowledge": "imaged", "track_bound": False}
    played = jawenv.play(load_agent(movement), patients=arguments.patients, seed=arguments.seed, env_kwargs=kwargs)
    assert played.records is not None
    records = [record for record, lasts in zip(played.records, played.valid[:, -1], strict=True) if lasts]
    for seconds in (_SHORT, _SECONDS):
        cut = [record.until(seconds) for record in records]
        found = [_answer(record, UNKNOWN.cohort, folder) for record in cut]
        own: list[_Answer] = []
        if seconds == _SECONDS and movement == _RICH:
            own = [_answer(record, cohort, folder) for record in cut]
        believed, nees, worst, given, whole = (np.array(values) for values in zip(*found, strict=True))
        wider = f"{np.median(worst / [one.worst_sd for one in own]):.2f}" if own else ""
        _row(
            cohort,
            movement,
            f"{seconds:g}",
            f"{believed.sum()} of {len(found)}",
            f"{words.with_interval(statistics.mean(nees), 2)}, {np.median(nees):.2f}",
            f"{100.0 * np.median(worst):.0f}",
            f"{given.sum()} of {6 * len(found)}",
            whole.sum(),
            sum(one.given for one in own) if own else "",
            wider,
        )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--patients", type=int, default=12, help="of each row")
    parser.add_argument("--seed", type=int, default=430_000)
    parser.add_argument("--cohorts", nargs="*", choices=COHORTS, help="all but wide by default")
    arguments = parser.parse_args()
    print("# Files without a header\n")
    print(f"`python -m research.anyone --patients {arguments.patients} --seed {arguments.seed}`:\n")
    _row(
        *("patient", "movement", "s", "believed", "NEES/12, median", "worst error bar, %", "verdicts", "in full"),
        *("under the own prior", "worst error bar x"),
    )
    print("|---|---|" + 8 * "--:|", flush=True)
    cohorts = arguments.cohorts or [name for name in COHORTS if name not in _LEFT_OUT]
    with tempfile.TemporaryDirectory() as folder:
        for cohort, movement in product(cohorts, (_RICH, _PLAIN)):
            _of_cohort(cohort, movement, arguments, Path(folder))


if __name__ == "__main__":
    main()
