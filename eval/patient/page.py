"""One patient on one page: each closing muscle, its certainty and its meaning; prints on one sheet."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from markupsafe import Markup

from eval.figures import words
from eval.kept.entries import Entry
from eval.patient import believed, charts, drawing
from eval.patient.changes import Change, change_in_words, change_of
from eval.patient.charts import SD_95, Axis
from eval.patient.courses import Person
from eval.patient.treatments import Course, Treatment, population_of
from eval.report import template
from jawenv.anatomy import MUSCLE_NAMES, Prior, muscle_set
from jawenv.answers.tension import Tension
from jawenv.base.errors import InputError
from jawenv.ladder import model_of_env
from jawenv.metrics import BLOCKED_B, CONFIDENCE, STIFF_F_O_N
from jawenv.metrics.verdicts import (
    BOTH,
    FINDINGS,
    NO_VERDICT,
    NOT_MEASURED,
    OPEN,
    WITHHELD,
    WORDS,
    Verdict,
    truly,
    verdict,
    verdicts,
)

FORCE = Axis(0.05, 20.0, (0.1, 1.0, 10.0), STIFF_F_O_N)
STIFFENING = Axis(2.0, 50.0, (2.0, 5.0, 10.0, 20.0, 50.0), BLOCKED_B)
SHEET = Path(__file__).parent
LOCATIONS = {
    "masseter": "the thick muscle of the cheek",
    "temporalis": "the fan at the temple",
    "medial_pterygoid": "the deep muscle inside the angle of the jaw",
}


@dataclass(frozen=True)
class _CardQuantity:
    """An estimate with its 95 % interval and its change, as words; and over time, as a picture."""

    value: str
    interval: str
    change: str
    picture: Markup
    truth: str


@dataclass(frozen=True)
class _Card:
    """Texts and pictures of one muscle."""

    title: str  # the muscle's name and side
    location: str  # where it is, in plain words
    verdict: Verdict  # word of the verdict
    badge: str  # CSS class of the verdict
    chance: str  # the probability in words
    before: str  # what the prior gave it, in words
    since: str  # start of the present verdict; empty where nothing is known
    force: _CardQuantity  # F_o
    stiffening: _CardQuantity  # b
    doubling: str  # stretch that doubles the pull, %
    truth: str  # the true condition, where it is shown


@dataclass(frozen=True)
class Subject:
    """The patient of the page."""

    who: str  # the title
    account: str  # the treatments in a line
    notice: str  # disclaimer
    prior: Prior  # belief about the muscles before the first treatment
    effects: str = ""  # effects unknown to the estimate; empty for none
    tension: Mapping[str, Sequence[Tension]] = field(default_factory=dict)
    """Closing forces at the incisors of a recording, see ``Answer.tension``."""

    @classmethod
    def simulated(cls, entry: Entry, person: Person, plan: Course, seconds: float) -> Subject:
        """A simulated patient, treated by an entry."""
        times = "One treatment" if plan.number == 1 else f"{plan.number} treatments, one after the other,"
        account = f"{times} with the maneuver “{words.label(entry.label)}”, {seconds:g} s"
        if plan.number > 1:
            account += " each"
        if plan.drift:
            account += f"; the muscles change by about {100 * plan.drift:g} % from one to the next"
        effects = ", ".join(f"{name} = {value:g}" for name, value in entry.env_kwargs.get("reality", {}).items())
        exact = "known exactly: with a scan's anatomy all is several times less sure"
        anatomy = exact if entry.world.build_knowledge().exact else "known within the errors of a scan, or as told"
        notice = f"Research, not a medical device. The patient is simulated, the anatomy {anatomy}."
        return cls(_who(entry, person), account, notice, population_of(entry).prior, effects)


def check_env(env_id: str) -> None:
    """Check that an environment has the six muscles that the page draws."""
    model = model_of_env(env_id)
    if model.muscles.names != MUSCLE_NAMES:
        raise InputError(f"env is {env_id}; allowed: those with six closing muscles, Jaw and JawImaged")


def render(subject: Subject, course: Sequence[Treatment], metadata: dict[str, Any], show_truth: bool) -> str:
    """The page as HTML text.

    Args:
        subject: patient and treatments.
        course: treatments, or a recording as one.
        metadata: command, versions, time.
        show_truth: whether the true values of the simulated patient are shown.
    """
    now = verdicts_of(course, subject.prior)
    verdict_words = {name: verdict.word for name, verdict in zip(MUSCLE_NAMES, now, strict=True)}
    changed, shown = change_of(course, subject.prior), course[-1].shown
    cards = {name: _card(course, subject.prior, changed, i, now[i], show_truth) for i, name in enumerate(MUSCLE_NAMES)}
    return template.render(
        "patient.html.j2",
        SHEET,
        subject=subject,
        number=len(course),
        seconds=f"{course[-1].time[-1]:g}",
        ended_early=[i for i, treatment in enumerate(course, 1) if treatment.violated],
        unfit=[i for i, treatment in enumerate(course, 1) if treatment.rings],
        headline=headline(verdict_words),
        views={side: drawing.view(side, muscle_set(), verdict_words) for side in ("right", "left")},
        rows=[(cards[f"{kind}_right"], cards[f"{kind}_left"]) for kind in LOCATIONS],
        legend=[
            (word, drawing.class_of(word))
            for word in (*WORDS, NO_VERDICT)
            if word not in (BOTH, NOT_MEASURED, NO_VERDICT) or word in verdict_words.values()
        ],
        stiff=f"{STIFF_F_O_N:g}",
        blocked=f"{BLOCKED_B:g}",
        doubling_normal=f"{100.0 * math.log(2.0) / BLOCKED_B:.0f}",
        confidence=f"{100.0 * CONFIDENCE:g}",
        show_truth=show_truth,
        changes=changed is not None,
        believed=shown and (believed.figure(shown), believed.in_words(shown)),
        about=metadata,
    )


def verdicts_of(course: Sequence[Treatment], prior: Prior) -> list[Verdict]:
    """The verdict on every muscle after the last treatment; none where the readings of any do not fit the model.

    Args:
        course: treatments, each begun with the belief after the one before.
        prior: of the muscles, before the first.
    """
    if any(treatment.rings for treatment in course):
        return [WITHHELD] * len(MUSCLE_NAMES)
    return verdicts(course[-1].mean[-1], course[-1].cov[-1], prior.sd)


def headline(verdict_words: dict[str, str]) -> str:
    """All verdicts in a sentence or two.

    Args:
        verdict_words: muscle -> verdict.
    """
    if NO_VERDICT in verdict_words.values():
        return "No verdict: the readings do not fit the model."
    groups = {
        word: [words.label(name) for name, found_word in verdict_words.items() if found_word == word] for word in WORDS
    }
    if sum(len(groups[word]) for word in OPEN) == len(verdict_words):
        return "Nothing can be said about any of the six closing muscles yet."
    order = [word for word in (*FINDINGS, *OPEN) if groups[word]]
    parts = []
    for word in order:
        names = groups[word]
        if len(names) == len(verdict_words):
            return f"All six closing muscles are {word}."
        parts.append(f"{word.capitalize()}: {_listed(names)}.")
    return " ".join(parts)


def _listed(names: Sequence[str]) -> str:
    for side in ("left", "right"):
        if len(names) == len(LOCATIONS) and all(name.endswith(side) for name in names):
            return f"all three on the {side}"
    return ", ".join(names)


def _who(entry: Entry, person: Person) -> str:
    if person.patient is not None:
        return f"Simulated patient “{person.name}”"
    return f"Simulated patient {person.name} of the cohort “{words.label(str(entry.env_kwargs['cohort']))}”"


def _card(
    course: Sequence[Treatment], prior: Prior, changed: Change | None, muscle: int, now: Verdict, show_truth: bool
) -> _Card:
    name = MUSCLE_NAMES[muscle]
    kind, side = name.rsplit("_", 1)
    title = f"{words.label(kind).capitalize()}, {side}"
    b = math.exp(float(course[-1].mean[-1, 2 * muscle + 1]))
    pair = slice(2 * muscle, 2 * muscle + 2)
    assumed = verdict(prior.mean[pair], np.diag(np.square(prior.sd[pair]))).chance_of(now.word)
    return _Card(
        title=title,
        location=LOCATIONS[kind],
        verdict=now,
        badge=drawing.class_of(now.word),
        chance=_chance(now.probability) if now.word != NO_VERDICT else "",
        before=_chance(assumed) if now.word in FINDINGS else "",
        since=_since(course, prior, muscle, now.word),
        force=_quantity(course, changed, 2 * muscle, FORCE, f"Pull of the {title} over time", "N", show_truth),
        stiffening=_quantity(
            course, changed, 2 * muscle + 1, STIFFENING, f"Stiffening of the {title} over time", "", show_truth
        ),
        doubling=_significant(100.0 * math.log(2.0) / b),
        truth=truly(course[-1].truth[2 * muscle : 2 * muscle + 2]) if show_truth else "",
    )


def _quantity(
    course: Sequence[Treatment],
    changed: Change | None,
    parameter: int,
    axis: Axis,
    label: str,
    unit: str,
    show_truth: bool,
) -> _CardQuantity:
    mean, sd = float(course[-1].mean[-1, parameter]), math.sqrt(course[-1].cov[-1, parameter, parameter])
    low, high = (_significant(math.exp(mean + factor * sd)) for factor in (-SD_95, SD_95))
    return _CardQuantity(
        value=f"{_significant(math.exp(mean))} {unit}".strip(),
        interval=f"{low} to {high}",
        change="" if changed is None else change_in_words(*changed.of(parameter)),
        picture=charts.chart(course, parameter, axis, label, show_truth),
        truth=f"{_significant(math.exp(course[-1].truth[parameter]))} {unit}".strip() if show_truth else "",
    )


def _significant(value: float) -> str:
    """Three significant digits, without an exponent."""
    digits = max(0, 2 - math.floor(math.log10(value)))
    return f"{value:.{digits}f}"


def _chance(probability: float) -> str:
    return "above 99.9 %" if probability > 0.999 else f"{100.0 * probability:.{1 if probability > 0.99 else 0}f} %"


def _since(course: Sequence[Treatment], prior: Prior, muscle: int, word: str) -> str:
    """The moment since when the data have given the verdict, in words."""
    if word in (NO_VERDICT, *OPEN):
        return ""
    pair = slice(2 * muscle, 2 * muscle + 2)
    steps = [(number, step) for number, treatment in enumerate(course) for step in range(len(treatment.time))]
    since = steps[-1]
    for number, step in reversed(steps):
        treatment = course[number]
        if verdicts(treatment.mean[step, pair], treatment.cov[step, pair, pair], prior.sd[pair])[0].word != word:
            break
        since = number, step
    if since == steps[0]:
        return ", from the start"
    number, step = since
    when = f"{float(course[number].time[step]):.1f} s" if len(course) == 1 else f"treatment {number + 1}"
    return f", since {when}"


def verdict_rows(person: Person, course: Sequence[Treatment], prior: Prior) -> list[dict[str, object]]:
    """One row per treatment and muscle: estimates with 95 % intervals, verdict, probabilities, truth.

    ``F_o_change`` and ``b_change`` are factors since the first treatment, with ``_low`` and ``_high``; NaN in the
    first, and where the anatomy is known exactly.

    Args:
        person: the patient.
        course: treatments of the patient.
        prior: of the muscles.
    """
    rows: list[dict[str, object]] = []
    for number, treatment in enumerate(course, 1):
        sd = np.sqrt(np.diagonal(treatment.cov[-1]))
        estimate, truth = np.exp(treatment.mean[-1]), np.exp(treatment.truth)
        low, high = np.exp(treatment.mean[-1] - SD_95 * sd), np.exp(treatment.mean[-1] + SD_95 * sd)
        changed = change_of(course[:number], prior) or Change(*np.full((2, len(truth)), np.nan))
        for i, found in enumerate(verdicts_of(course[:number], prior)):
            row: dict[str, object] = {"patient": person.name, "seed": person.seed, "treatment": number}
            row |= {"muscle": MUSCLE_NAMES[i], "verdict": found.word, "probability": found.probability}
            row |= {
                "stiff": found.stiff,
                "blocked": found.blocked,
                "truly": truly(treatment.truth[2 * i : 2 * i + 2]),
            }
            for symbol, k in (("F_o_N", 2 * i), ("b", 2 * i + 1)):
                row |= {symbol: estimate[k], f"{symbol}_low": low[k], f"{symbol}_high": high[k]}
                row |= {f"{symbol}_true": truth[k]}
                names = (f"{symbol.removesuffix('_N')}_change{end}" for end in ("", "_low", "_high"))
                row |= dict(zip(names, changed.of(k), strict=True))
            rows.append(row | {"nees_of_12": treatment.nees, "misfit": treatment.misfit})
    return rows
