"""Recordings of one patient to an answer: `jawenv.identify`, and the command of the same name."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from jawenv.anatomy import Prior
from jawenv.answers.answer import Answer
from jawenv.answers.assumed import WIDER
from jawenv.base.errors import InputError
from jawenv.base.files import read_mapping
from jawenv.recordings.columns import FORCE, OPENING
from jawenv.recordings.defaults import BENCH
from jawenv.recordings.estimate import Array, Estimate
from jawenv.recordings.files import PathLike, load_record
from jawenv.recordings.identification import Identification
from jawenv.recordings.plausibility import findings
from jawenv.recordings.record import Record
from jawenv.recordings.several.together import MOST, Agreement, agreement, combined, together
from jawenv.recordings.size import by_its_motion, size_in
from jawenv.recordings.table import RecordTable, checked_path, read_table
from jawenv.recordings.untold.learnt import INCONSISTENT, Learnt, identified_with_errors
from jawenv.recordings.words import WORDS

if TYPE_CHECKING:
    from jawenv.answers.stretcher import StretcherAnswer


def identify(
    recordings: PathLike | Sequence[PathLike],
    *,
    cohort: Any = None,
    knowledge: Any = None,
    anatomy: Any = None,
    head_tilt_deg: float | None = None,
    columns: PathLike | None = None,
    resample_hz: float | None = None,
    before: PathLike | None = None,
) -> Answer | StretcherAnswer:
    """Estimate F_o and b of every muscle from a recording or several of one patient, with reasons for doubt.

    Sizes of errors that nobody told are learnt from the readings (docs/recordings.md). What is not said here is the
    file's, or that of a person of whom nothing is known: then the mandible's size is that of the motion. A prior at
    whose edge the estimates lie is widened once.

    Args:
        recordings: a ``.csv`` or ``.parquet`` file, or 2 to 8 of one patient in one state; or a stretcher's log of
            force and opening.
        cohort: population that the patient is believed to come from.
        knowledge: what is known of anatomy and device.
        anatomy: the patient's, as the environments take it.
        head_tilt_deg: pitch of the head, positive looking down; -80 lies on the back.
        columns: mapping file with the names, units and signs that the files have.
        resample_hz: rows per second to which uneven times are interpolated.
        before: an earlier log of the same patient; with a log alone.

    Returns:
        The answer: printed it is a table; ``believed`` and ``doubts`` say whether to trust it.

    Raises:
        InputError: a file that is none, or values that no device writes.
    """
    several = isinstance(recordings, Sequence) and not isinstance(recordings, str)
    paths = [str(path) for path in recordings] if several else [str(recordings)]  # type: ignore[union-attr]
    reading = {"cohort": cohort, "knowledge": knowledge, "anatomy": anatomy, "head_tilt_deg": head_tilt_deg}
    reading |= {"columns": columns, "resample_hz": resample_hz}
    if not 1 <= len(paths) <= MOST:
        raise InputError(f"{len(paths)} recordings; allowed: 1 to {MOST}")
    tables = [read_table(checked_path(path), WORDS) for path in paths]
    if len(tables) == 1 and _is_log(tables[0], None if columns is None else Path(columns)):
        from jawenv.answers.stretcher import answer_of_log

        return answer_of_log(tables[0], reading, before)
    if before is not None:
        raise InputError("before is given with recordings of six coordinates; allowed: with a log of force and opening")
    world = BENCH if anatomy is None else replace(BENCH, knowledge="imaged")  # who gives an anatomy has a scan
    records = [load_record(table, world, **reading) for table in tables]
    _check_distinct(paths, records)
    each = list[tuple[Identification, Learnt | None]]()
    for number, (path, record) in enumerate(zip(paths, records, strict=True), 1):
        rate = findings(record)[0]
        if not rate.plausible:
            raise InputError(f"{path}: {rate.columns} makes {rate.value}; allowed: {rate.allowed}")
        if len(paths) > 1:
            print(f"reads {path}, {number} of {len(paths)}", file=sys.stderr, flush=True)
        if len(paths) == 1:
            records[0], one, errors = _identified(tables[0], record, reading)
        else:  # which have to be of one jaw
            one, errors = identified_with_errors(record)
        each.append((one, errors))
    found, learnt = [one for one, _ in each], each[0][1]
    if len(found) == 1:
        answer = Answer((paths[0],), (records[0],), (found[0],), found[0], learnt, None)
        return _widened(answer) if cohort is None and answer.beyond_the_prior else answer
    agree, whole = _together(records, found)
    return Answer(tuple(paths), tuple(records), tuple(found), whole, None, agree)


def _is_log(table: RecordTable, columns: Path | None) -> bool:
    """Whether a file, or the mapping file to it, has an opening or one force in place of a mouthpiece's motion."""
    names = table.columns if columns is None else read_mapping(columns)
    return OPENING in names or FORCE in names


def _identified(
    table: RecordTable, record: Record, reading: dict[str, Any]
) -> tuple[Record, Identification, Learnt | None]:
    """The recording and its identification; by its motion where that shows a size, or where else it does not fit."""
    found, learnt = identified_with_errors(record)
    own = by_its_motion(table, record, **reading)
    fits = found.believable and found.temperature < INCONSISTENT
    if own is not None and (size_in(own.jaw) != 1.0 or not fits):
        again, errors = identified_with_errors(own)
        if again.believable and (not found.believable or size_in(own.jaw) != 1.0 or again.temperature < INCONSISTENT):
            return own, again, errors
    return record, found, learnt


def _widened(answer: Answer) -> Answer:
    """The answer under a prior of twice the sds: a patient whom the cohort hardly has."""
    (record,) = answer.records
    record = replace(record, prior=Prior(record.prior.mean, WIDER * record.prior.sd))
    found, learnt = identified_with_errors(record)
    return Answer(answer.paths, (record,), (found,), found, learnt, None)


def _check_distinct(paths: Sequence[str], records: Sequence[Record]) -> None:
    """Refuse the same readings twice: their information would count twice."""
    seen: dict[bytes, str] = {}
    for path, record in zip(paths, records, strict=True):
        readings = record.measured.tobytes() + record.samples.tobytes()
        if readings in seen:
            raise InputError(f"{path}: has the readings of {seen[readings]}; allowed: each recording once")
        seen[readings] = path


def _together(records: Sequence[Record], found: Sequence[Identification]) -> tuple[Agreement, Identification]:
    """Agreement of the recordings, and their identification: the first one's belief over time, then that of all."""
    prior, first = records[0].prior, found[0]
    means, covs = (np.array([getattr(one.estimate, name)[-1] for one in found]) for name in ("mean", "cov"))
    mean, cov = means[0], covs[0]
    for more, its in zip(means[1:], covs[1:], strict=True):
        mean, cov = (part[0] for part in combined((mean, cov), prior, more[None], its[None]))
    mean, cov = together(records, mean)
    trail = first.estimate
    end = sum(record.time[-1] for record in records)
    estimate = Estimate(trail.name, np.append(trail.time, end), _appended(trail.mean, mean), _appended(trail.cov, cov))
    sums = {name: sum(getattr(one, name) for one in found) for name in ("rows", "learnt_s", "refused", "numbers")}
    whole = replace(
        first,
        estimate=estimate,
        left_out=sum(one.left_out for one in found),
        misfit=max(one.misfit for one in found),
        findings=tuple(finding for one in found for finding in one.findings),
        rival=next((one.rival for one in found if one.rival), ""),
        **sums,
    )
    return agreement(prior, means, covs), whole


def _appended(values: Array, last: Array) -> Array:
    return np.concatenate([values, last[None]])
