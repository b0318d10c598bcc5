"""Every filter on the same episodes of every maneuver, as cells of a study."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial

from eval.kept.cells import Cell
from eval.kept.entries import Settings, load_entries, load_entry
from eval.rows.beliefs import LATE, Beliefs, filters_named
from jawenv.base.errors import InputError
from jawenv.controls import mode_of

PATIENTS_IN_A_PART = 8


def cells_of(
    specs: Sequence[str], filters: Sequence[str], times: Sequence[float], settings: Settings, *, trust: bool = False
) -> list[Cell]:
    """A cell for every maneuver and filter.

    Args:
        specs: maneuvers, files, runs, exported policies or agents of one's own.
        filters: names, see `eval.rows.beliefs`.
        times: s, growing, at which beliefs are judged.
        settings: patients, environment and effects; its ``episode_s`` is the last of the times.
        trust: whether stable-baselines3 checkpoints may be unpickled.
    """
    growing = all(earlier < later for earlier, later in zip((0.0, *times), times, strict=False))
    if not times or not growing or not math.isfinite(times[-1]):
        raise InputError(f"times is {_shown(times)}; allowed: growing numbers of seconds above 0")
    names = filters_named(filters)
    if not specs:
        raise InputError("nothing to calibrate on: name a maneuver or a training run")
    cells = []
    for entry in load_entries(specs, settings.world, trust=trust):
        step = 1.0 / mode_of(entry.env_kwargs).steps_per_s
        if any(abs(time - round(time / step) * step) > LATE for time in times):
            raise InputError(f"times is {_shown(times)}; allowed: multiples of the control step, {step:g} s")
        load = partial(load_entry, entry.spec, settings.world, trust=trust)
        for name in names:
            levels, rows = {"entry": entry.label, "filter": name}, Beliefs(name, tuple(times))
            cells.append(Cell(levels, load, settings.seeds, rows, PATIENTS_IN_A_PART))
    return cells


def _shown(times: Sequence[float]) -> str:
    return ",".join(f"{time:g}" for time in times) or "none"
