"""Evaluation of a policy on a fixed cohort of patients, again and again during a training; the best is kept."""

from __future__ import annotations

import csv
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from scipy.stats import binom
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.vec_env.base_vec_env import VecEnv

from agents.evaluations import read_evaluations
from jawenv.base.progress import Progress
from jawenv.base.reading import read_text
from jawenv.sb3 import KNOWN
from training.run.config import EvaluationConfig
from training.run.folder import RunFolder

CONFIDENCE = 0.95
_BEGINNING = "the movement that it begins with"
MEDIANS = ("worst_sd", "worst_sd_10s", "known_s")
"""Figures by the median over patients, since a few stiff patients would rule the mean."""
COLUMNS = (
    "return",
    "return_sampled",
    "return_sd",
    "worst_sd",
    "worst_sd_low",
    "worst_sd_high",
    "worst_sd_10s",
    "worst_sd_10s_low",
    "worst_sd_10s_high",
    "known_s",
    "discomfort_s",
    "information_claimed",
    "information_true",
    "violation",
    "length",
)
"""Figures of an evaluation, as far as the environment reports them."""

Row = dict[str, float]
"""Figures of one evaluation by their column, with ``steps``."""


@dataclass(frozen=True)
class Evaluation:
    """Outcome of one episode per patient: every figure is an array (N,), among them ``return``."""

    figures: dict[str, np.ndarray]

    def averages(self) -> dict[str, float]:
        """Mean of every figure over the patients; of `MEDIANS` the median, with the ends of its 95 % interval.

        These are called ``worst_sd_low`` and ``worst_sd_high``. They are order statistics, so that nothing is assumed
        about the patients (David & Nagaraja 2003, section 7.1).
        """
        averages = {name: float(values.mean()) for name, values in self.figures.items()}
        for name in self.figures.keys() & set(MEDIANS):
            values = np.sort(self.figures[name])
            cut = max(int(binom.ppf((1.0 - CONFIDENCE) / 2.0, len(values), 0.5)) - 1, 0)
            ends = {f"{name}_low": float(values[cut]), f"{name}_high": float(values[-1 - cut])}
            averages |= {name: float(np.median(values)), **ends}
        return averages


def evaluate(
    policy: Any,
    worlds: VecEnv,
    seed: int,
    deterministic: bool = True,
    stopped: Callable[[], bool] = lambda: False,
) -> Evaluation | None:
    """Play one episode in each of the N worlds, started from seed, seed + 1, ..., seed + N - 1.

    A world that ends early starts another episode, which is not counted.

    Args:
        policy: chooses the actions, a model of stable-baselines3 or an agent.
        worlds: N worlds used for nothing else, so that the training's own are left alone.
        seed: of the first world.
        deterministic: whether the policy's most likely actions are taken, or drawn ones.
        stopped: asked at every step; the evaluation is given up when it says True.

    Returns:
        The outcome, or None when it was given up.
    """
    worlds.seed(seed)
    observation = worlds.reset()
    memory, starts = None, np.ones(worlds.num_envs, dtype=bool)
    episodes: dict[int, dict[str, float]] = {}
    while len(episodes) < worlds.num_envs:
        if stopped():
            return None
        actions, memory = policy.predict(np.asarray(observation), memory, starts, deterministic)
        observation, _, starts, infos = worlds.step(actions)
        for i in np.flatnonzero(starts).tolist():
            episodes.setdefault(i, infos[i]["episode"])
    finished = [episodes[i] for i in range(worlds.num_envs)]
    names = {"r": "return", "l": "length"} | {key: key for key in finished[0] if key not in ("r", "l", "t")}
    return Evaluation({name: np.array([episode[key] for episode in finished]) for key, name in names.items()})


class _PolicyScore(NamedTuple):
    """Score of a policy; the larger the better."""

    comfortable: bool  # whether the discomfort is within the limit, if there is one
    value: float  # mean return; minus the discomfort of a policy that exceeds the limit


class Evaluations(BaseCallback):
    """Tries the policy on the validation cohort every so many steps, and keeps the best one.

    Each time it plays twice: with the most likely actions, which all figures but ``return_sampled`` are of, and with
    drawn ones. The first row of ``evaluations.csv`` is the untrained policy, the last one the final policy. The first
    rows follow each other sooner: at an eighth of ``every_steps``, a quarter and a half.

    Args:
        run: where the table goes.
        config: how often, and on whom.
        worlds: one world per patient, for evaluation only.
        keep: writes the policy as it is now, as the run's best.
        progress: shows the best so far.
        interrupted: an evaluation is given up when it says True.
        largest_discomfort_s: s per 30 s; a policy that exceeds it is worse than any that does not.
        sampled: whether it also plays with drawn actions, as an algorithm learns from.

    Attributes:
        best: row of the best policy; None before the first row.
        last: steps of the latest row; None before the first.
        limit_s: as ``largest_discomfort_s``.
    """

    def __init__(
        self,
        run: RunFolder,
        config: EvaluationConfig,
        worlds: VecEnv,
        keep: Callable[[], None],
        progress: Progress,
        *,
        interrupted: Callable[[], bool] = lambda: False,
        largest_discomfort_s: float | None = None,
        sampled: bool = True,
    ) -> None:
        super().__init__()
        self._sampled = sampled
        self._run, self._config, self._worlds, self._keep = run, config, worlds, keep
        self._progress, self._interrupted = progress, interrupted
        self.limit_s = largest_discomfort_s
        self.best: Row | None = None
        self._first: Row | None = None
        self.last: int | None = None
        for row in read_evaluations(run.path):
            self.last = int(row["steps"])
            self._compare(row)
        if not run.has_policy():  # killed while it kept its best
            self.best = None
        self._show_best()

    def _on_rollout_start(self) -> None:
        every = self._config.every_steps
        if self.last is None:
            self._progress.say(f"evaluating {_BEGINNING} on {self._worlds.num_envs} patients")
            self.evaluate()
        elif self.model.num_timesteps - self.last >= min(max(self.last, every / 8), every):
            self.evaluate()

    def _on_step(self) -> bool:
        return True

    def _on_training_end(self) -> None:
        if self.last != self.model.num_timesteps and not self._interrupted():
            self.evaluate()

    def evaluate(self) -> None:
        """Evaluate now: add a row to the table, and keep the policy if it is the best."""
        self._progress.note("activity", "evaluating")
        kinds = (True, False) if self._sampled else (True,)
        played = [evaluate(self.model, self._worlds, self._config.seed, likely, self._interrupted) for likely in kinds]
        self._progress.note("activity", "")
        outcome, sampled = played[0], played[-1]
        if outcome is None or sampled is None:
            return
        self.last = self.model.num_timesteps
        figures = outcome.averages() | {
            "return_sampled": float(sampled.figures["return"].mean()),
            "return_sd": float(outcome.figures["return"].std()),
        }
        row = {name: figures[name] for name in COLUMNS if name in figures}
        begun = _BEGINNING if self._first is None else f"after {self.last:,} steps"
        self._progress.say(f"{begun}, {self._worlds.num_envs} patients: {in_words(row, self.limit_s)}")
        # The row last: a run that is killed before it evaluates again, and keeps the policy again.
        if self._compare({**row, "steps": self.last}):
            self._keep()
            self._show_best()
        self._add(row)
        for name, value in row.items():
            self.logger.record(f"evaluation/{name}", value)
        self.logger.dump(self.last)

    def _compare(self, row: Row) -> bool:
        """Whether a row is the best so far; then it is kept as that."""
        self._first = self._first or row
        better = self.best is None or self._score(row) > self._score(self.best)
        if better:
            self.best = row
        return better

    def _score(self, row: Row) -> _PolicyScore:
        gain, discomfort = row.get("return", 0.0), row.get("discomfort_s", 0.0)
        if self.limit_s is not None and discomfort > self.limit_s:
            return _PolicyScore(False, -discomfort)
        return _PolicyScore(True, gain)

    def _add(self, row: dict[str, float]) -> None:
        """Add a row to the table, which keeps its columns when a run goes on."""
        path = self._run.evaluations
        new = not path.exists()
        names = ["steps", *row] if new else read_text(path).partition("\n")[0].strip().split(",")
        with path.open("a", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, names, extrasaction="ignore")
            if new:
                writer.writeheader()
            writer.writerow({"steps": self.last} | {name: f"{value:.6g}" for name, value in row.items()})

    def _show_best(self) -> None:
        if self.best is not None and self._first is not None and self.best["steps"]:
            self._progress.note("best", f"best: {in_words(self.best)}; at the beginning: {in_words(self._first)}")


def in_words(row: Row, limit_s: float | None = None) -> str:
    """The figures of a row that a reader compares, medians over patients; the return where there is none of them."""
    known = row.get("known_s", math.inf)
    words = {
        "worst_sd": f"worst error bar {100.0 * row.get('worst_sd', 0.0):.3g} %",
        "known_s": f"all within {100.0 * KNOWN:g} % " + (f"after {known:.2g} s" if math.isfinite(known) else "never"),
        "discomfort_s": f"discomfort {row.get('discomfort_s', 0.0):.2g} s in 30 s",
    }
    if limit_s is not None and row.get("discomfort_s", 0.0) > limit_s:
        words["discomfort_s"] += f", above the {limit_s:g} s allowed (--target-discomfort)"
    return ", ".join(text for name, text in words.items() if name in row) or f"return {row['return']:.4g}"
