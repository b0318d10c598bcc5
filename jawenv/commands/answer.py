"""The answer of ``jawenv identify``: what a file left to be assumed, the patient who fits, and all of it as JSON."""

from __future__ import annotations

import sys
import time
from dataclasses import asdict, replace
from typing import Any

import numpy as np

from jawenv.analysis.identifiability import in_words
from jawenv.anatomy import COHORTS, MUSCLE_NAMES, Cohort, Prior, cohort
from jawenv.anatomy.cohorts import TRUNCATION_SD
from jawenv.anatomy.knowledge import LEVELS
from jawenv.base.versions import package_versions
from jawenv.ladder import MODELS
from jawenv.metrics.calibration import alarm_word
from jawenv.metrics.verdicts import NO_VERDICT, OPEN, WITHHELD, Verdict, verdicts
from jawenv.recordings import defaults
from jawenv.recordings.estimate import ENOUGH
from jawenv.recordings.identification import LEAST_S, Identification, identified
from jawenv.recordings.record import Record

UNKNOWN = replace(defaults.UNLABELLED, knowledge="bench")
"""Patient and device of a file that says nothing of them."""
_LONG_S, PATIENCE_S = 60.0, 2.0
"""Length of a recording from which, and time after which, it is said that other patients are tried."""
LOOK_AT = "signs, degrees, mm, newtons, origin, rate and frame of the columns (docs/recordings.md)"
_SD_95 = 1.96
_TITLES = {"F_o": "pull of the closed jaw F_o, N", "b": "stiffening b, no unit"}
IN_WORDS = {"exact": "known exactly", "imaged": "as from a scan", "bench": "as from a scan"}


def _alike(one: Prior, other: Prior) -> bool:
    return len(one.mean) == len(other.mean) and np.allclose([one.mean, one.sd], [other.mean, other.sd], atol=1e-9)


def _cohorts(record: Record) -> dict[str, Cohort]:
    """Every cohort with the record's muscles."""
    muscles = next(rung.muscles for rung in MODELS.values() if rung.muscles.parameter_names == record.parameter_names)
    return {name: cohort(name, muscles) for name in COHORTS}


def _cohort_assumed(record: Record) -> str | None:
    """Name of the cohort whose prior a record has; None for a prior of its own."""
    return next((name for name, one in _cohorts(record).items() if _alike(one.prior, record.prior)), None)


def assumed_in_words(record: Record) -> str:
    """Patient, anatomy and head as they were assumed."""
    name = _cohort_assumed(record)
    if name is None:
        patient = "a prior of its own"
    else:
        one = COHORTS[name]
        low, high = (np.exp((one.mean + reach * one.sd)[:, ::2]) for reach in (-2.0, 2.0))
        patient = f"{name} (F_o {low.min():.2g}–{high.max():.2g} N)"
    level = next((level for level, sds in LEVELS.items() if sds == record.knowledge), None)
    known = "known within sds" if level is None else IN_WORDS[level]
    _, tilt = defaults.model_of_geometry(record.jaw) or ("", 0.0)
    head = "upright" if abs(tilt) < 0.05 else f"pitched down by {tilt:.3g} degrees"
    return f"patient: {patient} · anatomy: {known} · head {head}"


def _fitting_cohort(record: Record) -> str | None:
    """Name of the first cohort under whose prior the recording is to be believed; None where none fits."""
    assumed, others, begun = _cohort_assumed(record), _cohorts(record), time.monotonic()
    names = sorted(COHORTS.keys() - {assumed}, key=lambda name: (name != defaults.ANYONE, list(COHORTS).index(name)))
    for number, name in enumerate(names, 1):
        if record.time[-1] > _LONG_S or time.monotonic() - begun > PATIENCE_S:
            print(f"tries whether a patient of {name} fits, {number} of {len(names)}", file=sys.stderr, flush=True)
        if identified(replace(record, prior=others[name].prior)).believable:
            return name
    return None


def doubts_in_words(record: Record, result: Identification) -> list[str]:
    """Lines that say why the estimates are not to be believed, the patient whom they fit first."""
    unfit = all(finding.plausible for finding in result.findings) and result.learnt_s >= LEAST_S
    fits = _fitting_cohort(record) if unfit else None
    doubts = [f"- {doubt}" for doubt in result.doubts]
    if fits is None:
        return [*doubts, f"Look at {LOOK_AT}."]
    patient = f"{COHORTS[fits].description} (--cohort {fits}), not {_cohort_assumed(record) or 'this prior'}"
    return [f"- the recording fits {patient}", *doubts, f"Identify it again with --cohort {fits}."]


def least_known(record: Record, result: Identification) -> dict[str, Any]:
    """The combination of natural-log parameters with the largest error bar: words, direction (p), sd and prior sd."""
    values, vectors = np.linalg.eigh(result.estimate.cov[-1])
    direction = vectors[:, -1]
    return {
        "words": in_words(direction, record.parameter_names),
        "direction": direction.tolist(),
        "sd": float(np.sqrt(values[-1])),
        "prior_sd": float(np.linalg.norm(direction * record.prior.sd)),
    }


def _enough_in_words(result: Identification) -> str:
    """Whether a recording may stop here."""
    sd = result.estimate.sd[-1]
    wide = int((sd > ENOUGH).sum())
    if not wide:
        return f"yes, all {len(sd)} error bars are within {ENOUGH:.0%}"
    return f"no, {wide} of {len(sd)} error bars are above {ENOUGH:.0%}, the largest is {sd.max():.0%}"


def _at_the_edge(record: Record, result: Identification) -> list[str]:
    """Names of parameters whose estimate is beyond 2 sds of the prior: a patient whom the cohort hardly has."""
    beyond = np.abs(result.estimate.mean[-1] - record.prior.mean) > TRUNCATION_SD * record.prior.sd
    return [name.removeprefix("log_") for name, far in zip(record.parameter_names, beyond, strict=True) if far]


def judgements(record: Record, result: Identification) -> list[Verdict]:
    """The verdict on each muscle of the whole jaw, none where the estimates are not to be believed; else empty."""
    if record.parameter_names[::2] != tuple(f"log_F_o/{name}" for name in MUSCLE_NAMES):
        return []
    if not result.believable:
        return [WITHHELD] * len(MUSCLE_NAMES)
    return verdicts(result.estimate.mean[-1], result.estimate.cov[-1], record.prior.sd)


def print_belief(record: Record, result: Identification) -> None:
    """Print the estimates, what is least known of them, and the verdicts."""
    _print_estimates(record, result)
    weakest, edge = least_known(record, result), _at_the_edge(record, result)
    print(f"least known: {weakest['words']}, sd {weakest['sd']:.1%} (before: {weakest['prior_sd']:.0%})")
    print(f"enough recorded: {_enough_in_words(result)}")
    if edge:
        print(f"at the edge of what was assumed: {', '.join(edge)}")
    _print_muscles(record, result)


def _print_estimates(record: Record, result: Identification) -> None:
    mean, sd = result.estimate.mean[-1], result.estimate.sd[-1]
    print(f"{'':32}{'estimate':>10}{'sd':>9}{'' if record.truth is None else 'truth':>9}".rstrip())
    for symbol, title in _TITLES.items():
        print(title)
        for i, name in enumerate(record.parameter_names):
            if name.startswith(f"log_{symbol}/"):
                truth = "" if record.truth is None else f"{np.exp(record.truth[i]):9.2f}"
                print(f"{name.removeprefix('log_'):32}{np.exp(mean[i]):10.2f}{100.0 * sd[i]:7.1f} %{truth}")


def _print_muscles(record: Record, result: Identification) -> None:
    """The verdict on every muscle, left beside right, with the ratio of their pulls."""
    found = judgements(record, result)
    if not found:
        return
    mean, cov = result.estimate.mean[-1], result.estimate.cov[-1]
    print(f"\n{'':18}{'left':33}{'right':33}F_o left : right, 95 %")
    for kind in dict.fromkeys(name.rsplit("_", 1)[0] for name in MUSCLE_NAMES):
        left, right = (MUSCLE_NAMES.index(f"{kind}_{side}") for side in ("left", "right"))
        words = [_in_words(found[left]), _in_words(found[right])]
        ratio = mean[2 * left] - mean[2 * right]
        pair = [2 * left, 2 * right]
        reach = _SD_95 * np.sqrt(np.array([1.0, -1.0]) @ cov[np.ix_(pair, pair)] @ np.array([1.0, -1.0]))
        low, high = np.exp(ratio - reach), np.exp(ratio + reach)
        print(f"{kind:18}{words[0]:33}{words[1]:33}{np.exp(ratio):.3g} ({low:.3g} to {high:.3g})")


def _in_words(verdict: Verdict) -> str:
    if verdict.word in (NO_VERDICT, *OPEN):
        return verdict.word
    return f"{verdict.word}, {'above 99.9' if verdict.probability > 0.999 else f'{100.0 * verdict.probability:.3g}'} %"


def as_mapping(record: Record, result: Identification) -> dict[str, Any]:
    """The answer as a pipeline reads it in place of the printed table: text, numbers, lists and None alone."""
    found = zip(MUSCLE_NAMES, judgements(record, result), strict=False)
    _, tilt = defaults.model_of_geometry(record.jaw) or ("", None)
    return {
        "parameter_names": list(record.parameter_names),
        "log_mean": result.estimate.mean[-1].tolist(),
        "log_cov": result.estimate.cov[-1].tolist(),
        "prior_mean": record.prior.mean.tolist(),
        "prior_sd": record.prior.sd.tolist(),
        "believed": result.believable,
        "doubts": result.doubts,
        "misfit": result.misfit,
        "alarm": alarm_word(result.misfit),
        "enough": bool((result.estimate.sd[-1] <= ENOUGH).all()),
        "seconds": float(record.time[-1] - record.time[0]),
        "rows": result.rows,
        "refused": result.refused,
        "least_known": least_known(record, result),
        "at_the_priors_edge": _at_the_edge(record, result),
        "verdicts": {name: _verdict(verdict) for name, verdict in found},
        "assumed": {
            "cohort": _cohort_assumed(record),
            "knowledge": {name: sd for name, sd in asdict(record.knowledge).items() if sd > 0.0},
            "head_tilt_deg": tilt,
            "force_sensor": record.force_sensor,
        },
        "versions": package_versions(),
    }


def _verdict(verdict: Verdict) -> dict[str, Any]:
    """Word and probabilities, None where there are none."""
    return {name: None if value != value else value for name, value in asdict(verdict).items()}
