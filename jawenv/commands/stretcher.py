"""The answer of ``jawenv identify`` to a stretcher's log of force and opening: printed, and as JSON."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from jawenv.anatomy import MUSCLE_NAMES, cohort
from jawenv.base.errors import InputError
from jawenv.base.versions import package_versions
from jawenv.commands.outputs import Answer, check_outputs
from jawenv.metrics.diagnosis import MEASURED
from jawenv.metrics.verdicts import NOT_MEASURED
from jawenv.recordings.defaults import ANYONE
from jawenv.recordings.stretcher.identified import Stretched, pulls, stretched
from jawenv.recordings.stretcher.log import log_of_table
from jawenv.recordings.table import RecordTable, checked_path, read_table
from jawenv.recordings.words import WORDS

Array = NDArray[np.float64]

NOT_BELIEVABLE = 3
BAND = (0.05, 0.5, 0.95)
ALLOWED = ("cohort", "columns", "before")
TELLS = "This log tells how stiff the jaw is, not where."


def identify_log(
    table: RecordTable, reading: Mapping[str, Any], others: Mapping[str, Any], answer: Answer | None
) -> int:
    """Print what a log of force and opening tells, and whether it is to be believed.

    Args:
        table: as read.
        reading: options of the command: ``cohort``, ``columns`` and ``before``, an earlier log of the same patient.
        others: further options by name, all None.
        answer: where all is written as JSON; None for nowhere.

    Returns:
        Exit code: 0, or 3 where a log is not to be believed.
    """
    given = {name for name, value in ({**reading, **others}).items() if value is not None}
    if refused := sorted(given.difference(ALLOWED)):
        name, allowed = refused[0].removesuffix("_hz"), ", ".join(f"--{name}" for name in (*ALLOWED, "json"))
        raise InputError(f"{table.path}: --{name} with a log of force and opening; allowed: {allowed}")
    columns, before = reading["columns"], reading["before"]
    check_outputs(None, answer, [table.path, *reading.values()])
    logs = [log_of_table(table, columns)]
    if before is not None:
        logs.append(log_of_table(read_table(checked_path(before), WORDS), columns))
    population = cohort(reading["cohort"] or table.header.get("cohort", ANYONE))
    found = [stretched(log, population, seed=i) for i, log in enumerate(logs)]
    for one in found:
        _print(one)
    if len(found) > 1 and all(one.believed for one in found):
        print(f"\nsince {logs[1].path}, 90 %:")
        for name, ratio in changes(*found).items():
            print(f"{name:18} {_interval(ratio)} times")
    if answer is not None:
        answer.write(as_mapping(found))
    for one in found:
        if not one.believed:
            print(f"\n{one.log.path}: NOT TO BE BELIEVED:", *(f"- {doubt}" for doubt in one.doubts), sep="\n")
    return 0 if all(one.believed for one in found) else NOT_BELIEVABLE


def changes(now: Stretched, before: Stretched) -> dict[str, Array]:
    """Draws of ratios since an earlier log, by name: force at each opening that both reached, total pull."""
    number, both = min(len(now.theta), len(before.theta)), min(len(now.openings), len(before.openings))
    ratios = now.forces[:number, :both] / before.forces[:number, :both]
    total = np.exp(pulls(now.theta[:number])["all"] - pulls(before.theta[:number])["all"])
    return {f"force at {mm:g} mm": ratios[:, i] for i, mm in enumerate(now.openings[:both])} | {"total pull": total}


def told(found: Stretched) -> dict[str, bool]:
    """Whether the log tells each of these: its error bar is at most half of what it was before."""
    before, after = pulls(found.prior), pulls(found.theta)
    words = {name: bool(np.std(after[name]) <= MEASURED * np.std(before[name])) for name in before}
    of_each = np.std(found.theta, axis=0) <= MEASURED * np.std(found.prior, axis=0)
    return words | {name: bool(of_each[2 * i : 2 * i + 2].all()) for i, name in enumerate(MUSCLE_NAMES)}


def as_mapping(found: list[Stretched]) -> dict[str, Any]:
    """The answer as a pipeline reads it: text, numbers, lists and None alone; the log, then an earlier one."""
    answer = [_one(one) for one in found]
    change = {}
    if len(found) > 1 and all(one.believed for one in found):
        change = {name: _quantiles(ratio) for name, ratio in changes(*found).items()}
    return answer[0] | {"before": answer[1:], "change": change, "versions": package_versions()}


def _one(found: Stretched) -> dict[str, Any]:
    return {
        "path": found.log.path,
        "believed": found.believed,
        "doubts": found.doubts,
        "misfit": found.misfit if np.isfinite(found.misfit) else None,
        "reached_mm": found.reached_mm,
        "quantiles": BAND,
        "openings_mm": found.openings.tolist(),
        "forces_N": [_quantiles(force) for force in found.forces.T] if found.believed else [],
        "pulls_N": {n: _quantiles(np.exp(v)) for n, v in pulls(found.theta).items()} if found.believed else {},
        "told": told(found) if found.believed else {},
        "assumed": {"cohort": found.cohort.name, "head_tilt_deg": found.log.head_tilt_deg} | vars(found.assumed),
    }


def _quantiles(draws: Array) -> list[float | None]:
    return [None if np.isnan(value) else float(value) for value in np.nanquantile(draws, BAND)]


def _interval(draws: Array) -> str:
    low, middle, high = np.nanquantile(draws, BAND)
    return f"{middle:.3g} ({low:.3g} to {high:.3g})"


def _print(found: Stretched) -> None:
    log, known = found.log, found.assumed
    print(f"{log.path}: {len(log.time):,} rows, {log.time[-1] - log.time[0]:g} s, up to {found.reached_mm:.1f} mm")
    print(
        f"assumed: patient: {found.cohort.name} · teeth meet at 0 ± {known.reference_mm:g} mm · head tilted by "
        f"{log.head_tilt_deg:g} ± {known.tilt_deg:g} degrees · tone ± {known.tone_N:g} N a line · force "
        f"± {100.0 * known.gain:g} %"
    )
    print(f"misfit:  {found.misfit:.3g} (believed up to 1)")
    if not found.believed:
        return
    print("\nforce that holds the relaxed jaw open, N, 90 %")
    for opening, force in zip(found.openings, found.forces.T, strict=True):
        print(f"{f'{opening:g} mm':18} {_interval(force)}")
    pull, known_of = pulls(found.theta), told(found)
    print("\npull of the closed jaw F_o, N, 90 %")
    for name, title in (("all", "all muscles"), ("left", "left"), ("right", "right"), ("left : right", "left : right")):
        print(f"{title:18} {_interval(np.exp(pull[name]))}{'' if known_of[name] else f'   {NOT_MEASURED}'}")
    muscles = [name for name in MUSCLE_NAMES if known_of[name]]
    print(f"muscles told: {', '.join(muscles) or 'none'}\n{TELLS}")
