"""The answer of ``jawenv identify`` to several recordings of one patient: printed, as JSON, and as the page."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from jawenv.base.errors import InputError
from jawenv.base.extras import of_the_clone
from jawenv.commands.answer import UNKNOWN, as_mapping, assumed_in_words, print_belief
from jawenv.commands.outputs import Answer, check_outputs
from jawenv.commands.recordings import NOT_BELIEVABLE, PAGE
from jawenv.metrics.calibration import alarm_word
from jawenv.recordings.estimate import Array, Estimate
from jawenv.recordings.files import load_record
from jawenv.recordings.identification import Identification
from jawenv.recordings.record import Record
from jawenv.recordings.several.together import MOST, agreement, combined, together
from jawenv.recordings.untold.learnt import identified_with_errors


def identify_together(
    paths: Sequence[Path],
    reading: Mapping[str, Any],
    page: Path | None,
    answer: Answer | None,
) -> int:
    """Print what several recordings of one patient tell together, and whether they agree.

    Args:
        paths: of the files, two or more.
        reading: arguments of ``load_record``.
        page: where the patient's page is written; None for nowhere.
        answer: where all is written as JSON; None for nowhere.

    Returns:
        Exit code: 0, or 3 where a recording is not to be believed or they do not agree.
    """
    if reading["before"] is not None:
        raise InputError("--before with several recordings; allowed: with one")
    if len(paths) > MOST:
        raise InputError(f"{len(paths)} recordings; allowed: 2 to {MOST}")
    check_outputs(page, answer, [*paths, *reading.values()])
    write_page = None if page is None else of_the_clone("--page", PAGE, "eval").write_page
    records = [load_record(path, UNKNOWN, **reading) for path in paths]
    _check_distinct(paths, records)
    found = []
    for path, record in zip(paths, records, strict=True):
        one, _ = identified_with_errors(record)
        found.append(one)
        worst = f"largest error bar {one.estimate.sd[-1].max():.1%}"
        alarm = f"alarm {alarm_word(one.misfit)}, misfit {one.misfit:.3g}"
        print(f"{path}: {record.time[-1]:g} s, {worst}; {alarm}")
    agree, result = _together(records, found)
    print(f"assumed: {assumed_in_words(records[0])}")
    test = f"chi-squared {agree.squares:.3g} of {agree.degrees}, p {agree.p:.2g}"
    print(f"agree:   {'yes, all can be of one patient' if agree.one_patient else 'no'} ({test})\n")
    believed = agree.one_patient and result.believable
    if agree.one_patient:
        print_belief(records[0], result)
        if write_page is not None:
            print(f"\npage: {write_page(records[0], result, None, paths[0], page, assumed_in_words(records[0]))}")
    if answer is not None:
        answer.write(_mapping(paths, records, found, agree, result))
    if not believed:
        print("\nNOT TO BE BELIEVED:", flush=True)
        if not agree.one_patient:
            print(f"- {_disagreement(agree, paths, records, found)}")
        for path, one in zip(paths, found, strict=True):
            print(*(f"- {path}: {doubt}" for doubt in one.doubts), sep="\n", end="\n" if one.doubts else "")
    return 0 if believed else NOT_BELIEVABLE


def _check_distinct(paths: Sequence[Path], records: Sequence[Record]) -> None:
    """Refuse the same readings twice: their information would count twice."""
    seen: dict[bytes, Path] = {}
    for path, record in zip(paths, records, strict=True):
        readings = record.measured.tobytes() + record.samples.tobytes()
        if readings in seen:
            raise InputError(f"{path}: has the readings of {seen[readings]}; allowed: each recording once")
        seen[readings] = path


def _together(records: Sequence[Record], found: Sequence[Identification]) -> tuple[Any, Identification]:
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


def _disagreement(agree: Any, paths: Sequence[Path], records: Sequence[Record], found: Sequence[Identification]) -> str:
    """The sentence that says which two recordings are not of one patient, and what differs most."""
    names = [str(paths[i]) for i in agree.pair]
    values = [f"{np.exp(found[i].estimate.mean[-1][agree.parameter]):.3g}" for i in agree.pair]
    name = records[0].parameter_names[agree.parameter].removeprefix("log_")
    return f"{names[0]} and {names[1]} are not of one patient in one state: {name} is {' and '.join(values)}"


def _mapping(
    paths: Sequence[Path],
    records: Sequence[Record],
    found: Sequence[Identification],
    agree: Any,
    result: Identification,
) -> dict[str, Any]:
    """The answer as a pipeline reads it: that to one recording, for all, then agreement and each recording's own."""
    triples = zip(paths, records, found, strict=True)
    each = [{"path": str(path)} | as_mapping(record, one) for path, record, one in triples]
    pair = [str(paths[i]) for i in agree.pair]
    said = {"one_patient": agree.one_patient, "chi_squared": agree.squares, "degrees": agree.degrees, "p": agree.p}
    return as_mapping(records[0], result) | {
        "believed": result.believable and agree.one_patient,
        "doubts": [*result.doubts, *([] if agree.one_patient else [_disagreement(agree, paths, records, found)])],
        "seconds": float(result.estimate.time[-1]),
        "agreement": said | {"least": pair},
        "recordings": each,
    }
