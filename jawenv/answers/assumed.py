"""Patient and device as a recording left them to be assumed, and whom it fits instead."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from jawenv.anatomy import COHORTS, Cohort, Prior, cohort
from jawenv.anatomy.knowledge import LEVELS
from jawenv.ladder import MODELS
from jawenv.recordings import defaults
from jawenv.recordings.identification import LEAST_S, Identification, identified
from jawenv.recordings.record import Record
from jawenv.recordings.size import AXES_MM, size_in
from jawenv.recordings.untold.learnt import Learnt

WIDER = 2.0
"""Times the sds of a cohort whose edge the estimates lie beyond."""
_LOOK_AT = "signs, degrees, mm, newtons, origin, rate and frame of the columns (docs/recordings.md)"
_KNOWN = {"exact": "known exactly", "imaged": "as from a scan", "bench": "the table's"}


def _alike(one: Prior, other: Prior) -> bool:
    return len(one.mean) == len(other.mean) and np.allclose([one.mean, one.sd], [other.mean, other.sd], atol=1e-9)


def _cohorts(record: Record) -> dict[str, Cohort]:
    """Every cohort with the record's muscles."""
    muscles = next(rung.muscles for rung in MODELS.values() if rung.muscles.parameter_names == record.parameter_names)
    return {name: cohort(name, muscles) for name in COHORTS}


def cohort_assumed(record: Record) -> str | None:
    """Name of the cohort whose prior a record has; None for a prior of its own."""
    return next((name for name, one in _cohorts(record).items() if _alike(one.prior, record.prior)), None)


def assumed_in_words(record: Record) -> str:
    """Patient, anatomy and head as they were assumed."""
    wide = replace(record, prior=Prior(record.prior.mean, record.prior.sd / WIDER))
    name, wider = cohort_assumed(record), cohort_assumed(wide)
    if name is None:
        patient = "a prior of its own" if wider is None else f"beyond {wider}, whose sds were doubled"
    else:
        one = COHORTS[name]
        low, high = (np.exp((one.mean + reach * one.sd)[:, ::2]) for reach in (-2.0, 2.0))
        patient = f"{name} (F_o {low.min():.2g}–{high.max():.2g} N)"
    felt = record.knowledge.axes_mm >= AXES_MM
    level = "bench" if felt else next((level for level, sds in LEVELS.items() if sds == record.knowledge), None)
    known = "known within sds" if level is None else _KNOWN[level]
    tilt, size = defaults.tilt_of(record.jaw), size_in(record.jaw)
    known += "" if size == 1.0 else f", mandible {size:.2f} of the table's, by its motion"
    known += "" if not felt else f", axes within {AXES_MM:g} mm of the condyles"
    head = "upright" if abs(tilt) < 0.05 else f"pitched down by {tilt:.3g} degrees"
    return f"patient: {patient} · anatomy: {known} · head {head}"


def learnt_in_words(record: Record, last: Learnt | None) -> str:
    """What the recording itself shows of errors that nobody told, and how little its parts agree."""
    if last is None:
        return "nothing, the recording is too short or its readings contradict each other"
    tilt = defaults.tilt_of(last.jaw)
    late, late_sd = (0.0, 0.0) if last.joint is None else last.joint.late_s
    sizes, force = last.sizes, max(last.sizes["constant"], last.sizes["shapes"])
    said = {
        f"lines of muscles {sizes['lines']:g} times as far from the table as a scan leaves them": sizes["lines"] > 1.0,
        f"the head is pitched by {tilt:.0f} degrees": abs(tilt - defaults.tilt_of(record.jaw)) > 1.0,
        f"forces are late by {1e3 * late:.0f} ms": abs(late) > max(3.0 * late_sd, 0.008),
        f"a force of {force:g} N that no muscle pulls": force > 0.0,
        f"laws of muscles bent by {sizes['law']:.0%}: F_o and b are numbers of a law that this jaw does not follow": (
            sizes["law"] > 0.0
        ),
        f"error bars {last.temperature**0.5:.1f} times as wide, since parts disagree": last.temperature > 1.0,
    }
    return "; ".join(words for words, there in said.items() if there) or "no error beyond what was assumed"


def reasons(record: Record, result: Identification) -> list[str]:
    """Lines that say why the estimates are not to be believed; first whether they fit anyone, if not whom was told."""
    unfit = all(finding.plausible for finding in result.findings) and result.learnt_s >= LEAST_S
    doubts, told, anyone = [f"- {doubt}" for doubt in result.doubts], cohort_assumed(record), COHORTS[defaults.ANYONE]
    wider = replace(record, prior=_cohorts(record)[anyone.name].prior)
    if told == anyone.name or not unfit or not identified(wider).believable:
        return [*doubts, f"Look at {_LOOK_AT}."]
    fits = f"- the recording fits {anyone.description}, not {told or 'this prior'}"
    return [fits, *doubts, f"Identify it again with --cohort {anyone.name}."]
