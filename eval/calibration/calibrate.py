"""Is a filter honest? Every filter on the same episodes of every maneuver, in parts of some patients on all cores.

Patient i is drawn, and its noise made, by the seed ``seed + i``.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import pandas as pd

from eval.calibration import beliefs, nuisances
from eval.calibration import filters as known_filters
from eval.calibration.filters import TENSION, filters_named
from eval.calibration.nuisances import NuisanceBeliefs
from eval.entries import Entry, load_entries
from eval.kept.digest import fingerprint
from eval.kept.parts import Part, Run, finish, folder_for, parts_of
from eval.kept.tables import rows_in, write_table
from eval.settings import Settings
from jawenv.controls import mode_of
from jawenv.errors import InputError
from jawenv.progress import Progress

CHUNK = 8  # patients


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
            raise InputError(f"times is {given or 'none'}; allowed: growing numbers of seconds above 0")

    def check_steps(self, entry: Entry) -> None:
        """Check that the times are those of control steps of an entry.

        Raises:
            InputError: one is not.
        """
        kwargs = entry.env_kwargs
        step = 1.0 / float(kwargs.get("control_hz") or mode_of(kwargs).steps_per_s)
        for time in self.times:
            if abs(time - round(time / step) * step) > beliefs.LATE:
                raise InputError(f"times is {time:g}; allowed: multiples of the control step, {step:g} s")


def calibrate(
    specs: Sequence[str], wanted: Calibration, output: Path, run: Run | None = None, *, trust: bool = False
) -> pd.DataFrame:
    """Judge every filter on every maneuver.

    Args:
        specs: maneuvers, files or runs.
        wanted: filters, times, patients.
        output: folder; its ``chunks`` holds what is finished.
        run: how it is done.
        trust: whether checkpoints that lie in no run's folder may be unpickled.

    Returns:
        Rows of ``beliefs.rows_of`` with a column ``entry``, by maneuver, filter, patient and time.

    Raises:
        InputError: no or an unknown maneuver, a time between control steps, an output folder that cannot be used, or a
            kept file that is damaged.
    """
    if not specs:
        raise InputError("nothing to calibrate on: name a maneuver or a training run")
    entries = load_entries(specs, wanted.settings.world, trust=trust)
    for entry in entries:
        wanted.check_steps(entry)
    folder = folder_for(output, "chunks")
    parts = {entry.label: _parts_of(entry, wanted, folder) for entry in entries}
    work = partial(judge_part, wanted=wanted, specs={entry.label: entry.spec for entry in entries}, trust=trust)
    kept = finish([part for of_entry in parts.values() for part in of_entry], work, rows_in, "estimates", run)
    tables = [
        kept[dict(part.files)[name]].assign(entry=label)
        for label, of_entry in parts.items()
        for name in wanted.filters
        for part in of_entry
    ]
    return pd.concat(tables, ignore_index=True)


def _parts_of(entry: Entry, wanted: Calibration, folder: Path) -> list[Part]:
    """The parts of a maneuver, with a file of each filter."""
    played = wanted.settings
    settings = played.of_a_patient() | {"times": wanted.times}
    prints = {
        name: fingerprint(entry, settings | {"filter": name}, beliefs, known_filters, nuisances)
        for name in wanted.filters
    }
    return parts_of(entry.label, range(played.seed, played.seed + played.patients), CHUNK, folder, prints)


def judge_part(
    part: Part, progress: Progress, wanted: Calibration, specs: Mapping[str, str], trust: bool = False
) -> None:
    """Play a part's patients once, and keep the rows of each filter.

    Args:
        part: patients of one maneuver; ``first`` is the seed of the first one.
        progress: counts estimates.
        wanted: filters, times, environment.
        specs: what the user typed, by the maneuvers' labels.
        trust: whether checkpoints that lie in no run's folder may be unpickled.
    """
    entry = load_entries([specs[part.key]], wanted.settings.world, trust=trust)[0]
    recorded = any(name != TENSION for name, _ in part.files)
    beliefs_of = None if entry.world.build_knowledge().exact else NuisanceBeliefs(wanted.times)
    recording = entry.play(part.number, part.first, on_step=beliefs_of, record=recorded)
    for name, path in part.files:
        rows = beliefs.rows_of(recording, name, wanted.times, part.first)
        write_table(beliefs_of.added_to(rows, part.first) if beliefs_of and name == TENSION else rows, path, {})
