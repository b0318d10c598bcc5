"""One training run from start to end: an algorithm of stable-baselines3 on the native vector environment."""

from __future__ import annotations

import json
import pickle
import time
import zipfile
import zlib
from collections.abc import Callable
from operator import attrgetter
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import torch
from gymnasium.vector import VectorEnv
from rich.console import Console
from stable_baselines3.common.callbacks import BaseCallback, CallbackList
from stable_baselines3.common.logger import configure
from stable_baselines3.common.on_policy_algorithm import OnPolicyAlgorithm
from stable_baselines3.common.save_util import load_from_zip_file
from stable_baselines3.common.vec_env.base_vec_env import VecEnv

from agents.checkpoints import read_data
from agents.controller import ControlledWorlds
from agents.following import TargetsLaw, decision_hz
from agents.residual import BaseTargets
from jawenv.controls import mode_of
from jawenv.errors import InputError
from jawenv.locks import alone
from jawenv.progress import Progress
from jawenv.seeds import TRAINING
from training.run.algorithm_configs import PPOConfig, SACConfig
from training.run.algorithms import make_model
from training.run.callbacks import Checkpoints, EpisodeLog, FallingNoise, Interrupt, StopOnSignal
from training.run.comfort import Multiplier, MultiplierUpdates
from training.run.config import EnvConfig, TrainingConfig
from training.run.evaluations import Evaluations
from training.run.folder import RunFolder
from training.run.vec_env import NativeVecEnv

INTERRUPTED = 130
"""Exit code of a run that was stopped by a signal, as shells report an interrupt."""

_DAMAGE = (
    zipfile.BadZipFile,
    zlib.error,
    pickle.UnpicklingError,
    OSError,
    EOFError,
    KeyError,
    TypeError,
    ValueError,
    RuntimeError,
)
"""What reading a damaged checkpoint can raise."""

Report = Callable[[int, dict[str, float]], None]
"""Is told steps and row of each evaluation."""


def start(
    config: TrainingConfig, run: RunFolder, console: Console, overwrite: bool = False, report: Report | None = None
) -> int:
    """Train from the beginning and leave everything in the run folder.

    Returns:
        The exit code: 0, or `INTERRUPTED`.

    Raises:
        InputError: the folder is taken or in use, there is no such maneuver, or the environment refuses its arguments.
    """
    with alone(run.path):
        run.check_free(overwrite)
        base = base_targets(config)
        with Session(config, console, 0, base) as session:
            run.create(config, session.env_spec, session.world_seed, None if base is None else base.maneuver)
            return session.learn(run, report)


def resume(run: RunFolder, console: Console, steps: int | None = None) -> int:
    """Continue a run from its latest checkpoint: model, optimisers, multiplier and number of steps.

    The patients that follow are new ones, so a resumed run is not bit for bit the uninterrupted one. A replay buffer is
    not kept: it is filled by ``learning_starts`` random actions, as at the start, before the learning goes on.

    Args:
        run: the folder.
        console: where to report.
        steps: new end of the run, in steps from its beginning; None keeps the old one.

    Returns:
        The exit code: 0, or `INTERRUPTED`.

    Raises:
        InputError: there is no run, it is in use, or its latest checkpoint is damaged.
    """
    config = run.open().changed(steps=steps)
    with alone(run.path):
        run.remove_unfinished()
        checkpoint = run.latest_checkpoint()
        from_step = 0 if checkpoint is None else int(_saved(checkpoint)["num_timesteps"])
        if from_step >= config.steps and run.final_model.exists():
            console.print(
                f"{run.path} already has {from_step:,} of {config.steps:,} steps; nothing to do "
                "(--steps with a larger number goes on)"
            )
            return 0
        with Session(config, console, from_step, base_targets(config, run.path)) as session:
            if checkpoint is not None:
                session.restore(checkpoint)
            run.add_session(config, from_step, session.world_seed)
            return session.learn(run)


def base_targets(config: TrainingConfig, folder: Path | None = None) -> BaseTargets | None:
    """The maneuver that the policy corrects, None if it corrects none; a run's folder holds a copy of it.

    Raises:
        InputError: no such maneuver.
    """
    if config.residual is None:
        return None
    return BaseTargets(config.residual.load_maneuver(folder), config.residual.scale, decision_hz(config.env.kwargs))


class Session:
    """Environments and model of one process that trains, from ``from_step`` to ``config.steps``.

    Attributes:
        config: as given.
        base: as given; the maneuver that is corrected.
        model: the algorithm, untrained.
        world_seed: of the first training world.
        env_spec: specification of the environment, as JSON.
    """

    def __init__(self, config: TrainingConfig, console: Console, from_step: int, base: BaseTargets | None) -> None:
        self.config, self.base = config, base
        self._console = console
        self._from_step = from_step
        self.world_seed = world_seed(config.seed, from_step)
        torch.set_num_threads(config.torch_threads)
        if config.env.id.startswith("jawenv/"):
            mode_of(config.env.kwargs)  # refuses an unknown control mode before worlds are made
        console.print(f"preparing {config.n_envs} worlds of {config.env.id}")
        env = make_worlds(config.env, config.n_envs)
        self.env_spec = _spec_json(env, config.env)
        self._multiplier = None if config.comfort is None else Multiplier(config.comfort)
        law = None if base is None else _law(config.env, base)
        self._worlds = wrapped(env, base, law, self._multiplier)
        self._validation = wrapped(make_worlds(config.env, config.evaluation.patients), base, law)
        self.model = make_model(config, self._worlds)
        self._worlds.seed(self.world_seed)

    def __enter__(self) -> Session:
        return self

    def __exit__(self, *exception: object) -> None:
        self._worlds.close()
        self._validation.close()

    def restore(self, checkpoint: Path) -> None:
        """Take over weights, optimiser state, counters and multiplier of a checkpoint."""
        model: Any = self.model
        try:
            model.set_parameters(str(checkpoint), device=self.config.device)
            _, _, variables = load_from_zip_file(str(checkpoint), device=self.config.device, load_data=False)
            for name, value in (variables or {}).items():
                if value is not None:
                    attrgetter(name)(model).data.copy_(value.data)
            saved = _saved(checkpoint)
            model.num_timesteps, model._n_updates = int(saved["num_timesteps"]), int(saved["_n_updates"])
            if self._multiplier is not None:
                self._multiplier.value = float(saved["comfort_multiplier"])
        except _DAMAGE as error:
            raise _damaged(checkpoint, error) from error
        section = self.config.section
        if isinstance(section, SACConfig):
            model.learning_starts = model.num_timesteps + section.learning_starts

    def learn(self, run: RunFolder, report: Report | None = None) -> int:
        """Learn until the last step or a signal; save, report, and return the exit code."""
        config, model = self.config, self.model
        total = _whole_updates(model, self._from_step, config.steps)
        if total != config.steps:
            self._console.print(
                f"{config.steps:,} steps end within an update: {total:,} are trained, the end of that update",
                soft_wrap=True,
            )
        model.set_logger(configure(str(run.tensorboard), ["tensorboard"]))
        begun = time.monotonic()
        interrupt = Interrupt()
        try:
            with interrupt, Progress(total, "steps", self._console, self._from_step) as progress:
                evaluations = self.evaluations(run, progress, interrupt.wanted, report)
                callbacks = [StopOnSignal(interrupt), EpisodeLog(progress), *self._special_callbacks()]
                callbacks += [Checkpoints(run, config.checkpoints), evaluations]
                # On-policy algorithms log every rollout, the others after so many episodes.
                log_interval = config.n_envs if isinstance(config.section, SACConfig) else 1
                model.learn(
                    config.steps - self._from_step,
                    CallbackList(callbacks),
                    log_interval=log_interval,
                    reset_num_timesteps=False,
                )
                checkpoint = run.save_checkpoint(model, config.checkpoints.keep)
        except KeyboardInterrupt:
            self._console.print(f"stopped at once; --resume {run.path} goes on from the latest checkpoint")
            return INTERRUPTED
        finally:
            model.logger.close()
        if model.num_timesteps < config.steps:
            self._console.print(
                f"stopped by {interrupt.signal_name}, {model.num_timesteps:,} of {config.steps:,} steps; "
                f"saved {checkpoint}; go on with python -m training train --resume {run.path}",
                soft_wrap=True,
            )
            return INTERRUPTED
        run.save_model(model, run.final_model)
        self._report(run, evaluations, time.monotonic() - begun)
        return 0

    def _special_callbacks(self) -> list[BaseCallback]:
        """What only some configurations ask for."""
        config = self.config
        callbacks: list[BaseCallback] = []
        if isinstance(config.section, PPOConfig) and config.section.network.final_log_std is not None:
            callbacks.append(FallingNoise(config.section.network, config.steps))
        if self._multiplier is not None and config.comfort is not None:
            callbacks.append(MultiplierUpdates(self._multiplier, config.comfort.episodes))
        return callbacks

    def evaluations(
        self,
        run: RunFolder,
        progress: Progress,
        interrupted: Callable[[], bool] = lambda: False,
        report: Report | None = None,
    ) -> Evaluations:
        """Evaluations on the validation patients, which keep the best model in the run's folder."""
        comfort = self.config.comfort
        limit = None if comfort is None else comfort.target_discomfort_s
        return Evaluations(run, self.config.evaluation, self._validation, interrupted, progress, limit, report)

    def _report(self, run: RunFolder, evaluations: Evaluations, seconds: float) -> None:
        steps = self.model.num_timesteps
        rate = (steps - self._from_step) / seconds
        assert evaluations.best is not None
        score, best_steps = evaluations.best
        self._console.print(
            f"{steps:,} steps in {seconds:.0f} s ({rate:,.0f} steps/s with evaluations); best on "
            f"{self.config.evaluation.patients} validation patients: {score.said()} "
            f"after {best_steps:,} steps: {run.best_model}",
            soft_wrap=True,
        )


def _whole_updates(model: Any, from_step: int, steps: int) -> int:
    """Where a run ends that is to have so many steps: stable-baselines3 steps all worlds before each update."""
    update: int = model.n_envs * (model.n_steps if isinstance(model, OnPolicyAlgorithm) else 1)
    return from_step + -(-(steps - from_step) // update) * update


def _law(config: EnvConfig, base: BaseTargets) -> TargetsLaw | None:
    """What follows a policy's targets; None where the device does.

    Raises:
        InputError: the environment's control steps do not fit the policy's decisions.
    """
    kwargs: dict[str, Any] = config.kwargs
    mode = mode_of(kwargs)
    if mode.takes_targets:
        return None
    return TargetsLaw(mode.name, kwargs.get("control_hz"), base.decision_hz)


def wrapped(
    env: VectorEnv,
    base: BaseTargets | None = None,
    law: TargetsLaw | None = None,
    multiplier: Multiplier | None = None,
) -> VecEnv:
    """Worlds for stable-baselines3: with the price of discomfort, and with the maneuver that is corrected."""
    for controller in (law, base):
        if controller is not None:
            env = ControlledWorlds(env, controller)
    return NativeVecEnv(env, multiplier)


def make_worlds(config: EnvConfig, n: int) -> VectorEnv:
    """N worlds of the environment in its native vector form, reset in the step that ends an episode.

    Raises:
        InputError: no such environment, no native vector form, or arguments that it refuses.
    """
    import jawenv  # noqa: F401  registers its environments

    kwargs: dict[str, Any] = {"autoreset_mode": "same_step", **config.kwargs}
    try:
        return gym.make_vec(config.id, n, vectorization_mode="vector_entry_point", **kwargs)
    except (gym.error.Error, ModuleNotFoundError) as error:
        raise InputError(f"env.id {config.id!r}: {' '.join(str(error).split())}") from error
    except TypeError as error:
        raise InputError(f"env.kwargs {config.kwargs} of {config.id}: {error}") from error


def world_seed(seed: int, from_step: int) -> int:
    """Seed of the first training world; a resumed run gets another one, and so new patients."""
    return TRAINING.start + int(np.random.SeedSequence([seed, from_step]).generate_state(1)[0] % 2**30)


def _spec_json(env: VectorEnv, config: EnvConfig) -> str:
    try:
        if env.spec is not None:
            return env.spec.to_json()
    except ValueError:  # registered with a class instead of its name, which Gymnasium does not serialise
        pass
    return json.dumps({"id": config.id, "kwargs": config.kwargs})


def _saved(checkpoint: Path) -> dict[str, Any]:
    """What a checkpoint says in plain text, among it its steps and updates.

    Raises:
        InputError: the checkpoint is damaged.
    """
    try:
        data = read_data(checkpoint)
        int(data["num_timesteps"]), int(data["_n_updates"])
    except _DAMAGE as error:
        raise _damaged(checkpoint, error) from error
    return data


def _damaged(checkpoint: Path, error: Exception) -> InputError:
    told = " ".join(str(error).split()).removeprefix(f"{checkpoint}: damaged stable-baselines3 checkpoint: ")
    reason = told[:200] or type(error).__name__
    return InputError(f"checkpoint {checkpoint} is damaged ({reason}); delete it to go on from the one before it")
