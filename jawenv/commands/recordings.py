"""The command ``jawenv identify``."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from jawenv.base.errors import InputError
from jawenv.base.extras import of_the_clone
from jawenv.commands.answer import UNKNOWN, as_mapping, assumed_in_words, doubts_in_words, print_belief
from jawenv.commands.outputs import Answer, check_outputs
from jawenv.metrics.calibration import YELLOW, alarm_word
from jawenv.recordings.files import load_record
from jawenv.recordings.plausibility import findings
from jawenv.recordings.record import Record
from jawenv.recordings.stretcher.log import is_log
from jawenv.recordings.table import checked_path, read_table
from jawenv.recordings.untold.bank import DRIFT
from jawenv.recordings.untold.learnt import Learnt, identified_with_errors
from jawenv.recordings.words import WORDS
from jawenv.recordings.zero import UNSEEN_DRIFT, change_of_zero

NOT_BELIEVABLE = 3
PAGE = "eval.patient.recordings"  # writes a patient's page


def identify(path: Path, reading: Mapping[str, Any], page: Path | None, answer: Answer | None = None) -> int:
    """Print what the environments' filter finds in a recording, and whether it is to be believed.

    Args:
        path: of the file.
        reading: arguments of ``load_record``.
        page: where the patient's page is written; None for nowhere.
        answer: where all is written as JSON; None for nowhere.

    Returns:
        Exit code: 0, or 3 where the estimates are not to be believed.
    """
    table = read_table(checked_path(path), WORDS)
    if is_log(table, reading["columns"]):
        from jawenv.commands.stretcher import identify_log

        return identify_log(table, reading, {"page": page}, answer)
    write_page = None if page is None else of_the_clone("--page", PAGE, "eval").write_page
    check_outputs(page, answer, [path, *reading.values()])
    record = load_record(table, UNKNOWN, **reading)
    rate = findings(record)[0]
    if not rate.plausible:
        raise InputError(f"{path}: {rate.columns} makes {rate.value}; allowed: {rate.allowed}")
    result, last = identified_with_errors(record)
    print(f"{path}: {record.time[-1]:g} s at {1.0 / record.dt:.3g} Hz")
    fitted = result.rows - result.refused
    print(f"rows:    {result.rows:,} read, {fitted:,} fitted, {result.refused:,} refused by the filter's gate")
    print(f"numbers: {result.numbers:,} read, {result.left_out:,} left out (out of range, or repeated)")
    print(f"assumed: {assumed_in_words(record)}")
    print(f"zero:    {_zero_in_words(record, last)}")
    word = alarm_word(result.misfit).replace("rings", "RINGS")
    print(f"alarm:   {word}, misfit {result.misfit:.3g} (yellow above {YELLOW:g}, it rings above 1)\n")
    print_belief(record, result)
    if write_page is not None:
        print(f"\npage: {write_page(record, result, last, path, page, assumed_in_words(record))}")
    if answer is not None:
        answer.write(as_mapping(record, result))
    if not result.believable:
        print("\nNOT TO BE BELIEVED:", flush=True)
        print(*doubts_in_words(record, result), sep="\n")
    return 0 if result.believable else NOT_BELIEVABLE


def _zero_in_words(record: Record, last: Learnt | None) -> str:
    """Drift of the load cell's zero, in words."""
    changed = change_of_zero(record)
    seen = f"a drift is not seen: {UNSEEN_DRIFT}" if changed is None else f"changes by {changed:.2g} N until the end"
    drift = 0.0 if last is None else last.sizes[DRIFT]
    return f"{seen}; error bars allow for {drift:g} N over a third of the recording" if drift else seen
