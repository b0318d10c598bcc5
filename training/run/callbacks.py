"""What happens beside learning: stopping on a signal, logging episodes, checkpoints, noise that falls, progress.

Checkpoints and evaluations (`run.evaluations`) take place between a policy update and the next rollout, so that a
saved model, its number of steps and its score always belong together.
"""

from __future__ import annotations

import signal
import threading
from types import FrameType, TracebackType
from typing import Any

import numpy as np
from stable_baselines3.common.callbacks import BaseCallback

from jawenv.progress import Progress
from training.run.algorithm_configs import NetworkConfig
from training.run.config import CheckpointConfig
from training.run.folder import RunFolder


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


class FallingNoise(BaseCallback):
    """Sets the logarithm of the actions' sd, which falls linearly over the run and is not learned.

    Args:
        network: says from where to where.
        steps: of the whole run.
    """

    def __init__(self, network: NetworkConfig, steps: int) -> None:
        super().__init__()
        assert network.final_log_std is not None
        self._first, self._last = network.initial_log_std, network.final_log_std
        self._steps = steps

    def _on_rollout_start(self) -> None:
        share = min(1.0, self.model.num_timesteps / self._steps)
        log_std: Any = self.model.policy.log_std
        log_std.requires_grad_(False)
        log_std.fill_(self._first + share * (self._last - self._first))

    def _on_step(self) -> bool:
        return True
