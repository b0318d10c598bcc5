"""``jawenv doctor``: each check of a recording as a line, and what mends it."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from jawenv.commands.answer import UNKNOWN
from jawenv.commands.recordings import NOT_BELIEVABLE
from jawenv.recordings.doctor.examination import examined
from jawenv.recordings.files import load_record


def look_at(path: Path, reading: Mapping[str, Any]) -> int:
    """Print what is right and what is to be looked at in a recording.

    Args:
        path: of the file.
        reading: arguments of ``load_record``.

    Returns:
        Exit code: 0, or 3 where something is to be looked at.
    """
    checks = examined(load_record(path, UNKNOWN, **reading))
    for check in checks:
        print(f"{'ok     ' if check.fine else 'LOOK AT'} {check.what:7} {check.value}")
        if not check.fine:
            print(f"{'':16}mend: {check.mend}")
    return 0 if all(check.fine for check in checks) else NOT_BELIEVABLE
