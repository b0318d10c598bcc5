"""What a searched maneuver is for, in one sentence, from the command that its file names."""

from __future__ import annotations

import shlex
from pathlib import Path

COMMAND = "# python -m training "
GOAL = {
    "worst": "Know all 12 parameters as soon as possible",
    "all": "Learn as much as possible of all 12 parameters together",
}
TOGETHER = ("uncertainty", "D", "A")
"""Goals and criteria that count all parameters; the others count the least known one above all."""
WHOSE = {"one_sided": "in patients who are stiff on one side", "JawImaged": "in a jaw that is known as a scan shows it"}
OVER = {"tail": "also where least is found out"}
HOW = {"force": "by forces that the motors are told", "trajectory": "by paths that the motors are told"}


def purpose(file: Path) -> str:
    """What was sought; empty of a maneuver that was made by hand."""
    lines = [line for line in file.read_text(encoding="utf-8").splitlines() if line.startswith(COMMAND)]
    if not lines:
        return ""
    _, *words = shlex.split(lines[0].removeprefix(COMMAND))
    asked = dict(zip(words[::2], words[1::2], strict=True))
    together = any(asked.get(option) in TOGETHER for option in ("--goal", "--criterion"))
    parts = [
        GOAL["all" if together else "worst"],
        WHOSE.get(asked.get("--cohort", "")),
        WHOSE.get(asked.get("--env", "")),
        OVER.get(asked.get("--over", "")),
        HOW.get(asked.get("--control", "")),
        "within comfort",
    ]
    return ", ".join(part for part in parts if part) + "."
