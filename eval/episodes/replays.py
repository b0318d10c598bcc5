"""Replays of entries: their targets averaged over patients that no comparison is about, as maneuver files."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from rich.console import Console

from agents.replay import check_targets, replays_of
from eval.figures import words
from eval.kept.digest import fingerprint
from eval.kept.entries import Entry, Settings, load_entries
from jawenv.base.errors import InputError, shown
from jawenv.base.locks import alone
from jawenv.base.progress import Progress
from jawenv.base.seeds import REPLAYS
from jawenv.playing.maneuvers.written import save_maneuver


def replay_of_entry(entry: Entry, settings: Settings, path: Path, console: Console | None = None) -> Path:
    """Play an entry and write its averaged targets as a maneuver file, and beside it all its actions as .safetensors.

    Args:
        entry: says where the jaw shall be.
        settings: how many patients, and from which seed on.
        path: of the file, which ends in .yaml.
        console: where progress is shown; nowhere by default.
    """
    if path.suffix != ".yaml":
        raise InputError(f"output is {shown(str(path))}; allowed: a file that ends in .yaml")
    seconds = settings.world.episode_s
    with (
        alone(path),
        Progress(seconds, "s of all patients", console or Console(quiet=True)) as progress,
    ):
        progress.say(f"averaging the targets of {words.label(entry.label)}")
        maneuver, yoked = replays_of(
            entry.agent,
            patients=settings.patients,
            seed=settings.seed,
            env_kwargs=entry.env_kwargs,
            env_id=entry.env_id,
            progress=lambda step, steps: progress.advance_to(seconds * step / steps),
        )
        yoked.save(path.with_suffix(".safetensors"))
        return save_maneuver(maneuver, path)


def add_replays(
    entries: Sequence[Entry], settings: Settings, folder: Path, *, fresh: bool = False, console: Console | None = None
) -> list[Entry]:
    """The entries, each trained or planned one followed by its replay and its yoked replay.

    Replays are averaged over as many patients as are compared, of the same cohort, by the seeds of ``REPLAYS``.

    Args:
        entries: of a comparison.
        settings: of the comparison.
        folder: where the maneuver files are kept, and found again when nothing that decides them has changed.
        fresh: compute every replay again.
        console: where progress is shown; nowhere by default.
    """
    averaged = replace(settings, seed=REPLAYS.start)
    if settings.seed + settings.patients > REPLAYS.start and settings.seed < REPLAYS.start + settings.patients:
        raise InputError(
            f"seed: {settings.seed} with {settings.patients} patients given; allowed with replays: none of the seeds "
            f"{REPLAYS.start} to {REPLAYS.start + settings.patients - 1}"
        )
    adapting = [entry for entry in entries if entry.trained or entry.planned]
    if not adapting:
        raise InputError("with-replay: no entry is trained or planned; allowed: at least one")
    for entry in adapting:
        check_targets(entry.agent, entry.env_kwargs)
    replays: dict[str, tuple[Entry, ...]] = {}
    for entry in adapting:
        key = fingerprint(entry, averaged.to_mapping())
        path = folder / f"{key}.yaml"
        if fresh or not path.exists():
            replay_of_entry(entry, averaged, path, console)
        replays[entry.label] = (
            _entry_of(path, entry, "replay"),
            _entry_of(path.with_suffix(".safetensors"), entry, "yoked replay"),
        )
    return [played for entry in entries for played in (entry, *replays.get(entry.label, ()))]


def _entry_of(path: Path, entry: Entry, kind: str) -> Entry:
    """The replay of ``entry`` in ``path``, played with the entry's own settings."""
    loaded = load_entries([str(path)], entry.world)[0]
    return replace(loaded, label=f"{kind} of {entry.label}", replay_of=entry.label, note=entry.note)
