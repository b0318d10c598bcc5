"""What happens beside learning: stopping on a signal, logging episodes, checkpoints, evaluations, progress.

Checkpoints and evaluations take place between a policy update and the next rollout, so that a saved model,
its number of steps and its score always belong together.
"""

from __future__ import annotations

import csv
import signal
import threading
from types import FrameType, TracebackType
from typing import Any

import numpy as np
from stable_baselines3.common.callbacks import BaseCallback

from jawenv.errors import InputError
from jawenv.progress import Progress
from training.config import CheckpointConfig, EvaluationConfig
from training.evaluate import evaluate
from training.run import RunFolder
from training.vec_env import NativeVecEnv


class Interrupt:
    """Turns the first SIGINT or SIGTERM into a wish to stop; a second one raises KeyboardInterrupt.

    Does nothing outside the main thread, where Python allows no signal handlers.
    """

    def __init__(self) -> None:
        self.signal_name: str | None = None
        self._previous: dict[signal.Signals, Any] = {}

    def wanted(self) -> bool:
        """Whether a signal has come."""
        return self.signal_name is not None

    def __enter__(self) -> Interrupt:
        """Take over the two signals."""
        if threading.current_thread() is threading.main_thread():
            for number in (signal.SIGINT, signal.SIGTERM):
                self._previous[number] = signal.signal(number, self._handle)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Give the signals back."""
        for number, handler in self._previous.items():
            signal.signal(number, handler)

    def _handle(self, number: int, frame: FrameType | None) -> None:
        if self.wanted():
            raise KeyboardInterrupt
        self.signal_name = signal.Signals(number).name


class StopOnSignal(BaseCallback):
    """Ends the learning at the next step once a signal has come.

    The steps of the unfinished rollout are not counted: no update has learned from them.
    """

    def __init__(self, interrupt: Interrupt) -> None:
        super().__init__()
        self._interrupt = interrupt
        self._counted = 0

    def _on_rollout_start(self) -> None:
        self._counted = self.model.num_timesteps

    def _on_step(self) -> bool:
        if not self._interrupt.wanted():
            return True
        self.model.num_timesteps = self._counted
        return False


class EpisodeLog(BaseCallback):
    """Logs the mean figures of the latest training episodes, and shows progress."""

    def __init__(self, progress: Progress) -> None:
        super().__init__()
        self._progress = progress

    def _on_step(self) -> bool:
        self._progress.advance_to(self.model.num_timesteps)
        return True

    def _on_rollout_end(self) -> None:
        episodes = list(self.model.ep_info_buffer or ())
        if not episodes:
            return
        for key in episodes[0]:
            if key not in ("r", "l", "t"):  # stable-baselines3 logs these itself
                self.logger.record(f"rollout/{key}", float(np.mean([episode[key] for episode in episodes])))
        self._progress.note("return", f"return {np.mean([episode['r'] for episode in episodes]):.4g}")


class Checkpoints(BaseCallback):
    """Saves the model every so many steps."""

    def __init__(self, run: RunFolder, config: CheckpointConfig) -> None:
        super().__init__()
        self._run = run
        self._config = config
        self._last = 0

    def _on_training_start(self) -> None:
        self._last = self.model.num_timesteps

    def _on_rollout_start(self) -> None:
        if self.model.num_timesteps - self._last >= self._config.every_steps:
            self._last = self.model.num_timesteps
            self._run.save_checkpoint(self.model, self._config.keep)

    def _on_step(self) -> bool:
        return True


class Evaluations(BaseCallback):
    """Tries the deterministic policy on the validation cohort every so many steps, and saves the best model.

    The first row of ``evaluations.csv`` is the untrained policy, the last the final one.

    Args:
        run: where the table and the best model go.
        config: how often, and on whom.
        worlds: one world per patient, for evaluation only.
        interrupt: an evaluation is given up when the training is to stop.
        progress: shows the best so far.

    Raises:
        InputError: the table of a resumed run is damaged.
    """

    def __init__(
        self,
        run: RunFolder,
        config: EvaluationConfig,
        worlds: NativeVecEnv,
        interrupt: Interrupt,
        progress: Progress,
    ) -> None:
        super().__init__()
        self._run = run
        self._config = config
        self._worlds = worlds
        self._interrupt = interrupt
        self._progress = progress
        self.best: tuple[float, int] | None = None
        self._last: int | None = None
        for steps, mean_return in _read_evaluations(run):
            self._last = steps
            if self.best is None or mean_return > self.best[0]:
                self.best = (mean_return, steps)
        self._show_best()

    def _on_rollout_start(self) -> None:
        if self._last is None or self.model.num_timesteps - self._last >= self._config.every_steps:
            self._evaluate()

    def _on_step(self) -> bool:
        return True

    def _on_training_end(self) -> None:
        if self._last != self.model.num_timesteps and not self._interrupt.wanted():
            self._evaluate()

    def _evaluate(self) -> None:
        self._progress.note("activity", "evaluating")
        outcome = evaluate(self._act, self._worlds, self._config.seed, self._interrupt.wanted)
        self._progress.note("activity", "")
        if outcome is None:
            return
        steps, score = self.model.num_timesteps, outcome.mean_return
        self._last = steps
        if self.best is None or score > self.best[0]:
            self.best = (score, steps)
            self._run.save_model(self.model, self._run.best_model)
            self._show_best()
        row = outcome.means() | {"return_sd": float(outcome.figures["return"].std())}
        _append(self._run, steps, row)
        for name, value in row.items():
            self.logger.record(f"evaluation/{name}", value)
        self.logger.dump(steps)

    def _show_best(self) -> None:
        if self.best is not None:
            self._progress.note("best", f"best evaluation {self.best[0]:.4g} at {self.best[1]:,}")

    def _act(self, observation: np.ndarray) -> np.ndarray:
        return self.model.predict(observation, deterministic=True)[0]


def _append(run: RunFolder, steps: int, row: dict[str, float]) -> None:
    new = not run.evaluations.exists()
    with run.evaluations.open("a", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        if new:
            writer.writerow(["steps", *row])
        writer.writerow([steps, *(f"{value:.6g}" for value in row.values())])


def _read_evaluations(run: RunFolder) -> list[tuple[int, float]]:
    """Steps and mean return of the evaluations so far."""
    if not run.evaluations.exists():
        return []
    try:
        with run.evaluations.open(newline="", encoding="utf-8") as file:
            return [(int(row["steps"]), float(row["return"])) for row in csv.DictReader(file)]
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise InputError(f"{run.evaluations} is damaged: {' '.join(str(error).split())}") from error
