"""Inputs of this room's functions, checked: an environment's id and arguments, and parameters of patients."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import gymnasium as gym
import numpy as np
from numpy.typing import ArrayLike, NDArray

from jawenv.anatomy import Patient
from jawenv.base.errors import InputError, shown
from jawenv.envs.configuration import Configuration, configure
from jawenv.ladder import DEFAULT_ENV as DEFAULT_ENV

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]


def configuration_of(env_id: str, env_kwargs: Mapping[str, Any] | None, own: Mapping[str, Any]) -> Configuration:
    """The checked arguments of an environment of jawenv.

    Args:
        env_id: a registered id.
        env_kwargs: arguments of the environment.
        own: those that the caller sets itself.
    """
    spec = gym.registry.get(env_id)
    if spec is None or spec.entry_point != "jawenv.envs.jaw:JawEnv":
        raise InputError(f"env_id is {shown(env_id)}; allowed: an id of jawenv, as 'jawenv/Jaw-v3'")
    if not isinstance(env_kwargs, Mapping | None):
        raise InputError(f"env_kwargs is {shown(env_kwargs)}; allowed: a mapping of the environment's arguments")
    for name in own:
        if name in (env_kwargs or {}):
            raise InputError(f"env_kwargs has {name!r}, which is set here; allowed: the other arguments")
    configuration = configure({**spec.kwargs, **(env_kwargs or {}), **own})
    if configuration.own_estimator is not None:
        raise InputError("env_kwargs has an estimator of one's own; allowed where readings are made: the environment's")
    return configuration


def log_parameters(theta: ArrayLike, size: int) -> Array:
    """Parameters as floats of shape (n, ``size``)."""
    try:
        values = np.array(theta, dtype=np.float64)
    except (TypeError, ValueError):
        values = np.full(1, np.nan)
    if values.ndim != 2 or values.shape[1] != size or not np.isfinite(values).all():
        raise InputError(f"theta is {shown(theta)}; allowed: finite natural-log parameters of shape (n, {size})")
    return values


def patient_of(parameters: Array, muscles: tuple[str, ...]) -> Patient | None:
    """The patient with p natural-log parameters, or None where F_o or b is larger than a ``Patient`` may have."""
    try:
        return Patient.from_log_parameters(parameters, muscles=muscles)
    except InputError:
        return None
