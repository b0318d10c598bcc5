"""One patient of a comparison, played again to see how the jaw is moved."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from rich.console import Console

from eval import words
from eval.comparison.motion import Motion
from eval.comparison.results import Results
from eval.entries import load_entry
from eval.settings import Settings
from jawenv.errors import InputError


def play_patient(study: Results, seed: int | None, console: Console, *, trust: bool = False) -> Results:
    """The same results with the motions of one of their patients.

    Args:
        study: a finished comparison whose agents still lie where they were.
        seed: of the patient; the first by default.
        console: where progress is shown.
        trust: see ``load_entries``.

    Raises:
        InputError: no patient of the comparison has that seed, or an agent is not there any more.
    """
    settings = Settings.from_mapping(study.about["settings"])
    seed = settings.seed if seed is None else seed
    if seed not in settings.seeds:
        last = settings.seeds[-1]
        raise InputError(f"patient is {seed}; allowed: the seeds of the comparison, {settings.seed} to {last}")
    motions: dict[str, Any] = {}
    for about in study.about["entries"]:
        entry, seen = replace(load_entry(about["spec"], settings.world, trust=trust), label=about["label"]), Motion()
        with console.status(f"playing {words.label(entry.label)}"):
            entry.play(1, seed, on_step=seen)
        if seen.motion():
            motions[entry.label] = seen.motion()
    return replace(study, motions=motions, about=study.about | {"played_seed": seed})
