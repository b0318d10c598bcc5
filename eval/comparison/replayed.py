"""One patient of a comparison, played again to see how the jaw is moved."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace
from typing import Any

from rich.console import Console

from eval import words
from eval.comparison.motion import Motion
from eval.comparison.results import Results
from eval.entries import load_entry
from eval.settings import Settings
from jawenv.errors import InputError


def play_patient(
    study: Results, labels: Collection[str], console: Console, seed: int | None = None, *, trust: bool = False
) -> Results:
    """The same results with the motions of one of their patients, by those entries that are still there.

    Args:
        study: a finished comparison.
        labels: of the entries that are played.
        console: where progress is shown, and who is not there any more.
        seed: of the patient; the first by default.
        trust: see ``load_entries``.

    Raises:
        InputError: no patient of the comparison has that seed.
    """
    settings = Settings.from_mapping(study.about["settings"])
    seed = settings.seed if seed is None else seed
    if seed not in settings.seeds:
        last = settings.seeds[-1]
        raise InputError(f"patient is {seed}; allowed: the seeds of the comparison, {settings.seed} to {last}")
    motions: dict[str, Any] = {}
    for about in study.about["entries"]:
        if (label := about["label"]) not in labels:
            continue
        seen = Motion()
        try:
            with console.status(f"playing {words.label(label)}"):
                load_entry(about["spec"], settings.world, trust=trust).play(1, seed, on_step=seen)
        except InputError as error:
            console.print(f"not filmed: {words.label(label)} ({error})", soft_wrap=True)
        if seen.motion():
            motions[label] = seen.motion()
    return replace(study, motions=motions, about=study.about | {"played_seed": seed})
