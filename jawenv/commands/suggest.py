"""``jawenv suggest``: the movement to record next, for the patient of a recording."""

from __future__ import annotations

import sys
from functools import partial
from pathlib import Path
from typing import Any

from jawenv.answers.answer import least_known
from jawenv.base.errors import InputError
from jawenv.base.files import check_kept
from jawenv.playing.maneuvers.written import save_maneuver
from jawenv.recordings.defaults import BENCH
from jawenv.recordings.files import load_record
from jawenv.suggesting.lead import led_back
from jawenv.suggesting.suggestion import BESIDE, suggest


def suggest_next(path: Path, output: Path, wanted: dict[str, Any], reading: dict[str, Any], overwrite: bool) -> None:
    """Write the maneuver to record next, and say what it is expected to tell.

    Args:
        path: of the recording.
        output: of the maneuver.
        wanted: arguments of ``suggest``.
        reading: arguments of ``load_record``.
        overwrite: whether an older maneuver may be replaced.
    """
    if output.suffix != ".yaml":
        raise InputError(f"--output: {output}; allowed: a file that ends in .yaml")
    if output.exists() and not overwrite:
        raise InputError(f"--output: {output} exists already; replace it with --overwrite")
    check_kept(output, [path, *reading.values()])
    record = load_record(path, BENCH, **reading)
    found = suggest(record, **wanted, announce=partial(print, file=sys.stderr, flush=True))
    maneuver, before = led_back(record, found)
    save_maneuver(maneuver, output)
    weakest = least_known(record, found.found)
    of = f" of {wanted['asked']}" if wanted.get("asked") else ""
    least = f"{weakest['words']}, sd {weakest['sd']:.1%}"
    print(f"least known now: {least}; largest error bar{of} {found.worst_sd:.1%}")
    print(f"next: {found.movement()}{before}")
    comfort = f"discomfort {found.expected.discomfort_s:.3f} s"
    print(f"expected after {found.seconds:g} s more: {_in_words(found.expected)}, {comfort}")
    print(f"in its place: the same again {found.again:.1%}, {BESIDE} {_in_words(found.beside)}")
    print(f"maneuver: {output}")


def _in_words(expected: Any) -> str:
    return f"{expected.median:.1%} ({expected.low:.1%} to {expected.high:.1%})"
