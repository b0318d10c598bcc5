"""Evaluations during a training: the table that they leave, and the best model."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.vec_env.base_vec_env import VecEnv

from jawenv.progress import Progress
from training.run.config import EvaluationConfig
from training.run.evaluate import Evaluation, evaluate
from training.run.evaluation_table import add_row, read_evaluations
from training.run.folder import RunFolder

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
    "discomfort_s",
    "information_claimed",
    "information_true",
    "violation",
    "length",
)
"""What is kept of an evaluation, as far as the environment tells it."""


class Score(NamedTuple):
    """How good a policy is; the larger the better.

    Attributes:
        comfortable: whether the discomfort is within the limit, if there is one.
        value: mean return; minus the discomfort of a policy that exceeds the limit.
    """

    comfortable: bool
    value: float

    def said(self) -> str:
        """The figure in words."""
        return f"mean return {self.value:.4g}" if self.comfortable else f"discomfort {abs(self.value):.4g} s"


class Evaluations(BaseCallback):
    """Tries the policy on the validation cohort every so many steps, and saves the best model.

    Each time it plays twice: with the most likely actions, which all figures but ``return_sampled`` are of, and with
    drawn ones. The first row of ``evaluations.csv`` is the untrained policy, the last the final one.

    Args:
        run: where the table and the best model go.
        config: how often, and on whom.
        worlds: one world per patient, for evaluation only.
        interrupted: an evaluation is given up when it says True.
        progress: shows the best so far.
        largest_discomfort_s: s per 30 s; a policy that exceeds it is worse than any that does not.
        report: is told steps and row of each evaluation.

    Attributes:
        last: steps of the latest row; None before the first.

    Raises:
        InputError: the table of a resumed run is damaged.
    """

    def __init__(
        self,
        run: RunFolder,
        config: EvaluationConfig,
        worlds: VecEnv,
        interrupted: Callable[[], bool],
        progress: Progress,
        largest_discomfort_s: float | None = None,
        report: Callable[[int, dict[str, float]], None] | None = None,
    ) -> None:
        super().__init__()
        self._run = run
        self._config = config
        self._worlds = worlds
        self._interrupted = interrupted
        self._progress = progress
        self._limit = largest_discomfort_s
        self._report = report
        self.best: tuple[Score, int] | None = None
        self.last: int | None = None
        for row in read_evaluations(run):
            self.last = int(row["steps"])
            self._compare(row)
        self._show_best()

    def _on_rollout_start(self) -> None:
        if self.last is None or self.model.num_timesteps - self.last >= self._config.every_steps:
            self.evaluate()

    def _on_step(self) -> bool:
        return True

    def _on_training_end(self) -> None:
        if self.last != self.model.num_timesteps and not self._interrupted():
            self.evaluate()

    def evaluate(self) -> None:
        """Evaluate now: add a row to the table, and save the model if it is the best."""
        self._progress.note("activity", "evaluating")
        outcome, sampled = self._play(deterministic=True), self._play(deterministic=False)
        self._progress.note("activity", "")
        if outcome is None or sampled is None:
            return
        self.last = self.model.num_timesteps
        figures = (
            outcome.averages()
            | outcome.intervals()
            | {
                "return_sampled": sampled.mean_return,
                "return_sd": float(outcome.figures["return"].std()),
            }
        )
        row = {name: figures[name] for name in COLUMNS if name in figures}
        # The row last: a run that is killed before it evaluates again, and saves the model again.
        if self._compare(figures | {"steps": self.last}):
            self._run.save_model(self.model, self._run.best_model)
            self._show_best()
        add_row(self._run, self.last, row)
        for name, value in row.items():
            self.logger.record(f"evaluation/{name}", value)
        self.logger.dump(self.last)
        if self._report is not None:
            self._report(self.last, row)

    def _play(self, deterministic: bool) -> Evaluation | None:
        return evaluate(self.model, self._worlds, self._config.seed, deterministic, self._interrupted)

    def _compare(self, row: dict[str, float]) -> bool:
        """Whether a row is the best so far; then it is kept as that."""
        score = self._score(row)
        if self.best is not None and score <= self.best[0]:
            return False
        self.best = (score, int(row["steps"]))
        return True

    def _score(self, row: dict[str, float]) -> Score:
        if self._limit is None or row.get("discomfort_s", 0.0) <= self._limit:
            return Score(True, row["return"])
        return Score(False, -row["discomfort_s"])

    def _show_best(self) -> None:
        if self.best is not None:
            self._progress.note("best", f"best evaluation: {self.best[0].said()} at {self.best[1]:,}")
