"""Arguments of an algorithm as a configuration gives them, checked against the signature of its class."""

from __future__ import annotations

import inspect
import math
from collections.abc import Mapping
from typing import Any

from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.on_policy_algorithm import OnPolicyAlgorithm
from stable_baselines3.common.utils import LinearSchedule

from jawenv.base.errors import InputError, not_among, shown
from jawenv.base.files import validate
from training.run.config import Schedule, TrainingConfig

_OURS = ("policy", "env", "seed", "device", "verbose", "stats_window_size", "tensorboard_log", "_init_setup_model")
"""Arguments that the training itself sets."""


def parameters_of(kind: type[BaseAlgorithm]) -> dict[str, inspect.Parameter]:
    """Arguments that a configuration may give; some of them a class only passes on to its bases."""
    found: dict[str, inspect.Parameter] = {}
    for one in (one for one in kind.__mro__ if "__init__" in vars(one)):
        parameters = list(inspect.signature(vars(one)["__init__"]).parameters.values())[1:]
        for parameter in (p for p in parameters if p.kind in (p.POSITIONAL_OR_KEYWORD, p.KEYWORD_ONLY)):
            found.setdefault(parameter.name, parameter)
        if not any(parameter.kind is parameter.VAR_KEYWORD for parameter in parameters):
            break
    return {name: parameter for name, parameter in found.items() if name not in _OURS}


def arguments_of(config: TrainingConfig, kind: type[BaseAlgorithm]) -> dict[str, Any]:
    """The keyword arguments of a configuration as a class takes them."""
    allowed = parameters_of(kind)
    given: dict[str, Any] = {}
    for name, value in config.arguments.items():
        if name not in allowed:
            raise not_among(f"key of arguments, of {config.algorithm},", name, allowed)
        given[name] = _argument(f"arguments.{name}", value, allowed[name].default)
    _check_batches(config, allowed, kind)
    return given


def _argument(name: str, value: Any, default: Any) -> Any:
    """An argument: a mapping is a schedule where the default is a number, and a number stays one."""
    if type(default) not in (bool, int, float):
        return value
    if isinstance(value, Mapping):
        schedule = validate(Schedule, value, name)
        return LinearSchedule(schedule.initial, schedule.final, 1.0)
    allowed = {bool: (bool,), int: (int,), float: (int, float)}[type(default)]
    if type(value) not in allowed or not math.isfinite(value):
        kind = {bool: "true or false", int: "an integer", float: "a number"}[type(default)]
        raise InputError(f"{name} is {shown(value)}; allowed: {kind}")
    return value


def _check_batches(config: TrainingConfig, allowed: Mapping[str, inspect.Parameter], kind: type[BaseAlgorithm]) -> None:
    """Make sure that an on-policy algorithm's rollout is cut into whole batches."""
    defaults = {name: parameter.default for name, parameter in allowed.items()}
    steps, batch = (config.arguments.get(name, defaults.get(name)) for name in ("n_steps", "batch_size"))
    if not issubclass(kind, OnPolicyAlgorithm) or not (isinstance(steps, int) and isinstance(batch, int)):
        return
    if steps < 1 or batch < 2 or config.n_envs * steps % batch:
        raise InputError(
            f"n_envs x arguments.n_steps is {config.n_envs} x {steps} = {config.n_envs * steps}; "
            f"allowed: a multiple of arguments.batch_size, {batch}"
        )
