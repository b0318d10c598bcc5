"""A search for an algorithm's settings with Optuna, judged on the validation patients."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import optuna
from optuna.exceptions import StorageInternalError, TrialPruned
from optuna.trial import Trial, TrialState
from rich.console import Console
from sqlalchemy.exc import SQLAlchemyError
from stable_baselines3.common.on_policy_algorithm import OnPolicyAlgorithm

from agents.evaluations import read_evaluations
from jawenv.base.errors import InputError
from training.run import train
from training.run.algorithms import ALGORITHMS, algorithm_class
from training.run.arguments import parameters_of
from training.run.config import TrainingConfig
from training.run.folder import RunFolder

WARM_UP_TRIALS = 5
"""Trials that are neither guided nor pruned."""
EXCESS_PRICE = 100.0
"""Nats per s of discomfort above the limit, where there is a limit."""


def search(config: TrainingConfig, name: str, trials: int, storage: str, folder: Path, console: Console) -> int:
    """Go on with a study until it has so many trials; the same command again continues one that was stopped.

    Args:
        config: common settings of the trials.
        name: of the study in the database.
        trials: finished ones that the study shall have in the end.
        storage: URL of the database. Several processes may share one on a server.
        folder: each trial's run goes into ``trial-NUMBER`` in it.
        console: where to report.

    Returns:
        The exit code: 0, or the code of an interrupted trial.
    """
    if trials < 1:
        raise InputError(f"trials is {trials}; allowed: 1 or more")
    optuna.logging.set_verbosity(optuna.logging.WARNING)
    with _database(storage):
        study = _study(name, storage)
        while len(_finished(study)) < trials:
            trial = study.ask()
            code = _run_trial(study, trial, config, folder, console)
            if code:
                return code
        _report(study, console)
    return 0


def suggest(trial: Trial, config: TrainingConfig) -> TrainingConfig:
    """The configuration of a trial; the reward and the price of discomfort are never searched."""
    kind = algorithm_class(config.algorithm)
    arguments: dict[str, Any] = {}
    network: dict[str, Any] = {}
    final: dict[str, float] = {}
    if issubclass(kind, ALGORITHMS["APG"]):
        rate = trial.suggest_float("learning_rate", 5e-4, 5e-3, log=True)
    elif issubclass(kind, OnPolicyAlgorithm):
        rate = trial.suggest_float("learning_rate", 1e-4, 2e-3, log=True)
        arguments["gamma"] = trial.suggest_float("gamma", 0.97, 0.995)
        if "n_epochs" in parameters_of(kind):
            arguments["n_epochs"] = trial.suggest_int("n_epochs", 3, 10)
        network["initial_log_std"] = trial.suggest_float("initial_log_std", -2.0, -0.5)
    else:
        rate = trial.suggest_float("learning_rate", 2e-4, 2e-3, log=True)
        final = {"final": rate}
        arguments["gamma"] = trial.suggest_float("gamma", 0.95, 0.99)
        arguments["gradient_steps"] = trial.suggest_categorical("gradient_steps", [5, 10, 20])
        network["policy"] = network["value"] = [trial.suggest_categorical("units", [64, 128, 256])] * 2
    arguments["learning_rate"] = {"initial": rate, **final}
    changes: dict[str, Any] = {"arguments": arguments, "network": network, "seed": config.seed + trial.number}
    if config.residual is not None:
        scale = trial.suggest_float("scale", 0.2, 0.8)
        changes["residual"] = {"maneuver": config.residual.maneuver, "scale": scale}
    return config.changed(**changes)


def _study(name: str, storage: str) -> optuna.Study:
    path = storage.removeprefix("sqlite:///")
    if path != storage:
        Path(path).parent.mkdir(parents=True, exist_ok=True)
    return optuna.create_study(
        study_name=name,
        storage=storage,
        load_if_exists=True,
        direction="maximize",
        # No seed: a study that goes on, or a second process, would try the same settings again.
        sampler=optuna.samplers.TPESampler(n_startup_trials=WARM_UP_TRIALS),
        pruner=optuna.pruners.MedianPruner(n_startup_trials=WARM_UP_TRIALS, n_warmup_steps=1),
    )


def _run_trial(study: optuna.Study, trial: Trial, config: TrainingConfig, folder: Path, console: Console) -> int:
    """Train one trial and tell the study its last result on the validation patients."""
    trial_config = suggest(trial, config)
    run = RunFolder(folder / f"trial-{trial.number:04d}")
    console.print(f"trial {trial.number}: {trial.params}", soft_wrap=True)

    def report(steps: int, row: dict[str, float]) -> None:
        trial.report(_value(trial_config, row), steps)
        if trial.should_prune():
            raise TrialPruned

    try:
        code = train.start(trial_config, run, console, overwrite=True, report=report)
    except TrialPruned:
        study.tell(trial, state=TrialState.PRUNED)
        console.print(f"trial {trial.number} pruned: below the median")
        return 0
    if code:
        study.tell(trial, state=TrialState.FAIL)
        return code
    study.tell(trial, _value(trial_config, read_evaluations(run.path)[-1]))
    return 0


def _value(config: TrainingConfig, row: dict[str, float]) -> float:
    """Value of an evaluation: its mean return, less the price of discomfort above the limit if there is one."""
    if config.comfort is None:
        return row["return"]
    excess = max(0.0, row["discomfort_s"] - config.comfort.target_discomfort_s)
    return row["return"] - EXCESS_PRICE * excess


def _finished(study: optuna.Study) -> list[optuna.trial.FrozenTrial]:
    return study.get_trials(deepcopy=False, states=(TrialState.COMPLETE, TrialState.PRUNED))


def _report(study: optuna.Study, console: Console) -> None:
    if not study.get_trials(deepcopy=False, states=(TrialState.COMPLETE,)):
        console.print("no trial was finished")
        return
    best = study.best_trial
    console.print(f"best of {len(_finished(study))} trials: {best.number}, value {best.value:.4g}, {best.params}")


@contextmanager
def _database(storage: str) -> Iterator[None]:
    """Turn errors of a database into one line."""
    try:
        yield
    except (StorageInternalError, SQLAlchemyError, ImportError, OSError) as error:
        cause = error.__cause__ or error
        reason = " ".join(str(getattr(cause, "orig", None) or cause).split())[:200]
        raise InputError(f"storage {_without_password(storage)}: cannot be used: {reason}") from error


def _without_password(storage: str) -> str:
    scheme, separator, rest = storage.partition("://")
    return f"{scheme}{separator}{rest.rpartition('@')[2]}"
