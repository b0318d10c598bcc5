"""Callbacks of the training: noise that falls, checkpoints, signals, logs, the price of discomfort.

Checkpoints and evaluations (`run.evaluations`) take place between a policy update and the next rollout, so that a
saved model, its number of steps and its score always belong together. stable-baselines3's own callbacks act within a
rollout, whose steps no update has learned from yet.
"""

from __future__ import annotations

import math
import signal
import threading
from types import FrameType, TracebackType
from typing import Any

import numpy as np
from stable_baselines3.common.callbacks import BaseCallback

from jawenv.base.progress import Progress
from training.run.config import ComfortConfig, TrainingConfig
from training.run.folder import RunFolder

LARGEST_EXCESS = 2.0
"""Largest discomfort over target, less 1, that counts in one update of its price."""


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


class Multiplier:
    """The price of discomfort under a limit, nats per s: a Lagrange multiplier that is learned beside the policy.

    Dual ascent on the logarithm, as for the multiplier of a constraint that must stay positive (Stooke et al. 2020,
    arXiv:2007.03964, has the same with more terms). Transitions in a replay buffer keep the price of their time.

    Attributes:
        value: the price now.
    """

    def __init__(self, config: ComfortConfig) -> None:
        self._config = config
        self.value = config.initial_multiplier

    def update(self, discomfort_s: float) -> None:
        """Dual ascent by the mean discomfort of some episodes, s per 30 s."""
        config = self._config
        excess = min(discomfort_s / config.target_discomfort_s - 1.0, LARGEST_EXCESS)
        self.value = min(self.value * math.exp(config.rate * excess), config.largest_multiplier)


class Upkeep(BaseCallback):
    """Everything beside learning but the evaluations.

    Args:
        config: of the run.
        run: where checkpoints go.
        interrupt: ends the learning at the next step; the steps of the unfinished rollout are then not counted.
        progress: is shown.
        multiplier: the price of discomfort; None where it is not learned.
    """

    def __init__(
        self,
        config: TrainingConfig,
        run: RunFolder,
        interrupt: Interrupt,
        progress: Progress,
        multiplier: Multiplier | None = None,
    ) -> None:
        super().__init__()
        self._config, self._run = config, run
        self._interrupt, self._progress, self._multiplier = interrupt, progress, multiplier
        self._discomfort: list[float] = []

    def _on_training_start(self) -> None:
        self._saved = self.model.num_timesteps
        self._keep_price()

    def _on_rollout_start(self) -> None:
        self._learned = self.model.num_timesteps
        self._lower_noise()
        if self._learned - self._saved >= self._config.checkpoints.every_steps:
            self._saved = self._learned
            self._run.save_checkpoint(self.model, self._config.checkpoints.keep)

    def _on_step(self) -> bool:
        if self._interrupt.wanted():
            self.model.num_timesteps = self._learned
            return False
        self._progress.advance_to(self.model.num_timesteps)
        if self._multiplier is not None:
            ended = [info["episode"] for info in self.locals["infos"] if "episode" in info]
            self._discomfort += [episode["discomfort_s"] for episode in ended]
        return True

    def _on_rollout_end(self) -> None:
        episodes = list(self.model.ep_info_buffer or ())
        if episodes:
            for key in episodes[0]:
                if key not in ("r", "l", "t"):  # stable-baselines3 logs these itself
                    mean = float(np.mean([episode[key] for episode in episodes]))
                    if np.isfinite(mean):  # whoever is never known has no time
                        self.logger.record(f"rollout/{key}", mean)
            self._progress.note("return", f"return {np.mean([episode['r'] for episode in episodes]):.4g}")
        comfort = self._config.comfort
        if self._multiplier is not None and comfort is not None and len(self._discomfort) >= comfort.episodes:
            mean = float(np.mean(self._discomfort))
            self._discomfort.clear()
            self._multiplier.update(mean)
            self._keep_price()
            self.logger.record("comfort/multiplier", self._multiplier.value)
            self.logger.record("comfort/discomfort_s", mean)

    def _lower_noise(self) -> None:
        """Set the logarithm of the actions' sd where it falls linearly over the run and is not learned."""
        first, last = self._config.network.initial_log_std, self._config.network.final_log_std
        if last is None:
            return
        log_std: Any = self.model.policy.log_std
        log_std.requires_grad_(False)
        log_std.fill_(first + min(1.0, self.model.num_timesteps / self._config.steps) * (last - first))

    def _keep_price(self) -> None:
        """Keep the price of discomfort as a plain attribute of the model, which is saved with it."""
        if self._multiplier is not None:
            self.model.comfort_multiplier = self._multiplier.value  # type: ignore[attr-defined]
