"""The commands ``jawenv identify`` and ``jawenv doctor``."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from jawenv.answers.answer import Answer
from jawenv.answers.identify import identify
from jawenv.base.errors import InputError
from jawenv.base.extras import of_the_clone
from jawenv.commands.outputs import Output, check_outputs
from jawenv.recordings.defaults import BENCH
from jawenv.recordings.files import load_record

NOT_BELIEVABLE = 3
PAGE = "eval.patient.recordings"  # writes a patient's page


def print_answer(paths: Sequence[Path], reading: Mapping[str, Any], page: Path | None, output: Output | None) -> int:
    """Print what recordings of one patient tell, and whether it is to be believed.

    Args:
        paths: of the files.
        reading: arguments of ``jawenv.identify``.
        page: where the patient's page is written; None for nowhere.
        output: where all is written as JSON; None for nowhere.

    Returns:
        Exit code: 0, or 3 where the estimates are not to be believed.
    """
    write_page = None if page is None else of_the_clone("--page", PAGE, "eval").write_page
    check_outputs(page, output, [*paths, *reading.values()])
    found = identify(paths, **reading)
    if write_page is not None and not isinstance(found, Answer):
        raise InputError(f"{paths[0]}: --page with a log of force and opening; allowed: --json")
    print(found)
    if write_page is not None and isinstance(found, Answer) and found.agree:
        print(f"\npage: {write_page(found, page)}")
    if output is not None:
        output.write(found.mapping())
    if not found.believed:
        print("\nNOT TO BE BELIEVED:", flush=True)
        print(*found.reasons(), sep="\n")
    return 0 if found.believed else NOT_BELIEVABLE


def look_at(path: Path, reading: Mapping[str, Any]) -> int:
    """Print what is right and what is to be looked at in a recording, and what mends it.

    Args:
        path: of the file.
        reading: arguments of ``load_record``.

    Returns:
        Exit code: 0, or 3 where something is to be looked at.
    """
    from jawenv.recordings.doctor.examination import examined

    checks = examined(load_record(path, BENCH, **reading))
    for one in checks:
        print(f"{'ok     ' if one.fine else 'LOOK AT'} {one.what:7} {one.value}")
        if not one.fine:
            print(f"{'':16}mend: {one.mend}")
    return 0 if all(one.fine for one in checks) else NOT_BELIEVABLE
