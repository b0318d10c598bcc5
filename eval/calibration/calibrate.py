"""Is a filter honest? Every filter on the same episodes of every maneuver, in chunks of patients on all cores.

Each chunk of a maneuver and filter is kept on disk as soon as it is finished, under a name that changes with whatever
could change its rows. Patient i is drawn, and its noise made, by the seed ``seed + i``, so that results depend neither
on the number of cores nor on how often a run was interrupted.
"""

from __future__ import annotations

import hashlib
import json
import math
import os
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Any

import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq

from eval.calibration import beliefs
from eval.calibration import filters as known_filters
from eval.calibration.filters import TENSION, filters_named
from eval.comparison.compare import Settings, versions
from eval.entries import Entry, fingerprint, load_entries
from eval.pool import run_all, stopped
from jawenv.errors import InputError
from jawenv.rollout import play

CHUNK = 8  # patients: few enough to lose little when interrupted, enough for a vector environment to be quick
_KEY = b"jawenv.eval"
CONTROL_HZ = 20.0  # of the environments where nothing else is said

Told = Callable[[str, int, bool], None]


@dataclass(frozen=True)
class Calibration:
    """What is judged, and on whom.

    Attributes:
        on: patients, environment and effects; its ``episode_s`` is the last of the times.
        filters: names, see ``eval.calibration.filters``.
        times: s, growing, at which beliefs are judged.

    Raises:
        InputError: an unknown filter, or times that are not growing numbers above 0.
    """

    on: Settings
    filters: tuple[str, ...]
    times: tuple[float, ...]

    def __post_init__(self) -> None:
        """Check filters and times."""
        object.__setattr__(self, "filters", filters_named(self.filters))
        growing = all(earlier < later for earlier, later in zip((0.0, *self.times), self.times, strict=False))
        if not self.times or not growing or not math.isfinite(self.times[-1]):
            given = ",".join(f"{one:g}" for one in self.times)
            raise InputError(f"times: {given or 'none'} given, allowed are growing numbers of seconds above 0")

    def check_steps(self, entry: Entry) -> None:
        """Check that the times are those of control steps of an entry.

        Raises:
            InputError: one is not.
        """
        step = 1.0 / float(entry.env_kwargs.get("control_hz", CONTROL_HZ))
        for one in self.times:
            if abs(one - round(one / step) * step) > beliefs.LATE:
                raise InputError(f"times: {one:g} given, allowed are multiples of the control step, {step:g} s")


@dataclass(frozen=True)
class Chunk:
    """Some patients of a maneuver, and the file of each filter that has not judged them yet."""

    label: str
    spec: str
    first: int
    number: int
    paths: tuple[tuple[str, Path], ...]


class _Stop(Exception):  # noqa: N818  (no error: the run was interrupted)
    """Raised between the steps of an episode when the run is to end."""


def calibrate(
    specs: Sequence[str],
    wanted: Calibration,
    output: Path,
    *,
    fresh: bool = False,
    workers: int | None = None,
    progress: Told | None = None,
) -> pd.DataFrame:
    """Judge every filter on every maneuver.

    Args:
        specs: maneuvers, files or runs.
        wanted: filters, times, patients.
        output: folder; its ``chunks`` holds what is finished.
        fresh: judge again what the folder holds.
        workers: processes; all cores by default. 1 works in this process.
        progress: called with (maneuver and filter, patients judged, whether they were kept from before).

    Returns:
        Rows of ``beliefs.rows_of`` with a column ``entry``, by maneuver, filter, patient and time.

    Raises:
        InputError: no or an unknown maneuver, a time between control steps, an output folder that cannot be used, or a
            kept file that is damaged.
    """
    if not specs:
        raise InputError("nothing to calibrate on: name a maneuver or a training run")
    entries = load_entries(specs, wanted.on.env_kwargs, wanted.on.env)
    for entry in entries:
        wanted.check_steps(entry)
    folder = output / "chunks"
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"output {output}: {error.strerror}") from None
    told = progress or (lambda name, number, known: None)
    kept, missing = [], []
    for entry in entries:
        for chunk in _chunks_of(entry, wanted, folder):
            kept += [(entry.label, name, path) for name, path in chunk.paths]
            paths = tuple((name, path) for name, path in chunk.paths if fresh or not path.exists())
            for name, _ in set(chunk.paths) - set(paths):
                told(f"{entry.label}, {name}", chunk.number, True)
            if paths:
                missing.append(Chunk(chunk.label, chunk.spec, chunk.first, chunk.number, paths))

    def done(chunk: Chunk) -> None:
        for name, _ in chunk.paths:
            told(f"{chunk.label}, {name}", chunk.number, False)

    run_all(partial(judge_chunk, wanted=wanted), missing, done, workers)
    # By filter first, as the chunks of one maneuver hold all filters.
    order = {name: i for i, name in enumerate(wanted.filters)}
    labels = {entry.label: i for i, entry in enumerate(entries)}
    kept.sort(key=lambda one: (labels[one[0]], order[one[1]]))
    tables = [read_table(path).assign(entry=label) for label, _, path in kept]
    return pd.concat(tables, ignore_index=True)


def _chunks_of(entry: Entry, wanted: Calibration, folder: Path) -> list[Chunk]:
    """The chunks of a maneuver with the files of all filters."""
    on = wanted.on
    # The number of patients decides no row of theirs, and filters have files of their own.
    settings = {key: value for key, value in asdict(on).items() if key not in ("patients", "seed")}
    settings |= {"times": wanted.times, "program": _digest()}
    found = []
    for first in range(0, on.patients, CHUNK):
        number, paths = min(CHUNK, on.patients - first), []
        for name in wanted.filters:
            own = {"filter": name, "seed": on.seed + first, "patients": number}
            stem = f"{name}-{on.seed + first:05d}-{fingerprint(entry, settings | own)}"
            paths.append((name, folder / f"{stem}.parquet"))
        found.append(Chunk(entry.label, entry.spec, on.seed + first, number, tuple(paths)))
    return found


def _digest() -> str:
    """Changes with the sources that make the rows (those of jawenv and the agents are in the entry's fingerprint)."""
    sources = [Path(str(module.__file__)).read_bytes() for module in (beliefs, known_filters)]
    return hashlib.sha256(b"".join(sources)).hexdigest()[:16]


def judge_chunk(chunk: Chunk, wanted: Calibration) -> None:
    """Play a chunk's patients once, and keep the rows of each filter, all or none."""
    entry = load_entries([chunk.spec], wanted.on.env_kwargs, wanted.on.env)[0]
    others = any(name != TENSION for name, _ in chunk.paths)

    def go_on(*_: int) -> None:
        if stopped():
            raise _Stop

    try:
        recording = play(
            entry.agent,
            patients=chunk.number,
            seed=chunk.first,
            env_kwargs=entry.env_kwargs | {"record": others},
            env_id=entry.env_id,
            progress=go_on,
        )
        for name, path in chunk.paths:
            write_table(beliefs.rows_of(recording, name, wanted.times, chunk.first, go_on), path, {})
    except _Stop:
        return


def about(wanted: Calibration, command: str) -> dict[str, Any]:
    """What tables are made with."""
    return {
        "command": command,
        "settings": asdict(wanted),
        "versions": versions(),
        "finished": time.strftime("%Y-%m-%d %H:%M UTC", time.gmtime()),
    }


def write_table(frame: pd.DataFrame, path: Path, made_with: dict[str, Any]) -> None:
    """Write a table, whole or not at all."""
    table = pa.Table.from_pandas(frame, preserve_index=False)
    meta = {**(table.schema.metadata or {}), _KEY: json.dumps(made_with, sort_keys=True).encode()}
    unfinished = path.with_name(f"{path.name}.{os.getpid()}.unfinished")
    pq.write_table(table.replace_schema_metadata(meta), unfinished, compression="zstd")
    os.replace(unfinished, path)


def read_table(path: Path) -> pd.DataFrame:
    """Read what ``write_table`` has written.

    Raises:
        InputError: the file is damaged.
    """
    try:
        return pd.read_parquet(path)
    except (OSError, ValueError) as error:
        reason = " ".join(str(error).split())[:120]
        raise InputError(f"{path} is damaged ({reason}); delete it, or use --fresh") from None
