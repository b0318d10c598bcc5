"""One training run from start to end: an algorithm of stable-baselines3 on the native vector environment."""

from __future__ import annotations

import time
from operator import attrgetter
from pathlib import Path
from typing import Any

import torch
from rich.console import Console
from stable_baselines3.common.callbacks import CallbackList
from stable_baselines3.common.logger import configure
from stable_baselines3.common.off_policy_algorithm import OffPolicyAlgorithm
from stable_baselines3.common.on_policy_algorithm import OnPolicyAlgorithm
from stable_baselines3.common.save_util import load_from_zip_file

from agents.without_card import plays_in
from jawenv.base.errors import InputError
from jawenv.base.locks import alone
from jawenv.base.progress import Progress
from jawenv.envs.configuration import Configuration
from jawenv.playing.policies.card import CorrectedManeuver, Environment
from jawenv.playing.policies.following import decision_hz
from jawenv.playing.policies.residual import BaseTargets
from training.run.algorithms import make_model, plain_policy
from training.run.best_policy import write_run_policy
from training.run.callbacks import Interrupt, Multiplier, Upkeep
from training.run.config import EnvConfig, TrainingConfig
from training.run.evaluations import Evaluations, in_words
from training.run.folder import RunFolder, damaged, read_counts
from training.run.pathwise import APG
from training.run.worlds import world_seed, worlds_for

PRICED = 16
"""Patients of an update of `APG` that the worlds play too, for the price of discomfort."""
INTERRUPTED = 130
"""Exit code of a run that was stopped by a signal, as shells report an interrupt."""
_TASK = ("algorithm", "env", "residual", "network")


def start(config: TrainingConfig, run: RunFolder, console: Console, overwrite: bool = False) -> int:
    """Train from the beginning and leave everything in the run folder.

    Returns:
        The exit code: 0, or `INTERRUPTED`.
    """
    with alone(run.path):
        run.check_free(overwrite)
        base = base_targets(config)
        with TrainingSession(config, run, console, 0, base) as session:
            run.create(config, session.world_seed, None if base is None else base.maneuver)
            return session.learn()


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
    """
    config = run.open().changed(steps=steps)
    with alone(run.path):
        _check_changes(run, config, console)
        run.remove_unfinished()
        checkpoint = run.latest_checkpoint()
        from_step = 0 if checkpoint is None else int(read_counts(checkpoint)["num_timesteps"])
        if from_step >= config.steps:
            console.print(
                f"{run.path} already has {from_step:,} of {config.steps:,} steps; nothing to do "
                "(--steps with a larger number goes on)"
            )
            return 0
        with TrainingSession(config, run, console, from_step, base_targets(config, run.path)) as session:
            if checkpoint is not None:
                session.restore(checkpoint)
            run.add_session(config, from_step, session.world_seed)
            return session.learn()


def _check_changes(run: RunFolder, config: TrainingConfig, console: Console) -> None:
    """Say which settings were changed since the run began; refuse another task or network."""
    changed = [name for name in run.changed_settings(config) if name != "steps"]
    decisive = [name for name in changed if name.split(".")[0] in _TASK or "policy_kwargs" in name]
    if decisive:
        raise InputError(
            f"{run.config_file} has other values of {', '.join(decisive)} than the run began with; "
            f"allowed: those in {run.repeat_file}, or a new run: train {run.config_file} --output FOLDER"
        )
    if changed:
        console.print(f"changed since the run began: {', '.join(changed)}", soft_wrap=True)


def base_targets(config: TrainingConfig, folder: Path | None = None) -> BaseTargets | None:
    """The maneuver that the policy corrects, None if it corrects none; a run's folder holds a copy of it."""
    if config.residual is None:
        return None
    return BaseTargets(config.residual.load_maneuver(folder), config.residual.scale, decision_hz(config.env.kwargs))


class TrainingSession:
    """Environments and model of one process that trains, from ``from_step`` to ``config.steps``.

    Attributes:
        config: as given.
        run: as given; the folder.
        base: as given; the maneuver that is corrected.
        model: the algorithm, untrained.
        world_seed: of the first training world.
    """

    def __init__(
        self, config: TrainingConfig, run: RunFolder, console: Console, from_step: int, base: BaseTargets | None
    ) -> None:
        self.config, self.run, self.base = config, run, base
        self._console, self._from_step = console, from_step
        self.world_seed = world_seed(config.seed, from_step)
        torch.set_num_threads(config.torch_threads)
        self._world = _described(config.env)
        console.print(f"preparing {config.n_envs} worlds of {config.env.id}")
        self._multiplier = None if config.comfort is None else Multiplier(config.comfort)
        self._worlds = worlds_for(config.env, config.n_envs, base, self._multiplier)
        self._validation = worlds_for(config.env, config.evaluation.patients, base)
        self.model = make_model(config, self._worlds)
        self._worlds.seed(self.world_seed)
        if self._world is not None and plain_policy(self.model, config) is None:
            self.model.plays = plays_in(self._world, self._residual())  # type: ignore[attr-defined]
            console.print(
                f"no card describes this network: the best policy is kept as {run.best_model.name}, which is played "
                "with --trust and cannot be exported",
                soft_wrap=True,
            )
        self._priced = None
        if isinstance(self.model, APG):
            self._priced = worlds_for(config.env, min(PRICED, config.n_envs), base)
            self._priced.seed(self.world_seed)
            self.model.priced = self._priced

    def __enter__(self) -> TrainingSession:
        return self

    def __exit__(self, *exception: object) -> None:
        for worlds in (self._worlds, self._validation, self._priced):
            if worlds is not None:
                worlds.close()

    def restore(self, checkpoint: Path) -> None:
        """Take over weights, optimiser state, counters and multiplier of a checkpoint; nothing is unpickled."""
        model: Any = self.model
        saved = read_counts(checkpoint)
        try:
            model.set_parameters(str(checkpoint), device=self.config.device)
            _, _, variables = load_from_zip_file(str(checkpoint), device=self.config.device, load_data=False)
            for name, value in (variables or {}).items():
                if value is not None:
                    attrgetter(name)(model).data.copy_(value.data)
            model.num_timesteps, model._n_updates = int(saved["num_timesteps"]), int(saved["_n_updates"])
            if self._multiplier is not None:
                self._multiplier.value = float(saved["comfort_multiplier"])
        except Exception as error:  # damaged weights can raise anything
            raise damaged(checkpoint, error) from error
        if isinstance(model, OffPolicyAlgorithm):
            model.learning_starts += model.num_timesteps

    def learn(self) -> int:
        """Learn until the last step or a signal; save, report, and return the exit code."""
        config, model, run = self.config, self.model, self.run
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
                upkeep = Upkeep(config, run, interrupt, progress, self._multiplier)
                evaluations = Evaluations(
                    run,
                    config.evaluation,
                    self._validation,
                    self.keep,
                    progress,
                    interrupted=interrupt.wanted,
                    largest_discomfort_s=None if config.comfort is None else config.comfort.target_discomfort_s,
                    sampled=not isinstance(model, APG),  # it learns through the most likely actions
                )
                model.learn(
                    config.steps - self._from_step,
                    CallbackList([upkeep, evaluations]),
                    # On-policy algorithms log every rollout, the others after so many episodes.
                    log_interval=config.n_envs if isinstance(model, OffPolicyAlgorithm) else 1,
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
        self._report(evaluations, time.monotonic() - begun)
        return 0

    def keep(self) -> None:
        """Write the policy as it is now into the run's folder, as weights and a card.

        A card says where in jawenv a policy plays: of another environment or network the model is saved instead.
        """
        config, run, model = self.config, self.run, self.model
        plain = None if self._world is None else plain_policy(model, config)
        if self._world is None or plain is None:
            run.save_model(model, run.best_model)
            return
        environment, (architecture, weights) = Environment.of(self._world), plain
        write_run_policy(run, config, environment, architecture, self._residual(), weights, model.num_timesteps)

    def _residual(self) -> CorrectedManeuver | None:
        return None if self.base is None else CorrectedManeuver(maneuver=self.base.maneuver, scale=self.base.scale)

    def _report(self, evaluations: Evaluations, seconds: float) -> None:
        steps, best = self.model.num_timesteps, evaluations.best
        rate = (steps - self._from_step) / seconds
        assert best is not None
        kept = "the untrained policy" if self.base is None else "the maneuver itself"
        self._console.print(
            f"{steps:,} steps in {seconds:.0f} s ({rate:,.0f} steps/s with evaluations); "
            f"best on {self._validation.num_envs} validation patients after {best['steps']:,.0f} steps: "
            f"{in_words(best, evaluations.limit_s)}: {self.run.path}"
            + ("" if best["steps"] else f"\nnothing was learned: {kept} is kept"),
            soft_wrap=True,
        )


def _whole_updates(model: Any, from_step: int, steps: int) -> int:
    """Step at which a run of so many steps ends: stable-baselines3 steps all worlds before each update."""
    on_policy = isinstance(model, OnPolicyAlgorithm)
    update: int = model.n_envs * (model.n_steps if on_policy else model.train_freq.frequency)
    return from_step + -(-(steps - from_step) // update) * update


def _described(config: EnvConfig) -> Configuration | None:
    """The world of the training, checked before worlds are made; None for an environment outside jawenv."""
    if not config.id.startswith("jawenv/"):
        return None
    return Configuration.from_mapping({"env": config.id, **config.kwargs})
