"""Attributes of the native vector form's worlds, for ``call``, ``get_attr`` and ``set_attr``."""

from __future__ import annotations

from typing import Any

import numpy as np

from jawenv.base.errors import InputError, UnknownAttributeError, shown

__all__ = ["SETTABLE", "attribute_of_worlds", "set_attribute_of_worlds"]

# Attribute of a world -> that of the vector form which all its worlds share.
_SHARED = {
    "action_space": "single_action_space",
    "configuration": "configuration",
    "metadata": "metadata",
    "observation_space": "single_observation_space",
    "parameter_names": "parameter_names",
    "prior": "prior",
    "render_mode": "render_mode",
    "spec": "spec",
}
_OF_EACH = ("np_random", "np_random_seed", "picture_title")
SETTABLE = ("np_random", "picture_title")


def attribute_of_worlds(env: Any, name: object) -> tuple[Any, ...]:
    """An attribute of every world, by its name in the single form.

    Args:
        env: the ``JawVectorEnv``.
        name: which.

    Raises:
        UnknownAttributeError: worlds have no such attribute.
    """
    if isinstance(name, str) and name in _SHARED:
        values: tuple[Any, ...] = (getattr(env, _SHARED[name]),) * env.num_envs
        return values
    if isinstance(name, str) and name in _OF_EACH:
        return tuple(getattr(env, name))
    allowed = ", ".join(sorted([*_SHARED, *_OF_EACH]))
    raise UnknownAttributeError(f"attribute {shown(name)} is unknown; allowed: {allowed}")


def set_attribute_of_worlds(env: Any, name: object, values: object) -> None:
    """Set an attribute of every world, to an entry of a list or tuple each, or all to one value.

    Args:
        env: the ``JawVectorEnv``.
        name: which.
        values: one value, or a list or tuple of N.

    Raises:
        UnknownAttributeError: the attribute cannot be set.
        InputError: a list of another length than N, or a value that is not allowed.
    """
    if name not in SETTABLE:
        raise UnknownAttributeError(f"attribute {shown(name)} cannot be set; allowed: {', '.join(SETTABLE)}")
    entries: list[Any] = list(values) if isinstance(values, list | tuple) else [values] * env.num_envs
    if len(entries) != env.num_envs:
        raise InputError(f"{name} has {len(entries)} values; allowed: one value, or a list of {env.num_envs}")
    for i, entry in enumerate(entries):
        if name == "np_random" and not isinstance(entry, np.random.Generator):
            raise InputError(f"np_random[{i}] is {shown(entry)}; allowed: a numpy.random.Generator")
        if name == "picture_title" and not isinstance(entry, str | None):
            raise InputError(f"picture_title[{i}] is {shown(entry)}; allowed: a text or None")
    if name == "np_random":
        env.set_generators(entries)
    else:
        env.picture_title = tuple(entries)
