"""A comparison from start to end: every entry on the same patients with the same noise."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import nullcontext
from dataclasses import replace
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

from rich.console import Console

from eval import words
from eval.comparison import motion, results
from eval.comparison.results import Results
from eval.entries import Entry
from eval.kept.digest import fingerprint
from eval.kept.parts import Part, Run, finish, folder_for
from eval.kept.tables import made_with
from eval.settings import Settings
from jawenv.errors import InputError
from jawenv.locks import alone
from jawenv.progress import Progress

_LAST = "patients.parquet"


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
        if entry.env_id != settings.world.env_id:
            raise InputError(f"{entry.label} plays {entry.env_id}, but this comparison is in {settings.world.env_id}")
    with TemporaryDirectory() if output is None else nullcontext(output) as place, alone(Path(place)):
        folder = folder_for(Path(place), "entries")
        parts = [_part_of(entry, settings, folder) for entry in entries]
        work = partial(play_entry, entries={entry.label: entry for entry in entries}, settings=settings)
        # One process, whose threads share out the patients.
        kept = finish(parts, work, _read, "entries", Run(fresh, 1, console=console))
        study = results.join(
            [kept[path] for part in parts for _, path in part.files],
            made_with(command, settings=settings.to_mapping(), entries=[entry.about() for entry in entries]),
        )
        if output is not None:
            results.save(study, output)
    return study


def play_entry(part: Part, progress: Progress, entries: Mapping[str, Entry], settings: Settings) -> None:
    """Play one entry on all patients, and keep its tables.

    Args:
        part: whose key is the entry's label.
        progress: counts entries.
        entries: by their labels.
        settings: on whom.
    """
    entry, before = entries[part.key], progress.done
    seen, name = motion.Motion(), words.label(entry.label)
    recording = entry.play(
        settings.patients,
        settings.seed,
        progress=lambda step, steps: progress.advance_to(before + step / steps, name),
        on_step=seen,
    )
    tables = results.from_recording(recording, entry.label, settings.seed, entry.about())
    moved = {entry.label: seen.motion()} if seen.motion() else {}
    for stem, path in part.files:
        results.save(replace(tables, motions=moved), path.parent, stem)
    spent = getattr(entry.agent, "ms_per_decision", None)
    progress.say(
        f"{before + 1:.0f} of {progress.total}  {name}: done"
        + ("" if spent is None else f", {spent:.0f} ms per decision")
    )


def _part_of(entry: Entry, settings: Settings, folder: Path) -> Part:
    stem = f"{fingerprint(entry, settings.to_mapping(), results, motion)}."
    return Part(entry.label, 0, 1, ((stem, folder / f"{stem}{_LAST}"),))


def _read(path: Path) -> Results:
    return results.load(path.parent, path.name.removesuffix(_LAST))
