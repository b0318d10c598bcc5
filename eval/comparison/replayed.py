"""Another patient of a finished comparison, played again for the report's films."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from rich.console import Console

from eval import words
from eval.comparison.motion import Motion
from eval.comparison.results import Results
from eval.entries import load_entries
from eval.settings import Settings
from jawenv.errors import InputError


def play_patient(study: Results, seed: int, console: Console, *, trust: bool = False) -> Results:
    """The same results with the motions of another of their patients.

    Args:
        study: a finished comparison whose agents still lie where they were.
        seed: of the patient.
        console: where progress is shown.
        trust: see ``load_entries``.

    Raises:
        InputError: no patient of the comparison has that seed, or an agent is not there any more.
    """
    settings = Settings.from_mapping(study.about["settings"])
    last = settings.seed + settings.patients - 1
    if not settings.seed <= seed <= last:
        raise InputError(f"patient is {seed}; allowed: the seeds of the comparison, {settings.seed} to {last}")
    specs = [each["spec"] for each in study.about["entries"]]
    motions: dict[str, Any] = {}
    for entry in load_entries(specs, settings.world, trust=trust):
        seen = Motion()
        with console.status(f"playing {words.label(entry.label)}"):
            entry.play(1, seed, on_step=seen)
        if seen.motion():
            motions[entry.label] = seen.motion()
    return replace(study, motions=motions, about=study.about | {"played_seed": seed})
