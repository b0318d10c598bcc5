"""Every entry's figures with their intervals: ranked entries, the best first, then all others with the reason.

Ranked is by the time until all parameters are within 5 %: median over the patients, then the 90 % quantile, then the
share that gets there; among equals, as where nobody gets there, by true information, which overconfidence cannot raise.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from agents.registry import shipped_names
from eval.comparison.admission import FALSE_NEES, AdmissionLimits, does_not_fit, false_sd
from eval.comparison.results import Results
from eval.figures.catalogue import FIGURES, Figure, above_limit, gained, reaches, time_to
from eval.figures.statistics import Interval
from jawenv.base.errors import InputError
from jawenv.metrics import nees_band
from jawenv.metrics.score import KNOWN as KNOWN

SOON = time_to(KNOWN)
"""Name of the figure by which entries are ranked."""
N_LETTERS = 26
CLAIRVOYANT = "plans with the patient's true parameters: a yardstick, no contestant"


@dataclass(frozen=True)
class RankingRow:
    """One entry and its figures."""

    entry: str  # its label
    trained: bool  # whether it comes from a training run
    own: bool  # whether it does not come with the project, and is no replay of another entry
    control: str  # its control mode
    note: str  # in which settings it differs from those asked for
    excluded: str  # why it is not ranked; empty if it is
    false_sd: str  # why its sds cannot be believed; empty if they can
    does_not_fit: str  # why nothing counts as known, where the alarm rings too often; else empty
    figures: Mapping[str, Interval]
    """Each of ``Ranking.catalogue``, the difference from the reference but for the reference itself."""

    def __getitem__(self, figure: str) -> Interval:
        """One figure."""
        return self.figures[figure]


@dataclass(frozen=True)
class Ranking:
    """The entries of a study: the ranked ones, best first, then the others."""

    rows: tuple[RankingRow, ...]  # ranked, then the others in the same order among themselves
    env: str  # id of the environment that all were played in
    parameters: tuple[str, ...]  # names of the parameters to identify
    reference: str  # the entry that differences are taken against
    patients: int  # how many
    admission: AdmissionLimits  # limits of comfort
    catalogue: Mapping[str, Figure]  # the figures of every row
    effects: dict[str, float]
    """Fields of ``jawenv.reality.Reality`` that acted on the truth and that the filter did not know."""
    band: tuple[float, float]
    """Interval of the mean NEES of all entries in 95 % of the calibrated studies of this size (Bonferroni)."""
    asked: str = ""  # the muscles that are asked for, as the environment's argument; empty for all

    @property
    def ranked(self) -> tuple[RankingRow, ...]:
        """The ranked rows, best first."""
        return tuple(row for row in self.rows if not row.excluded)

    @property
    def others(self) -> tuple[RankingRow, ...]:
        """The rows outside the ranking."""
        return tuple(row for row in self.rows if row.excluded)

    def mark(self, row: RankingRow) -> str:
        """Mark of a row in figures: its place, or a letter where it is not ranked."""
        if not row.excluded:
            return str(self.rows.index(row) + 1)
        number = self.others.index(row)
        return chr(ord("a") + number) if number < N_LETTERS else f"a{number}"

    @property
    def believed(self) -> bool:
        """Whether the sds of any entry can be believed."""
        return any(not row.false_sd for row in self.rows)

    @property
    def has_bound(self) -> bool:
        """Whether the bound holds: only for a filter with a true model."""
        return not self.effects

    @property
    def n_parameters(self) -> int:
        """Number of parameters, also the mean of a calibrated NEES."""
        return len(self.parameters)

    @property
    def sought(self) -> str:
        """The parameters to identify, in words: all, or the ones asked for."""
        return "the parameters asked for" if self.asked else f"all {self.n_parameters} parameters"

    @property
    def best(self) -> RankingRow | None:
        """The first ranked row with stated errors to be believed, by NEES and alarm; None if there is none."""
        return next((row for row in self.ranked if self.believes(row)), None)

    def believes(self, row: RankingRow) -> bool:
        """Whether a row's stated errors can be believed: neither too small, nor false, nor those of ringing alarms.

        They are judged at the end, and in nine patients of ten when all parameters are first known.
        """
        known = row["known_nees_p90"].value <= FALSE_NEES * self.n_parameters
        return self.calibration(row) != "overconfident" and not row.does_not_fit and not row.false_sd and known

    def calibration(self, row: RankingRow) -> str:
        """`calibrated`, `overconfident` or `cautious`, by the mean NEES against its band."""
        low, high = self.band
        nees = row["nees"].value
        return "overconfident" if nees > high else "cautious" if nees < low else "calibrated"


def rank(study: Results, reference: str | None = None, admission: AdmissionLimits | None = None) -> Ranking:
    """Order the entries of a study and give every figure its interval.

    Args:
        study: results of all entries on the same patients.
        reference: label of the entry that the others are compared with; the best by default.
        admission: limits of comfort; the defaults of ``AdmissionLimits`` without one.
    """
    if reference is not None and reference not in study.entries:
        raise InputError(f"reference is {reference!r}; allowed: {', '.join(study.entries)}")
    allowed = admission or AdmissionLimits()
    catalogue = {**FIGURES, "above_limit": above_limit(allowed.discomfort_s)}
    rows = sorted((_row(study, entry, catalogue, allowed) for entry in study.entries), key=_order)
    against = reference or rows[0].entry
    difference = gained(study.of(against))
    number, parameters = len(study.of(against)), len(study.parameters)
    settings = study.about.get("settings", {})
    return Ranking(
        rows=tuple(row if row.entry == against else _with(row, difference, study) for row in rows),
        env=study.env,
        parameters=study.parameters,
        reference=against,
        patients=number,
        admission=allowed,
        catalogue=catalogue | {difference.name: difference},
        effects=settings.get("reality") or {},
        asked=settings.get("asked") or "",
        band=nees_band(number, parameters, 1.0 - 0.05 / len(rows)),
    )


def _order(row: RankingRow) -> tuple[float | bool, ...]:
    """Sorting key of rows."""
    soon = (row[SOON].value, row[f"{SOON}_p90"].value, -row[reaches(KNOWN)].value)
    return (bool(row.excluded), bool(row.does_not_fit), bool(row.false_sd), *soon, -row["information_true"].value)


def _with(row: RankingRow, figure: Figure, study: Results) -> RankingRow:
    """The row with one more figure."""
    return replace(row, figures={**row.figures, figure.name: figure.interval(study.of(row.entry))})


def _row(study: Results, entry: str, catalogue: Mapping[str, Figure], admission: AdmissionLimits) -> RankingRow:
    rows = study.of(entry)
    figures = {name: figure.interval(rows) for name, figure in catalogue.items()}
    metadata: dict[str, Any] = next((other for other in study.about["entries"] if other["label"] == entry), {})
    nees, true, claimed = (figures[name].value for name in ("nees", "information_true", "information_claimed"))
    false = false_sd(nees, true, claimed, len(study.parameters))
    unfit = does_not_fit(figures["rings"].value)
    reasons = [CLAIRVOYANT] if metadata.get("clairvoyant") else []
    reasons += [reason for reason in (unfit, false) if reason]
    reasons += admission.reasons(figures["discomfort_rate"].value, figures["violated"].value)
    return RankingRow(
        entry=entry,
        trained=metadata.get("trained", False),
        own=metadata.get("spec", entry) not in shipped_names() and not metadata.get("replay_of"),
        control=metadata.get("env_kwargs", {}).get("control", "?"),
        note=metadata.get("note", ""),
        excluded="; ".join(reasons),
        false_sd=false,
        does_not_fit=unfit,
        figures=figures,
    )
