"""Is a filter honest? Every filter on the same episodes of every maneuver, in chunks of patients on all cores.

Each chunk of a maneuver and filter is kept on disk as soon as it is finished, under a name that changes with whatever
could change its rows. Patient i is drawn, and its noise made, by the seed ``seed + i``, so that results depend neither
on the number of cores nor on how often a run was interrupted.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path

import pandas as pd
from rich.console import Console

from eval.calibration import beliefs
from eval.calibration import filters as known_filters
from eval.calibration.filters import TENSION, filters_named
from eval.chunks import Chunk, finish, folder_for
from eval.entries import Entry, fingerprint, load_entries
from eval.settings import Settings
from eval.tables import read_table, write_table
from jawenv.controls import mode_of
from jawenv.errors import InputError
from jawenv.playing.rollout import play

CHUNK = 8  # patients: few enough to lose little when interrupted, enough for a vector environment to be quick


@dataclass(frozen=True)
class Calibration:
    """What is judged, and on whom.

    Attributes:
        settings: patients, environment and effects; its ``episode_s`` is the last of the times.
        filters: names, see ``eval.calibration.filters``.
        times: s, growing, at which beliefs are judged.

    Raises:
        InputError: an unknown filter, or times that are not growing numbers above 0.
    """

    settings: Settings
    filters: tuple[str, ...]
    times: tuple[float, ...]

    def __post_init__(self) -> None:
        """Check filters and times."""
        object.__setattr__(self, "filters", filters_named(self.filters))
        growing = all(earlier < later for earlier, later in zip((0.0, *self.times), self.times, strict=False))
        if not self.times or not growing or not math.isfinite(self.times[-1]):
            given = ",".join(f"{time:g}" for time in self.times)
            raise InputError(f"times: {given or 'none'} given, allowed are growing numbers of seconds above 0")

    def check_steps(self, entry: Entry) -> None:
        """Check that the times are those of control steps of an entry.

        Raises:
            InputError: one is not.
        """
        kwargs = entry.env_kwargs
        step = 1.0 / float(kwargs.get("control_hz") or mode_of(kwargs).steps_per_s)
        for time in self.times:
            if abs(time - round(time / step) * step) > beliefs.LATE:
                raise InputError(f"times: {time:g} given, allowed are multiples of the control step, {step:g} s")


def calibrate(
    specs: Sequence[str],
    wanted: Calibration,
    output: Path,
    *,
    fresh: bool = False,
    trust: bool = False,
    workers: int | None = None,
    console: Console | None = None,
) -> pd.DataFrame:
    """Judge every filter on every maneuver.

    Args:
        specs: maneuvers, files or runs.
        wanted: filters, times, patients.
        output: folder; its ``chunks`` holds what is finished.
        fresh: judge again what the folder holds.
        trust: whether checkpoints that lie in no run's folder may be unpickled.
        workers: processes; all cores by default. 1 works in this process.
        console: where progress is shown; nowhere by default.

    Returns:
        Rows of ``beliefs.rows_of`` with a column ``entry``, by maneuver, filter, patient and time.

    Raises:
        InputError: no or an unknown maneuver, a time between control steps, an output folder that cannot be used, or a
            kept file that is damaged.
    """
    if not specs:
        raise InputError("nothing to calibrate on: name a maneuver or a training run")
    entries = load_entries(specs, wanted.settings.env_kwargs, wanted.settings.env, trust=trust)
    for entry in entries:
        wanted.check_steps(entry)
    folder = folder_for(output, "chunks")
    chunks = {entry.label: _chunks_of(entry, wanted, folder) for entry in entries}
    work = partial(judge_chunk, wanted=wanted, specs={entry.label: entry.spec for entry in entries}, trust=trust)
    every = [chunk for of_entry in chunks.values() for chunk in of_entry]
    finish(every, work, "estimates", fresh=fresh, workers=workers, console=console)
    tables = [
        read_table(dict(chunk.files)[name])[0].assign(entry=label)
        for label, of_entry in chunks.items()
        for name in wanted.filters
        for chunk in of_entry
    ]
    return pd.concat(tables, ignore_index=True)


def _chunks_of(entry: Entry, wanted: Calibration, folder: Path) -> list[Chunk]:
    """The chunks of a maneuver with the files of all filters."""
    played = wanted.settings
    # The number of patients decides no row of theirs, and filters have files of their own.
    settings = {key: value for key, value in asdict(played).items() if key not in ("patients", "seed")}
    settings |= {"times": wanted.times, "program": _digest()}
    chunks = []
    for first in range(played.seed, played.seed + played.patients, CHUNK):
        number, files = min(CHUNK, played.seed + played.patients - first), []
        for name in wanted.filters:
            own = {"filter": name, "seed": first, "patients": number}
            files.append((name, folder / f"{name}-{first:05d}-{fingerprint(entry, settings | own)}.parquet"))
        chunks.append(Chunk(entry.label, first, number, tuple(files)))
    return chunks


def _digest() -> str:
    """Changes with the sources that make the rows (those of jawenv and the agents are in the entry's fingerprint)."""
    sources = [Path(str(module.__file__)).read_bytes() for module in (beliefs, known_filters)]
    return hashlib.sha256(b"".join(sources)).hexdigest()[:16]


def judge_chunk(chunk: Chunk, wanted: Calibration, specs: Mapping[str, str], trust: bool = False) -> None:
    """Play a chunk's patients once, and keep the rows of each filter.

    Args:
        chunk: patients of one maneuver; ``first`` is the seed of the first one.
        wanted: filters, times, environment.
        specs: what the user typed, by the maneuvers' labels.
        trust: whether checkpoints that lie in no run's folder may be unpickled.
    """
    entry = load_entries([specs[chunk.key]], wanted.settings.env_kwargs, wanted.settings.env, trust=trust)[0]
    recording = play(
        entry.agent,
        patients=chunk.number,
        seed=chunk.first,
        env_kwargs=entry.env_kwargs | {"record": any(name != TENSION for name, _ in chunk.files)},
        env_id=entry.env_id,
    )
    for name, path in chunk.files:
        write_table(beliefs.rows_of(recording, name, wanted.times, chunk.first), path, {})
