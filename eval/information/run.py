"""The records of every patient, in parts of some patients on all cores.

Patient i is drawn, and its noise made, by the seed ``seed + i``.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path

import pandas as pd

from eval.entries import Entry, load_entries
from eval.information import gains
from eval.information.gains import COLUMNS, law_of, rows_of
from eval.kept.digest import fingerprint
from eval.kept.parts import Part, Run, finish, folder_for, parts_of
from eval.kept.tables import read_table, write_table
from eval.settings import Settings
from jawenv.errors import InputError
from jawenv.progress import Progress

CHUNK = 5  # patients


def play(
    specs: Sequence[str], settings: Settings, contrasts: int, output: Path, run: Run | None = None, *, trust: bool
) -> pd.DataFrame:
    """What every entry has told of every patient.

    Args:
        specs: maneuvers, files or runs.
        settings: patients and environment, whose filter knows all but the patient.
        contrasts: of each record; 0 leaves the contrastive bounds out.
        output: folder; its ``parts`` holds what is finished.
        run: how it is done.
        trust: whether checkpoints that lie in no run's folder may be unpickled.

    Returns:
        Rows of ``gains.rows_of`` with a column ``entry``, by entry and patient.

    Raises:
        InputError: no or an unknown entry, settings under which the prior is another, an output folder that cannot be
            used, or a kept file that is damaged.
    """
    if not specs:
        raise InputError("nothing to play: name a maneuver, a file, a training run or a policy")
    if contrasts < 0:
        raise InputError(f"contrasts is {contrasts}; allowed: 0 or more")
    entries = load_entries(specs, settings.world, trust=trust)
    folder = folder_for(output, "parts")
    parts = {entry.label: _parts_of(entry, settings, contrasts, folder) for entry in entries}
    of_labels = {entry.label: entry.spec for entry in entries}
    work = partial(play_part, specs=of_labels, settings=settings, contrasts=contrasts, trust=trust)
    kept = finish([part for of_entry in parts.values() for part in of_entry], work, _read, "records", run)
    tables = [kept[part.files[0][1]].assign(entry=label) for label, of_entry in parts.items() for part in of_entry]
    return pd.concat(tables, ignore_index=True)


def _parts_of(entry: Entry, settings: Settings, contrasts: int, folder: Path) -> list[Part]:
    digest = fingerprint(entry, settings.of_a_patient() | {"contrasts": contrasts}, gains)
    seeds = range(settings.seed, settings.seed + settings.patients)
    return parts_of(entry.label, seeds, CHUNK, folder, {entry.label: digest})


def play_part(
    part: Part, progress: Progress, specs: dict[str, str], settings: Settings, contrasts: int, trust: bool
) -> None:
    """Play a part's patients, and keep their rows.

    Args:
        part: patients of one entry; ``first`` is the seed of the first one.
        progress: counts records.
        specs: what the user typed, by the entries' labels.
        settings: of the environment.
        contrasts: of each record.
        trust: whether checkpoints that lie in no run's folder may be unpickled.
    """
    entry = load_entries([specs[part.key]], settings.world, trust=trust)[0]
    recording = entry.play(part.number, part.first, record=True)
    rows = rows_of(recording, law_of(settings.world), part.first, contrasts)
    for _, path in part.files:
        write_table(rows, path, {})


def _read(path: Path) -> pd.DataFrame:
    return read_table(path, COLUMNS)[0]
