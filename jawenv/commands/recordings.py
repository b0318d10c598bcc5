"""The command ``jawenv identify``."""

from __future__ import annotations

import importlib
import json
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from jawenv.base.errors import InputError, MissingPackageError
from jawenv.base.files import check_kept, write_text
from jawenv.commands.answer import UNKNOWN, as_mapping, assumed_in_words, doubts_in_words, print_belief
from jawenv.metrics.calibration import YELLOW, alarm_word
from jawenv.recordings.clocks.delay import in_time
from jawenv.recordings.files import load_record
from jawenv.recordings.plausibility import findings
from jawenv.recordings.stretcher.log import is_log
from jawenv.recordings.table import checked_path, read_table
from jawenv.recordings.untold.learnt import identified_with_errors
from jawenv.recordings.words import WORDS

NOT_BELIEVABLE = 3


def identify(
    path: Path, reading: Mapping[str, Any], page: Path | None, answer: Path | None = None, clocks: bool = False
) -> int:
    """Print what the environments' filter finds in a recording, and whether it is to be believed.

    Args:
        path: of the file.
        reading: arguments of ``load_record``.
        page: where the patient's page is written; None for nowhere.
        answer: where all is written as JSON; None for nowhere.
        clocks: whether a delay of the forces is looked for.

    Returns:
        Exit code: 0, or 3 where the estimates are not to be believed.
    """
    table = read_table(checked_path(path), WORDS)
    if is_log(table, reading["columns"]):
        from jawenv.commands.stretcher import identify_log

        return identify_log(table, reading, {"page": page, "clocks": clocks or None}, answer)
    write_page = None if page is None else page_writer()
    for output in (page, answer):
        if output is not None:
            check_kept(output, [path, reading.get("columns")])
    if page is not None and answer is not None and page.resolve() == answer.resolve():
        raise InputError(f"--page and --json are both {page}; allowed: two files")
    record = load_record(table, UNKNOWN, **reading)
    rate = findings(record)[0]
    if not rate.plausible:
        raise InputError(f"{path}: {rate.columns} makes {rate.value}; allowed: {rate.allowed}")
    delay = None
    if clocks:
        record, delay = in_time(record)
    result, last = identified_with_errors(record)
    if delay and delay.too_late:
        result = replace(result, rival=f"{delay}")
    print(f"{path}: {record.time[-1]:g} s at {1.0 / record.dt:.3g} Hz")
    fitted = result.rows - result.refused
    print(f"rows:    {result.rows:,} read, {fitted:,} fitted, {result.refused:,} refused by the filter's gate")
    print(f"numbers: {result.numbers:,} read, {result.left_out:,} left out (out of range, or of a frozen sensor)")
    print(f"assumed: {assumed_in_words(record)}")
    if delay:
        print(f"clocks:  {delay}")
    word = alarm_word(result.misfit).replace("rings", "RINGS")
    print(f"alarm:   {word}, misfit {result.misfit:.3g} (yellow above {YELLOW:g}, it rings above 1)\n")
    print_belief(record, result)
    if write_page is not None:
        print(f"\npage: {write_page(record, result, last, path, page, assumed_in_words(record))}")
    if answer is not None:
        late = {"forces_late_s": delay.seconds} if delay else {}
        write_text(answer, json.dumps(as_mapping(record, result) | late, indent=1) + "\n")
        print(f"\nanswer: {answer}")
    if not result.believable:
        print("\nNOT TO BE BELIEVED:", flush=True)
        print(*doubts_in_words(record, result), sep="\n")
    return 0 if result.believable else NOT_BELIEVABLE


def check(path: Path, reading: Mapping[str, Any], others: Mapping[str, Any]) -> int:
    """Print whether a recording can be one of a jaw on a device, quantity by quantity; nothing is estimated.

    Args:
        path: of the file.
        reading: arguments of ``load_record``.
        others: options of an estimate, none of which may be given.

    Returns:
        Exit code: 0, or 3 where a quantity is not plausible.
    """
    for name in (name for name, value in others.items() if value):
        raise InputError(f"--{name} with --check, which estimates nothing; allowed: one of the two")
    checks = findings(load_record(path, **reading))
    for finding in checks:
        word = "ok " if finding.plausible else "NOT"
        print(f"{word} {finding.columns:20} {finding.value:40} allowed: {finding.allowed}")
    return 0 if all(finding.plausible for finding in checks) else NOT_BELIEVABLE


def page_writer(module: str = "eval.patient.recordings") -> Any:
    """A page's writer ``write_page`` of a module, which a clone of the project has and the wheel has not."""
    try:
        return importlib.import_module(module).write_page
    except ModuleNotFoundError as error:
        raise MissingPackageError(
            f"--page: {error.name} is not installed; allowed in a clone of the project, with its extra eval "
            "(.ci/setup eval)"
        ) from None
