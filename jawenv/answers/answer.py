"""The answer to recordings of one patient: who fits, how well each number is known, and whether to believe it."""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from jawenv.analysis.wording import in_words
from jawenv.anatomy import MUSCLE_NAMES
from jawenv.anatomy.cohorts import TRUNCATION_SD
from jawenv.answers.assumed import assumed_in_words, cohort_assumed, learnt_in_words, reasons
from jawenv.answers.tension import Tension, tensions_of
from jawenv.answers.tension import in_words as in_words_of_tension
from jawenv.base.versions import package_versions
from jawenv.metrics.calibration import YELLOW, alarm_word
from jawenv.metrics.verdicts import NO_VERDICT, OPEN, WITHHELD, Verdict, verdicts
from jawenv.recordings.defaults import tilt_of
from jawenv.recordings.estimate import ENOUGH, Array
from jawenv.recordings.identification import Identification
from jawenv.recordings.record import Record
from jawenv.recordings.several.together import Agreement
from jawenv.recordings.size import size_in
from jawenv.recordings.untold.learnt import Learnt
from jawenv.recordings.zero import UNSEEN_DRIFT, change_of_zero

_SD_95 = 1.96
BEYOND_SDS = 2.5
_TITLES = {"F_o": "pull of the closed jaw F_o, N", "b": "stiffening b, no unit"}


@dataclass(frozen=True, eq=False)
class Answer:
    """The answer to recordings of one patient; printed, it is the table of ``jawenv identify``.

    Natural logs of p parameters; an sd of 0.05 is 5 %.
    """

    paths: tuple[str, ...]  # of the recordings
    records: tuple[Record, ...]
    """The recordings as read, with what was assumed of patient and device."""
    each: tuple[Identification, ...]
    """The identification of each recording by itself."""
    whole: Identification
    """Identification of all together; of one recording the same."""
    learnt: Learnt | None
    """The belief with learnt sizes of errors, of one recording."""
    agreement: Agreement | None
    """Whether several recordings can be of one patient; None of one."""

    @property
    def parameter_names(self) -> tuple[str, ...]:
        """P names, as ``log_F_o/masseter_left``."""
        return self.records[0].parameter_names

    @property
    def log_mean(self) -> Array:
        """(p,) mean of the natural logs."""
        mean: Array = self.whole.estimate.mean[-1]
        return mean

    @property
    def log_cov(self) -> Array:
        """(p, p) their covariance."""
        cov: Array = self.whole.estimate.cov[-1]
        return cov

    @property
    def log_sd(self) -> Array:
        """(p,) sd of the natural logs."""
        sd: Array = self.whole.estimate.sd[-1]
        return sd

    @property
    def believed(self) -> bool:
        """Whether nothing speaks against the estimates."""
        return self.whole.believable and self.agree

    @property
    def doubts(self) -> list[str]:
        """Why the estimates are not to be believed; empty where they are."""
        return [*self.whole.doubts, *([] if self.agree else [self._disagreement()])]

    @property
    def verdicts(self) -> dict[str, Verdict]:
        """The verdict on each muscle of the whole jaw by F_o and b; empty of other muscles.

        None where the estimates are not to be believed, or the jaw does not follow their law: then forces have one.
        """
        if self.parameter_names[::2] != tuple(f"log_F_o/{name}" for name in MUSCLE_NAMES):
            return {}
        found = [WITHHELD] * len(MUSCLE_NAMES)
        if self.whole.believable and (self.learnt is None or self.learnt.sizes["law"] == 0.0):
            found = verdicts(self.log_mean, self.log_cov, self.records[0].prior.sd)
        return dict(zip(MUSCLE_NAMES, found, strict=True))

    @property
    def tension(self) -> dict[str, list[Tension]]:
        """Closing forces at the incisors as far as the first recording went (``tensions_of``); none if not believed."""
        if not self.believed:
            return {}
        if self.learnt is None:
            return tensions_of(self.records[0], self.log_mean, self.log_cov)
        record = replace(self.records[0], jaw=self.learnt.jaw)
        return tensions_of(record, self.log_mean, self.log_cov, self.learnt.joint)

    @property
    def enough(self) -> bool:
        """Whether all error bars are within 5 %: the recording may stop here."""
        return bool((self.log_sd <= ENOUGH).all())

    @property
    def at_the_priors_edge(self) -> list[str]:
        """Names of parameters whose estimate is beyond 2 sds of the prior: a patient whom the cohort hardly has."""
        prior = self.records[0].prior
        beyond = np.abs(self.log_mean - prior.mean) > TRUNCATION_SD * prior.sd
        return [name.removeprefix("log_") for name, far in zip(self.parameter_names, beyond, strict=True) if far]

    @property
    def beyond_the_prior(self) -> bool:
        """Whether an estimate is so far beyond the prior's edge that the prior holds it back."""
        prior = self.records[0].prior
        return bool((np.abs(self.log_mean - prior.mean) > BEYOND_SDS * prior.sd).any())

    @property
    def least_known(self) -> dict[str, Any]:
        """See `least_known`."""
        return least_known(self.records[0], self.whole)

    @property
    def assumed(self) -> str:
        """Patient, anatomy and head as they were assumed, in words."""
        return assumed_in_words(self.records[0])

    @property
    def agree(self) -> bool:
        """Whether all recordings can be of one patient."""
        return self.agreement is None or self.agreement.one_patient

    def __str__(self) -> str:
        lines = self._of_one() if self.agreement is None else self._of_several(self.agreement)
        return "\n".join([*lines, "", *(self._belief() if self.agree else [])])

    def _of_one(self) -> list[str]:
        record, result = self.records[0], self.whole
        word = alarm_word(result.misfit).replace("rings", "RINGS")
        fitted = result.rows - result.refused
        return [
            f"{self.paths[0]}: {record.time[-1]:g} s at {1.0 / record.dt:.3g} Hz",
            f"rows:    {result.rows:,} read, {fitted:,} fitted, {result.refused:,} refused by the filter's gate",
            f"numbers: {result.numbers:,} read, {result.left_out:,} left out (out of range, or repeated)",
            f"assumed: {self.assumed}",
            f"zero:    {self._zero()}",
            f"learnt:  {learnt_in_words(record, self.learnt)}",
            f"alarm:   {word}, misfit {result.misfit:.3g} (yellow above {YELLOW:g}, it rings above 1)",
        ]

    def _of_several(self, agreement: Agreement) -> list[str]:
        lines = []
        for path, record, one in zip(self.paths, self.records, self.each, strict=True):
            worst = f"largest error bar {one.estimate.sd[-1].max():.1%}"
            alarm = f"alarm {alarm_word(one.misfit)}, misfit {one.misfit:.3g}"
            lines.append(f"{path}: {record.time[-1]:g} s, {worst}; {alarm}")
        test = f"chi-squared {agreement.squares:.3g} of {agreement.degrees}, p {agreement.p:.2g}"
        said = "yes, all can be of one patient" if agreement.one_patient else "no"
        return [*lines, f"assumed: {self.assumed}", f"agree:   {said} ({test})"]

    def _zero(self) -> str:
        """Drift of the load cell's zero, in words."""
        changed = change_of_zero(self.records[0])
        seen = f"a drift is not seen: {UNSEEN_DRIFT}"
        if changed is not None:
            seen = f"changes by {changed:.2g} N until the end"
        drift = 0.0 if self.learnt is None else self.learnt.sizes["drift"]
        return f"{seen}; error bars allow for {drift:g} N over a third of the recording" if drift else seen

    def _belief(self) -> list[str]:
        """The estimates, what is least known of them, and the verdicts."""
        weakest, edge = self.least_known, self.at_the_priors_edge
        return [
            *([*in_words_of_tension(self.tension), ""] if self.believed else []),
            *self._estimates(),
            f"least known: {weakest['words']}, sd {weakest['sd']:.1%} (before: {weakest['prior_sd']:.0%})",
            f"enough recorded: {_enough_in_words(self.log_sd)}",
            *([f"at the edge of what was assumed: {', '.join(edge)}"] if edge else []),
            *self._muscles(),
        ]

    def _estimates(self) -> list[str]:
        truth = self.records[0].truth
        lines = [f"{'':32}{'estimate':>10}{'sd':>9}{'' if truth is None else 'truth':>9}".rstrip()]
        for symbol, title in _TITLES.items():
            lines.append(title)
            for i, name in enumerate(self.parameter_names):
                if name.startswith(f"log_{symbol}/"):
                    true = "" if truth is None else f"{np.exp(truth[i]):9.2f}"
                    value, sd = np.exp(self.log_mean[i]), 100.0 * self.log_sd[i]
                    lines.append(f"{name.removeprefix('log_'):32}{value:10.2f}{sd:7.1f} %{true}")
        return lines

    def _muscles(self) -> list[str]:
        """The verdict on every muscle, left beside right, with the ratio of their pulls."""
        found, mean, cov = self.verdicts, self.log_mean, self.log_cov
        if not found:
            return []
        lines = ["", f"{'':18}{'left':33}{'right':33}F_o left : right, 95 %"]
        for kind in dict.fromkeys(name.rsplit("_", 1)[0] for name in MUSCLE_NAMES):
            names = [f"{kind}_{side}" for side in ("left", "right")]
            words = [_in_words(found[name]) for name in names]
            pair = [2 * MUSCLE_NAMES.index(name) for name in names]
            ratio = mean[pair[0]] - mean[pair[1]]
            reach = _SD_95 * np.sqrt(np.array([1.0, -1.0]) @ cov[np.ix_(pair, pair)] @ np.array([1.0, -1.0]))
            low, high = np.exp(ratio - reach), np.exp(ratio + reach)
            lines.append(f"{kind:18}{words[0]:33}{words[1]:33}{np.exp(ratio):.3g} ({low:.3g} to {high:.3g})")
        return lines

    def reasons(self) -> list[str]:
        """Lines that say why the estimates are not to be believed, and what to do; tries other cohorts for it."""
        if self.agreement is None:
            return reasons(self.records[0], self.whole)
        lines = [] if self.agree else [f"- {self._disagreement()}"]
        pairs = zip(self.paths, self.each, strict=True)
        return [*lines, *(f"- {path}: {doubt}" for path, one in pairs for doubt in one.doubts)]

    def _disagreement(self) -> str:
        """The sentence that says which two recordings are not of one patient, and what differs most."""
        assert self.agreement is not None
        first, second = (self.paths[i] for i in self.agreement.pair)
        place = self.agreement.parameter
        values = [f"{np.exp(self.each[i].estimate.mean[-1][place]):.3g}" for i in self.agreement.pair]
        name = self.parameter_names[place].removeprefix("log_")
        return f"{first} and {second} are not of one patient in one state: {name} is {' and '.join(values)}"

    def mapping(self) -> dict[str, Any]:
        """The answer as a program reads it: text, numbers, lists and None alone."""
        record, result = self.records[0], self.whole
        tension = {
            name: {f"{one.opening_mm:g}_mm": one._asdict() for one in ones} for name, ones in self.tension.items()
        }
        learnt: dict[str, Any] | None = None
        if self.learnt is not None:
            late = None if self.learnt.joint is None else list(self.learnt.joint.late_s)
            others = {"temperature": self.learnt.temperature, "head_tilt_deg": tilt_of(self.learnt.jaw)}
            learnt = self.learnt.sizes | others | {"forces_late_s": late}
        answer: dict[str, Any] = {
            "parameter_names": list(self.parameter_names),
            "tension": tension,
            "log_mean": self.log_mean.tolist(),
            "log_cov": self.log_cov.tolist(),
            "prior_mean": record.prior.mean.tolist(),
            "prior_sd": record.prior.sd.tolist(),
            "believed": self.believed,
            "doubts": self.doubts,
            "misfit": result.misfit,
            "alarm": alarm_word(result.misfit),
            "enough": self.enough,
            "seconds": float(sum(each.time[-1] - each.time[0] for each in self.records)),
            "rows": result.rows,
            "refused": result.refused,
            "least_known": self.least_known,
            "at_the_priors_edge": self.at_the_priors_edge,
            "verdicts": {name: _plain(verdict) for name, verdict in self.verdicts.items()},
            "learnt": learnt,
            "assumed": {
                "cohort": cohort_assumed(record),
                "knowledge": {name: sd for name, sd in asdict(record.knowledge).items() if sd > 0.0},
                "head_tilt_deg": tilt_of(record.jaw),
                "mandible": size_in(record.jaw),
                "force_sensor": record.force_sensor,
            },
            "versions": package_versions(),
        }
        return answer if self.agreement is None else answer | self._mapping_of_several(self.agreement)

    def _mapping_of_several(self, agreement: Agreement) -> dict[str, Any]:
        said = {name: getattr(agreement, name) for name in ("one_patient", "degrees", "p")}
        parts = zip(self.paths, self.records, self.each, strict=True)
        alone = [Answer((path,), (record,), (one,), one, None, None) for path, record, one in parts]
        return {
            "agreement": said | {"chi_squared": agreement.squares, "least": [self.paths[i] for i in agreement.pair]},
            "recordings": [{"path": one.paths[0]} | one.mapping() for one in alone],
        }


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


def _enough_in_words(sd: Array) -> str:
    """Whether a recording may stop here."""
    wide = int((sd > ENOUGH).sum())
    if not wide:
        return f"yes, all {len(sd)} error bars are within {ENOUGH:.0%}"
    return f"no, {wide} of {len(sd)} error bars are above {ENOUGH:.0%}, the largest is {sd.max():.0%}"


def _in_words(verdict: Verdict) -> str:
    if verdict.word in (NO_VERDICT, *OPEN):
        return verdict.word
    return f"{verdict.word}, {'above 99.9' if verdict.probability > 0.999 else f'{100.0 * verdict.probability:.3g}'} %"


def _plain(verdict: Verdict) -> dict[str, Any]:
    """Word and probabilities, None where there are none."""
    return {name: None if value != value else value for name, value in asdict(verdict).items()}
