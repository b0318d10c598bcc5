"""The answer to a stretcher's log of force and opening: printed, and as JSON."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from jawenv.anatomy import MUSCLE_NAMES, cohort
from jawenv.base.errors import InputError
from jawenv.base.versions import package_versions
from jawenv.metrics.diagnosis import MEASURED
from jawenv.metrics.verdicts import NOT_MEASURED
from jawenv.recordings.defaults import ANYONE
from jawenv.recordings.stretcher.identified import Stretched, pulls, stretched
from jawenv.recordings.stretcher.log import log_of_table
from jawenv.recordings.table import RecordTable, checked_path, read_table
from jawenv.recordings.words import WORDS

Array = NDArray[np.float64]

BAND = (0.05, 0.5, 0.95)
ALLOWED = ("cohort", "columns", "before")
TELLS = "This log tells how stiff the jaw is, not where."


@dataclass(frozen=True, eq=False)
class StretcherAnswer:
    """The answer to a stretcher's log of force and opening, and an earlier one; printed, it is the command's table."""

    found: tuple[Stretched, ...]

    @property
    def believed(self) -> bool:
        """Whether nothing speaks against any of the logs."""
        return all(one.believed for one in self.found)

    @property
    def doubts(self) -> list[str]:
        """Why a log is not to be believed; empty where all are."""
        return [f"{one.log.path}: {doubt}" for one in self.found for doubt in one.doubts]

    def reasons(self) -> list[str]:
        """The doubts, a line each."""
        return [f"- {doubt}" for doubt in self.doubts]

    def __str__(self) -> str:
        lines = [line for one in self.found for line in _lines(one)]
        if len(self.found) > 1 and self.believed:
            lines += ["", f"since {self.found[1].log.path}, 90 %:"]
            lines += [f"{name:18} {_interval(ratio)} times" for name, ratio in changes(*self.found).items()]
        return "\n".join(lines)

    def mapping(self) -> dict[str, Any]:
        """The answer as a program reads it: text, numbers, lists and None alone; the log, then an earlier one."""
        answer = [_one(one) for one in self.found]
        change = {}
        if len(self.found) > 1 and self.believed:
            change = {name: _quantiles(ratio) for name, ratio in changes(*self.found).items()}
        return answer[0] | {"before": answer[1:], "change": change, "versions": package_versions()}


def answer_of_log(table: RecordTable, reading: Mapping[str, Any], before: Any) -> StretcherAnswer:
    """The answer to a log of force and opening.

    Args:
        table: as read.
        reading: arguments of ``jawenv.identify``, of which ``cohort`` and ``columns`` are allowed.
        before: path of an earlier log of the same patient, or None.
    """
    for name, value in reading.items():
        if value is not None and name not in ALLOWED:
            raise InputError(f"{table.path}: {name} with a log of force and opening; allowed: {', '.join(ALLOWED)}")
    logs = [log_of_table(table, reading["columns"])]
    if before is not None:
        logs.append(log_of_table(read_table(checked_path(before), WORDS), reading["columns"]))
    population = cohort(reading["cohort"] or table.header.get("cohort", ANYONE))
    return StretcherAnswer(tuple(stretched(log, population, seed=i) for i, log in enumerate(logs)))


def changes(now: Stretched, before: Stretched) -> dict[str, Array]:
    """Draws of ratios since an earlier log, by name: force at each opening that both reached, total pull."""
    number, both = min(len(now.theta), len(before.theta)), min(len(now.openings), len(before.openings))
    ratios = now.forces[:number, :both] / before.forces[:number, :both]
    total = np.exp(pulls(now.theta[:number])["all"] - pulls(before.theta[:number])["all"])
    return {f"force at {mm:g} mm": ratios[:, i] for i, mm in enumerate(now.openings[:both])} | {"total pull": total}


def measured(found: Stretched) -> dict[str, bool]:
    """Whether the log tells each of these: its error bar is at most half of what it was before."""
    before, after = pulls(found.prior), pulls(found.theta)
    words = {name: bool(np.std(after[name]) <= MEASURED * np.std(before[name])) for name in before}
    of_each = np.std(found.theta, axis=0) <= MEASURED * np.std(found.prior, axis=0)
    return words | {name: bool(of_each[2 * i : 2 * i + 2].all()) for i, name in enumerate(MUSCLE_NAMES)}


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
        "told": measured(found) if found.believed else {},
        "assumed": {"cohort": found.cohort.name, "head_tilt_deg": found.log.head_tilt_deg} | vars(found.assumed),
    }


def _quantiles(draws: Array) -> list[float | None]:
    return [None if np.isnan(value) else float(value) for value in np.nanquantile(draws, BAND)]


def _interval(draws: Array) -> str:
    low, middle, high = np.nanquantile(draws, BAND)
    return f"{middle:.3g} ({low:.3g} to {high:.3g})"


def _lines(found: Stretched) -> list[str]:
    log, known = found.log, found.assumed
    lines = [
        f"{log.path}: {len(log.time):,} rows, {log.time[-1] - log.time[0]:g} s, up to {found.reached_mm:.1f} mm",
        f"assumed: patient: {found.cohort.name} · teeth meet at 0 ± {known.reference_mm:g} mm · head tilted by "
        f"{log.head_tilt_deg:g} ± {known.tilt_deg:g} degrees · tone ± {known.tone_N:g} N a line · force "
        f"± {100.0 * known.gain:g} %",
        f"misfit:  {found.misfit:.3g} (believed up to 1)",
    ]
    if not found.believed:
        return lines
    lines += ["", "force that holds the relaxed jaw open, N, 90 %"]
    forces = zip(found.openings, found.forces.T, strict=True)
    lines += [f"{f'{opening:g} mm':18} {_interval(force)}" for opening, force in forces]
    pull, known_of = pulls(found.theta), measured(found)
    lines += ["", "pull of the closed jaw F_o, N, 90 %"]
    for name, title in (("all", "all muscles"), ("left", "left"), ("right", "right"), ("left : right", "left : right")):
        lines.append(f"{title:18} {_interval(np.exp(pull[name]))}{'' if known_of[name] else f'   {NOT_MEASURED}'}")
    muscles = [name for name in MUSCLE_NAMES if known_of[name]]
    return [*lines, f"muscles told: {', '.join(muscles) or 'none'}", TELLS]
