"""A planner's decisions as a policy that decides at once: ``python -m training distill``.

Dataset aggregation (Ross, Gordon & Bagnell 2011, AISTATS 15:627): in the first round the planner plays, afterwards the
policy learnt so far does, and the planner says in each state what it would do there. After each round the policy is
fitted to all labels of all rounds, so that it also knows what to do in states that only its own mistakes lead to.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from itertools import takewhile
from pathlib import Path
from typing import Any, Self

import numpy as np
import torch
from numpy.typing import NDArray
from pydantic import field_validator
from stable_baselines3 import PPO
from stable_baselines3.common.logger import configure

from agents.array_files import load_arrays, save_arrays
from agents.planners import PLANNERS
from jawenv.controls import mode_of
from jawenv.device.channels import N_CHANNELS
from jawenv.envs.configuration import Configuration
from jawenv.errors import InputError, shown
from jawenv.files import InputModel
from jawenv.playing.policies.residual import BaseTargets
from jawenv.progress import Progress
from training.run.algorithm_configs import PositiveInt, PositiveNumber
from training.run.config import TrainingConfig
from training.run.evaluations import Evaluations
from training.run.folder import RunFolder, read_counts
from training.run.train import TrainingSession
from training.run.worlds import world_seed, worlds_for

BATCH = 256


class Distillation(InputModel):
    """How a planner is distilled.

    Attributes:
        planner: the teacher, a name of ``agents.planners.PLANNERS``.
        rounds: how often labels are gathered; in the first the planner plays.
        patients: new ones in each round.
        epochs: passes over all labels after each round.
        learning_rate: of AdamW, falling to 0 along a cosine.
        weight_decay: of AdamW.
    """

    planner: str = "receding_horizon"
    rounds: PositiveInt = 8
    patients: PositiveInt = 12
    epochs: PositiveInt = 60
    learning_rate: PositiveNumber = 1e-3
    weight_decay: PositiveNumber = 0.1

    @field_validator("planner")
    @classmethod
    def _known(cls, name: str) -> str:
        if name not in PLANNERS:
            raise ValueError(f"no such planner; allowed: {', '.join(PLANNERS)}")
        return name


def check_distillable(config: TrainingConfig) -> None:
    """Make sure that a planner can be distilled so.

    Raises:
        InputError: another control mode than targets, the policy corrects no maneuver, or is no perceptron of PPO.
    """
    mode = mode_of(config.env.kwargs)
    if not mode.takes_targets:
        raise InputError(f"control is {shown(mode.name)}; allowed: targets")
    if config.residual is None:
        raise InputError("residual is none; allowed: a maneuver to correct (--residual-on MANEUVER)")
    if config.algorithm != "ppo":
        raise InputError(f"algorithm is {config.algorithm!r}; allowed: ppo")


class Labels:
    """Decisions of a planner in the states of M steps.

    Attributes:
        observation: (M, n) inputs of the policy.
        residual: (M, 4) the planner's correction of the maneuver, as an action of the policy.
    """

    def __init__(self, observation: NDArray[Any], residual: NDArray[Any]) -> None:
        self.observation, self.residual = observation, residual

    def save(self, path: Path) -> None:
        """Write all (.npz), wholly or not at all."""
        path.parent.mkdir(parents=True, exist_ok=True)
        save_arrays(path, observation=self.observation, residual=self.residual)

    @classmethod
    def load(cls, path: Path) -> Self:
        """Read a file of ``save``.

        Raises:
            InputError: no such file, or a damaged one.
        """
        labels = cls(*load_arrays(path, ("observation", "residual"), "labels"))
        number = len(labels.observation)
        if labels.observation.ndim != 2 or labels.residual.shape != (number, N_CHANNELS):
            shapes = f"{labels.observation.shape} and {labels.residual.shape}"
            raise InputError(f"{path} is damaged: shapes are {shapes}; allowed: (M, n) and (M, {N_CHANNELS})")
        if not np.isfinite(labels.observation).all() or not np.isfinite(labels.residual).all():
            raise InputError(f"{path}: damaged labels: a value is not finite")
        return labels


def gather(
    config: TrainingConfig,
    base: BaseTargets,
    planner_name: str,
    *,
    policy: PPO | None,
    seed: int,
    patients: int,
    tell: Callable[[float], None],
) -> Labels:
    """Play one episode with each patient and label its steps.

    Args:
        config: of the run.
        base: the maneuver that is corrected.
        planner_name: who labels.
        policy: the player; None for the planner, as far as a correction can reach its targets.
        seed: of the first patient.
        patients: how many.
        tell: called after each step with the seconds of patients labelled.
    """
    worlds = worlds_for(config.env, patients, base)
    try:
        planner = PLANNERS[planner_name].planner("targets")
        planner.reset(patients, seed)
        planner.attach(worlds.env)
        worlds.seed(seed)
        seen = np.asarray(worlds.reset())
        running = np.ones(patients, dtype=bool)
        observations, residuals = [], []
        step = 0
        while running.any():
            action, _ = planner.predict(seen)
            residual = base.residuals(np.full(patients, step), action)
            observations.append(seen[running])
            residuals.append(residual[running])
            played = residual if policy is None else policy.predict(seen, deterministic=True)[0]
            after, _, ended, _ = worlds.step(played)
            seen = np.asarray(after)
            running &= ~ended
            step += 1
            tell(step * patients / base.decision_hz)
    finally:
        worlds.close()
    return Labels(*(np.concatenate(parts) for parts in (observations, residuals)))


def fit(model: PPO, rounds: list[Labels], settings: Distillation, seed: int) -> None:
    """Fit the policy's mean action to all labels; least squares."""
    observations, residuals = (
        torch.as_tensor(np.concatenate([getattr(labels, name) for labels in rounds]), dtype=torch.float32)
        for name in ("observation", "residual")
    )
    policy, generator = model.policy, torch.Generator().manual_seed(seed)
    optimiser = torch.optim.AdamW(policy.parameters(), lr=settings.learning_rate, weight_decay=settings.weight_decay)
    schedule = torch.optim.lr_scheduler.CosineAnnealingLR(optimiser, settings.epochs)
    for _ in range(settings.epochs):
        for batch in torch.split(torch.randperm(len(observations), generator=generator), BATCH):
            loss = torch.mean((_mean_action(policy, observations[batch]) - residuals[batch]) ** 2)
            optimiser.zero_grad()
            loss.backward()  # type: ignore[no-untyped-call]
            optimiser.step()
        schedule.step()


def error_on(model: PPO, labels: Labels) -> float:
    """Root mean square difference between the policy's actions and the planner's."""
    played = model.predict(labels.observation, deterministic=True)[0]
    return float(np.sqrt(np.mean((played - labels.residual) ** 2)))


def _mean_action(policy: Any, seen: torch.Tensor) -> torch.Tensor:
    """Mean actions (M, 4) of a policy without memory."""
    mean: torch.Tensor = policy.get_distribution(seen).distribution.mean
    return mean


def distill(session: TrainingSession, settings: Distillation, progress: Progress) -> None:
    """Gather, fit and evaluate, round by round, after the rounds with labels in the run's folder.

    Args:
        session: worlds, untrained policy and folder of the run.
        settings: of the distillation.
        progress: counts seconds of patients.

    Raises:
        InputError: damaged labels.
    """
    config, model, base, run = session.config, session.model, session.base, session.run
    assert base is not None and isinstance(model, PPO)
    model.set_logger(configure(str(run.tensorboard), ["tensorboard"]))
    evaluations = session.evaluations(progress)
    evaluations.init_callback(model)
    untrained = {name: value.clone() for name, value in model.policy.state_dict().items()}
    rounds = [Labels.load(path) for path in finished_rounds(run, settings.rounds)]
    progress.skip(len(rounds) * settings.patients * seconds_of(config))
    if rounds:
        _fit_anew(model, untrained, rounds, settings, config.seed)
        _evaluate(evaluations, session)  # where it was stopped after the labels and before that
    for k in range(len(rounds), settings.rounds):
        labels = gather(
            config,
            base,
            settings.planner,
            policy=model if k else None,
            seed=world_seed(config.seed, k),
            patients=settings.patients,
            tell=partial(_advance, progress, progress.done),
        )
        labels.save(_file(run, k))
        if k:
            progress.note("error", f"{error_on(model, labels):.3f} from the planner's actions")
        rounds.append(labels)
        _fit_anew(model, untrained, rounds, settings, config.seed)
        _evaluate(evaluations, session)


def _evaluate(evaluations: Evaluations, session: TrainingSession) -> None:
    """Evaluate and keep the policy as it is now, unless that is done; random actions follow from seed and steps."""
    model = session.model
    if evaluations.last != model.num_timesteps:
        torch.manual_seed(world_seed(session.config.seed, model.num_timesteps))
        evaluations.evaluate()
    session.run.save_checkpoint(model, session.config.checkpoints.keep)


def _advance(progress: Progress, before: float, done: float) -> None:
    progress.advance_to(before + done)


def finished_rounds(run: RunFolder, rounds: int) -> list[Path]:
    """The files of the finished rounds, from the first one on."""
    files = [_file(run, k) for k in range(rounds)]
    return list(takewhile(Path.is_file, files))


def is_finished(run: RunFolder, rounds: int) -> bool:
    """Whether so many rounds are over and the latest checkpoint is of their labels.

    Raises:
        InputError: damaged labels, or a damaged checkpoint.
    """
    files, checkpoint = finished_rounds(run, rounds), run.latest_checkpoint()
    if len(files) < rounds or checkpoint is None:
        return False
    learnt: object = read_counts(checkpoint)["num_timesteps"]
    return learnt == sum(len(Labels.load(path).observation) for path in files)


def seconds_of(config: TrainingConfig) -> float:
    """How long an episode of the run is, s."""
    length: Any = config.env.kwargs.get("episode_s", Configuration.episode_s)
    return float(length)


def _file(run: RunFolder, number: int) -> Path:
    return run.labels / f"round_{number:02d}.npz"


def _fit_anew(
    model: PPO, untrained: dict[str, torch.Tensor], rounds: list[Labels], settings: Distillation, seed: int
) -> None:
    """Fit the untrained policy to all labels, so that a policy follows from its labels alone."""
    model.policy.load_state_dict(untrained)
    fit(model, rounds, settings, seed)
    model.num_timesteps = sum(len(labels.observation) for labels in rounds)
