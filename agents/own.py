"""Agents of one's own, named as ``package.module:Name``."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from importlib.machinery import PathFinder
from pathlib import Path
from typing import Any

from jawenv.base.errors import InputError
from jawenv.base.named_objects import add_current_folder, import_named, is_named, no_module, reason
from jawenv.playing.agents import Agent

_MEMBERS = ("name", "reset", "predict")


def load_own(spec: str, settings: Mapping[str, Any]) -> Agent:
    """Import a class or function, installed or in the current folder, and make an agent with it.

    This runs the module: name only code of trusted origin.

    Args:
        spec: ``package.module:Name``.
        settings: keyword arguments; those are given that its signature takes.
    """
    make = _named(spec)
    try:
        agent = make(**_taken(make, settings))
    except (Exception, SystemExit) as error:  # code of the user's can raise anything, and end the program
        raise InputError(f"agent '{spec}': cannot be made: {reason(error)}") from error
    missing = [member for member in _MEMBERS if not hasattr(agent, member)]
    if missing or not isinstance(agent, Agent):
        raise InputError(
            f"agent '{spec}': makes a {type(agent).__name__} without {', '.join(missing)}; "
            f"an agent has {', '.join(_MEMBERS)}"
        )
    if not isinstance(agent.name, str) or not agent.name:
        raise InputError(f"agent '{spec}': its name is {agent.name!r}; allowed: a text")
    return agent


def source_of(spec: str) -> Path | None:
    """The file that an agent of one's own stands in, found without running it; None if no file has it."""
    if not is_named(spec):
        return None
    add_current_folder()
    name, places, file = "", None, None
    for part in spec.partition(":")[0].split("."):
        name = f"{name}.{part}".lstrip(".")
        module_spec = PathFinder.find_spec(name, places)
        if module_spec is None:
            raise no_module(spec, "agent", name)
        places, file = module_spec.submodule_search_locations or [], module_spec.origin
    return None if file is None else Path(file)


def _named(spec: str) -> Callable[..., Any]:
    """The class or function that a spec names."""
    make = import_named(spec, "agent")
    if not callable(make):
        raise InputError(
            f"agent '{spec}': is of type {type(make).__name__}; allowed: a class or function that makes an agent"
        )
    return make  # type: ignore[no-any-return]


def _taken(make: Callable[..., Any], settings: Mapping[str, Any]) -> dict[str, Any]:
    """The settings that a signature takes."""
    try:
        parameters = inspect.signature(make).parameters.values()
    except (TypeError, ValueError):  # some classes written in C have none
        return {}
    if any(parameter.kind is parameter.VAR_KEYWORD for parameter in parameters):
        return dict(settings)
    by_name = {p.name for p in parameters if p.kind in (p.POSITIONAL_OR_KEYWORD, p.KEYWORD_ONLY)}
    return {key: value for key, value in settings.items() if key in by_name}
