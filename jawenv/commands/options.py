"""The options of a world, made of the fields of ``Configuration``, and others that several commands have."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from dataclasses import Field, fields
from functools import wraps
from pathlib import Path
from typing import Annotated, Any

import typer

from jawenv.base.errors import InputError, shown
from jawenv.base.files import FILE_TYPES

Maneuver = Annotated[
    str, typer.Argument(metavar="AGENT|FILE", help="A name of `jawenv list agents`, or a maneuver file.")
]
Seed = Annotated[int, typer.Option(help="Of the first patient and its noise.", metavar="N")]
Cohort = Annotated[
    str | None, typer.Option(help="Population that the patient is believed to come from.", metavar="NAME")
]
Columns = Annotated[
    Path | None,
    typer.Option(help="File with the names, units and signs that the recording has for ours.", metavar="FILE"),
]
Resample = Annotated[
    float | None, typer.Option(help="Interpolate uneven times to so many rows a second.", metavar="HZ")
]

ENV = Annotated[
    str | None,
    typer.Option(
        "--env",
        "--model",
        help="Environment, as jawenv/JawSides-v3, JawSides or sides; Jaw, or that of trained runs, by default.",
        metavar="NAME",
    ),
]
ENVIRONMENT = "env"


def takes_world(
    *without: str, defaults: Mapping[str, str] | None = None
) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Decorator of a command with a parameter ``world``: it has an option for each argument of a world instead.

    The command gets a mapping of those that were given, ``env`` among them, as ``Configuration.from_mapping`` takes it.

    Args:
        without: arguments that the command sets itself.
        defaults: of arguments that have another default in this command, for the help.
    """

    def decorated(command: Callable[..., Any]) -> Callable[..., Any]:
        stated = inspect.signature(command, eval_str=True)
        options = _options(without, defaults or {})
        parameters = [parameter for parameter in stated.parameters.values() if parameter.name != "world"]
        index = next(
            (i for i, parameter in enumerate(parameters) if parameter.default is not parameter.empty), len(parameters)
        )
        names = [option.name for option in options]

        @wraps(command)
        def run(**arguments: Any) -> Any:
            world = {name: arguments.pop(name) for name in names}
            return command(
                **arguments, world=_world({name: value for name, value in world.items() if value not in (None, [])})
            )

        vars(run)["__signature__"] = stated.replace(parameters=[*parameters[:index], *options, *parameters[index:]])
        run.__annotations__ = {parameter.name: parameter.annotation for parameter in (*parameters, *options)}
        return run

    return decorated


def _options(without: tuple[str, ...], defaults: Mapping[str, str]) -> list[inspect.Parameter]:
    from jawenv.envs.configuration import Configuration

    kinds = {ENVIRONMENT: ENV} | {
        argument.name: _option(argument, defaults.get(argument.name, argument.default))
        for argument in fields(Configuration)
        if argument.metadata["option"]
    }
    return [
        inspect.Parameter(name, inspect.Parameter.POSITIONAL_OR_KEYWORD, default=None, annotation=kind)
        for name, kind in kinds.items()
        if name not in without
    ]


def _option(argument: Field[Any], default: Any) -> Any:
    """The option of an argument: its name, its help and its kind of value."""
    metadata, name = argument.metadata, f"--{argument.name.replace('_', '-')}"
    kind = {"fields": list[str], "number": float}.get(metadata["option"], str)
    said = "" if default is None else f" [default: {default}]"
    return Annotated[kind | None, typer.Option(name, help=metadata["help"] + said, metavar=metadata["metavar"] or None)]


def _world(arguments: Mapping[str, Any]) -> dict[str, Any]:
    """Arguments as the environment takes them."""
    from jawenv.envs.configuration import Configuration, plain_value

    kinds = {argument.name: argument.metadata["option"] for argument in fields(Configuration)}
    world = {name: _fields(name, value) if kinds.get(name) == "fields" else value for name, value in arguments.items()}
    return {name: plain_value(name, value) if name in _MAY_BE_FILES else value for name, value in world.items()}


_MAY_BE_FILES = ("cohort", "device", "reality", "knowledge", "comfort", "anatomy")
"""Arguments of which results keep what a file says, whatever becomes of it."""


def _fields(option: str, texts: list[str]) -> Any:
    """A mapping from texts ``FIELD=VALUE``, or the one file that is named."""
    if len(texts) == 1 and texts[0].lower().endswith(FILE_TYPES):
        return texts[0]
    numbers = {}
    for text in texts:
        name, _, value = text.partition("=")
        try:
            numbers[name] = float(value)
        except ValueError:
            raise InputError(f"{option} is {shown(text)}; allowed: FIELD=VALUE with a number, or a file") from None
    return numbers
