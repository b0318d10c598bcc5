"""One training run from start to end: PPO of stable-baselines3 on the native vector environment."""

from __future__ import annotations

import json
import pickle
import time
import zipfile
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import torch
from gymnasium.vector import VectorEnv
from rich.console import Console
from stable_baselines3 import PPO
from stable_baselines3.common.callbacks import BaseCallback, CallbackList
from stable_baselines3.common.logger import configure
from stable_baselines3.common.utils import LinearSchedule

from jawenv.errors import InputError
from jawenv.progress import Progress
from jawenv.seeds import TRAINING
from training.callbacks import Checkpoints, EpisodeLog, Evaluations, Interrupt, StopOnSignal
from training.config import EnvConfig, PPOConfig, TrainingConfig
from training.run import RunFolder
from training.vec_env import NativeVecEnv

INTERRUPTED = 130
"""Exit code of a run that was stopped by a signal, as shells report an interrupt."""

_DAMAGE = (
    zipfile.BadZipFile,
    pickle.UnpicklingError,
    OSError,
    EOFError,
    KeyError,
    TypeError,
    ValueError,
    RuntimeError,
)
"""What reading a damaged checkpoint can raise."""

ACTIVATIONS = {"tanh": torch.nn.Tanh, "relu": torch.nn.ReLU, "elu": torch.nn.ELU}


def start(config: TrainingConfig, run: RunFolder, console: Console, overwrite: bool = False) -> int:
    """Train from the beginning and leave everything in the run folder.

    Returns:
        The exit code: 0, or `INTERRUPTED`.

    Raises:
        InputError: the folder is taken, or the environment refuses its arguments.
    """
    run.check_free(overwrite)
    with _Session(config, console, from_step=0) as session:
        run.create(config, session.env_spec, session.world_seed)
        return session.learn(run)


def resume(run: RunFolder, console: Console, steps: int | None = None) -> int:
    """Continue a run from its latest checkpoint: model, optimiser and number of steps.

    The patients that follow are new ones, so a resumed run is not bit for bit the uninterrupted one.

    Args:
        run: the folder.
        console: where to report.
        steps: new end of the run, in steps from its beginning; None keeps the old one.

    Returns:
        The exit code: 0, or `INTERRUPTED`.

    Raises:
        InputError: there is no run, or its latest checkpoint is damaged.
    """
    config = run.open().changed(steps=steps)
    checkpoint = run.latest_checkpoint()
    from_step = 0 if checkpoint is None else _steps_of(checkpoint)
    if from_step >= config.steps:
        console.print(
            f"{run.path} already has {from_step:,} of {config.steps:,} steps; nothing to do "
            "(--steps with a larger number goes on)"
        )
        return 0
    with _Session(config, console, from_step) as session:
        if checkpoint is not None:
            session.restore(checkpoint)
        run.add_session(config, from_step, session.world_seed)
        return session.learn(run)


class _Session:
    """Environments and model of one process that trains, from ``from_step`` to ``config.steps``."""

    def __init__(self, config: TrainingConfig, console: Console, from_step: int) -> None:
        self._config = config
        self._console = console
        self._from_step = from_step
        self.world_seed = world_seed(config.seed, from_step)
        torch.set_num_threads(config.torch_threads)
        console.print(f"preparing {config.n_envs} worlds of {config.env.id}")
        env = make_worlds(config.env, config.n_envs)
        self.env_spec = _spec_json(env, config.env)
        self._worlds = NativeVecEnv(env)
        self._validation = NativeVecEnv(make_worlds(config.env, config.evaluation.patients))
        self._model = make_model(config, self._worlds)
        self._worlds.seed(self.world_seed)

    def __enter__(self) -> _Session:
        return self

    def __exit__(self, *exception: object) -> None:
        self._worlds.close()
        self._validation.close()

    def restore(self, checkpoint: Path) -> None:
        """Take over weights, optimiser state and counters of a checkpoint."""
        try:
            self._model.set_parameters(str(checkpoint), device=self._config.device)
            counters = _saved_counters(checkpoint)
        except _DAMAGE as error:
            raise _damaged(checkpoint, error) from error
        self._model.num_timesteps, self._model._n_updates = counters

    def learn(self, run: RunFolder) -> int:
        """Learn until the last step or a signal; save, report, and return the exit code."""
        config, model = self._config, self._model
        model.set_logger(configure(str(run.tensorboard), ["tensorboard"]))
        begun = time.monotonic()
        interrupt = Interrupt()
        try:
            with interrupt, Progress(config.steps, "steps", self._console, self._from_step) as progress:
                evaluations = Evaluations(run, config.evaluation, self._validation, interrupt, progress)
                callbacks: list[BaseCallback] = [StopOnSignal(interrupt), EpisodeLog(progress)]
                callbacks += [Checkpoints(run, config.checkpoints), evaluations]
                model.learn(config.steps - self._from_step, CallbackList(callbacks), reset_num_timesteps=False)
                checkpoint = run.save_checkpoint(model, config.checkpoints.keep)
        except KeyboardInterrupt:
            self._console.print(f"stopped at once; --resume {run.path} goes on from the latest checkpoint")
            return INTERRUPTED
        finally:
            model.logger.close()
        if model.num_timesteps < config.steps:
            self._console.print(
                f"stopped by {interrupt.signal_name}, {model.num_timesteps:,} of {config.steps:,} steps; "
                f"saved {checkpoint}; go on with python -m training train ppo --resume {run.path}",
                soft_wrap=True,
            )
            return INTERRUPTED
        run.save_model(model, run.final_model)
        self._report(run, evaluations, time.monotonic() - begun)
        return 0

    def _report(self, run: RunFolder, evaluations: Evaluations, seconds: float) -> None:
        steps = self._model.num_timesteps
        rate = (steps - self._from_step) / seconds
        assert evaluations.best is not None
        score, best_steps = evaluations.best
        patients = self._config.evaluation.patients
        self._console.print(
            f"{steps:,} steps in {seconds:.0f} s ({rate:,.0f} steps/s with evaluations); best mean return on "
            f"{patients} validation patients {score:.4g} after {best_steps:,} steps: {run.best_model}",
            soft_wrap=True,
        )


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


def make_model(config: TrainingConfig, worlds: NativeVecEnv) -> PPO:
    """The untrained model that the configuration describes.

    Raises:
        InputError: the device does not exist.
    """
    ppo: PPOConfig = config.ppo
    return PPO(
        "MlpPolicy",
        worlds,
        learning_rate=LinearSchedule(ppo.learning_rate.initial, ppo.learning_rate.final, 1.0),
        n_steps=ppo.n_steps,
        batch_size=ppo.batch_size,
        n_epochs=ppo.n_epochs,
        gamma=ppo.gamma,
        gae_lambda=ppo.gae_lambda,
        clip_range=ppo.clip_range,
        ent_coef=ppo.ent_coef,
        vf_coef=ppo.vf_coef,
        max_grad_norm=ppo.max_grad_norm,
        target_kl=ppo.target_kl,
        stats_window_size=worlds.num_envs,
        policy_kwargs={
            "net_arch": {"pi": list(ppo.network.policy), "vf": list(ppo.network.value)},
            "activation_fn": ACTIVATIONS[ppo.network.activation],
            "log_std_init": ppo.network.initial_log_std,
        },
        device=_device(config.device),
        seed=config.seed,
    )


def world_seed(seed: int, from_step: int) -> int:
    """Seed of the first training world; a resumed run gets another one, and so new patients."""
    return TRAINING.start + int(np.random.SeedSequence([seed, from_step]).generate_state(1)[0] % 2**30)


def _device(name: str) -> torch.device:
    try:
        device = torch.device(name)
        torch.zeros(1, device=device)
    except (RuntimeError, AssertionError, NotImplementedError) as error:
        reason = str(error).splitlines()[0]
        raise InputError(f"device {name!r} cannot be used: {reason}; 'cpu' always can") from error
    return device


def _spec_json(env: VectorEnv, config: EnvConfig) -> str:
    try:
        if env.spec is not None:
            return env.spec.to_json()
    except ValueError:  # registered with a class instead of its name, which Gymnasium does not serialise
        pass
    return json.dumps({"id": config.id, "kwargs": config.kwargs})


def _saved_counters(checkpoint: Path) -> tuple[int, int]:
    """Steps and updates that a checkpoint has behind it."""
    with zipfile.ZipFile(checkpoint) as archive:
        data = json.loads(archive.read("data"))
    return int(data["num_timesteps"]), int(data["_n_updates"])


def _steps_of(checkpoint: Path) -> int:
    try:
        return _saved_counters(checkpoint)[0]
    except _DAMAGE as error:
        raise _damaged(checkpoint, error) from error


def _damaged(checkpoint: Path, error: Exception) -> InputError:
    reason = " ".join(str(error).split())[:200] or type(error).__name__
    return InputError(f"checkpoint {checkpoint} is damaged ({reason}); delete it to go on from the one before it")
