"""A comparison from start to end: every entry on the same patients with the same noise."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import nullcontext
from dataclasses import asdict, replace
from pathlib import Path

from rich.console import Console

from eval.chunks import folder_for
from eval.comparison import results
from eval.comparison.motion import Watched
from eval.comparison.results import Results
from eval.entries import Entry, fingerprint
from eval.report import words
from eval.settings import Settings
from eval.tables import made_with
from jawenv.errors import InputError
from jawenv.locks import alone
from jawenv.playing.rollout import play
from jawenv.progress import Progress


def play_entry(entry: Entry, settings: Settings, progress: Callable[[int, int], None] | None = None) -> Results:
    """Play one entry on all patients and reduce the recording to its tables.

    Args:
        entry: what to play.
        settings: on whom.
        progress: called with (steps done, steps in all).
    """
    agent = Watched(entry.agent)
    recording = play(
        agent,
        patients=settings.patients,
        seed=settings.seed,
        env_kwargs=entry.env_kwargs,
        env_id=entry.env_id,
        progress=progress,
    )
    found = results.from_recording(recording, entry.label, settings.seed, entry.about())
    return replace(found, motions={entry.label: agent.motion()} if agent.motion() else {})


def compare(
    entries: Sequence[Entry],
    settings: Settings,
    output: Path | None = None,
    *,
    command: str = "",
    fresh: bool = False,
    console: Console | None = None,
) -> Results:
    """Play every entry on the same patients and noise; keep each as soon as it is finished.

    Args:
        entries: what to compare.
        settings: on whom and how.
        output: folder for `patients.parquet` and `curves.parquet`, and under `entries/` one pair per entry,
            which is used again when nothing that decides its results has changed; without a folder nothing is kept.
        command: how the user asked for it, for the results' metadata.
        fresh: compute every entry again.
        console: where progress is shown; nowhere by default.

    Returns:
        The tables of the study, as saved.

    Raises:
        InputError: no entry, or one of another environment than the settings'; the output folder cannot be used or
            another process uses it, or a kept file is damaged.
    """
    if not entries:
        raise InputError("nothing to compare: name a maneuver or a training run, or use --all-maneuvers")
    for entry in entries:
        if entry.env_id != settings.env:
            raise InputError(f"{entry.label} plays {entry.env_id}, but this comparison is in {settings.env}")
    folder = None if output is None else folder_for(output, "entries")
    parts = []
    with (
        nullcontext() if output is None else alone(output),
        Progress(len(entries), "entries", console or Console(quiet=True)) as progress,
    ):
        progress.say(f"playing {len(entries)} entries")
        for entry in entries:
            parts.append(_results_of(entry, settings, folder, fresh, progress))
        study = results.join(parts, made_with(command, settings=asdict(settings), entries=[e.about() for e in entries]))
        if output is not None:
            results.save(study, output)
    return study


def _results_of(entry: Entry, settings: Settings, folder: Path | None, fresh: bool, progress: Progress) -> Results:
    """Results of one entry: those that the folder has, or new ones, which it then keeps."""
    stem, before = f"{fingerprint(entry, asdict(settings))}.", progress.done
    name = words.label(entry.label)
    place = f"{before + 1:.0f} of {progress.total}  {name}"
    if folder is not None and not fresh and (folder / f"{stem}patients.parquet").exists():
        part = results.load(folder, stem)
        progress.skip(1)
        progress.say(f"{place}: kept from an earlier run")
        return part
    part = play_entry(entry, settings, lambda step, steps: progress.advance_to(before + step / steps, name))
    if folder is not None:
        results.save(part, folder, stem)
    spent = getattr(entry.agent, "ms_per_decision", None)
    progress.say(f"{place}: done" + ("" if spent is None else f", {spent:.0f} ms per decision"))
    return part
