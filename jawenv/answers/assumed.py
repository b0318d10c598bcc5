"""Patient and device as a recording left them to be assumed, and whom it fits instead."""

from __future__ import annotations

import sys
import time
from dataclasses import replace

import numpy as np

from jawenv.anatomy import COHORTS, Cohort, Prior, cohort
from jawenv.anatomy.knowledge import LEVELS
from jawenv.ladder import MODELS
from jawenv.recordings import defaults
from jawenv.recordings.identification import LEAST_S, Identification, identified
from jawenv.recordings.record import Record
from jawenv.recordings.size import size_in
from jawenv.recordings.untold.learnt import Learnt

_LONG_S, PATIENCE_S = 60.0, 2.0
"""Length of a recording from which, and time after which, it is said that other patients are tried."""
WIDER = 2.0
"""Times the sds of a cohort whose edge the estimates lie beyond."""
_LOOK_AT = "signs, degrees, mm, newtons, origin, rate and frame of the columns (docs/recordings.md)"
_KNOWN = {"exact": "known exactly", "imaged": "as from a scan", "bench": "as from a scan"}


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
    level = next((level for level, sds in LEVELS.items() if sds == record.knowledge), None)
    known = "known within sds" if level is None else _KNOWN[level]
    tilt, size = defaults.tilt_of(record.jaw), size_in(record.jaw)
    known += "" if size == 1.0 else f", mandible {size:.2f} of the table's, by its motion"
    head = "upright" if abs(tilt) < 0.05 else f"pitched down by {tilt:.3g} degrees"
    return f"patient: {patient} · anatomy: {known} · head {head}"


def learnt_in_words(record: Record, last: Learnt | None) -> str:
    """What the recording itself shows of errors that nobody told, and how little its parts agree."""
    if last is None:
        return "nothing, the recording is too short or its readings contradict each other"
    tilt = defaults.tilt_of(last.jaw)
    sizes, force = last.sizes, max(last.sizes["constant"], last.sizes["shapes"])
    said = {
        f"lines of muscles {sizes['lines']:g} times as far from the table as a scan leaves them": sizes["lines"] > 1.0,
        f"the head is pitched by {tilt:.0f} degrees": abs(tilt - defaults.tilt_of(record.jaw)) > 1.0,
        f"a force of {force:g} N that no muscle pulls": force > 0.0,
        f"laws of muscles bent by {sizes['law']:.0%}: F_o and b are numbers of a law that this jaw does not follow": (
            sizes["law"] > 0.0
        ),
        f"error bars {last.temperature**0.5:.1f} times as wide, since parts disagree": last.temperature > 1.0,
    }
    return "; ".join(words for words, there in said.items() if there) or "no error beyond what was assumed"


def _fitting_cohort(record: Record) -> str | None:
    """Name of the first cohort under whose prior the recording is to be believed; None where none fits."""
    assumed, others, begun = cohort_assumed(record), _cohorts(record), time.monotonic()
    names = sorted(COHORTS.keys() - {assumed}, key=lambda name: (name != defaults.ANYONE, list(COHORTS).index(name)))
    for number, name in enumerate(names, 1):
        if record.time[-1] > _LONG_S or time.monotonic() - begun > PATIENCE_S:
            print(f"tries whether a patient of {name} fits, {number} of {len(names)}", file=sys.stderr, flush=True)
        if identified(replace(record, prior=others[name].prior)).believable:
            return name
    return None


def reasons(record: Record, result: Identification) -> list[str]:
    """Lines that say why the estimates are not to be believed, the patient whom they fit first."""
    unfit = all(finding.plausible for finding in result.findings) and result.learnt_s >= LEAST_S
    fits = _fitting_cohort(record) if unfit else None
    doubts = [f"- {doubt}" for doubt in result.doubts]
    if fits is None:
        return [*doubts, f"Look at {_LOOK_AT}."]
    patient = f"{COHORTS[fits].description} (--cohort {fits}), not {cohort_assumed(record) or 'this prior'}"
    return [f"- the recording fits {patient}", *doubts, f"Identify it again with --cohort {fits}."]
