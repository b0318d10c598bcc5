"""The options of a world, made of the fields of ``Configuration``, and others that several commands have."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from dataclasses import Field, fields, is_dataclass, replace
from functools import wraps
from pathlib import Path
from typing import Annotated, Any, get_type_hints

import typer

from jawenv.base.errors import InputError, not_among, shown
from jawenv.base.files import FILE_TYPES

Maneuver = Annotated[
    str, typer.Argument(metavar="AGENT|FILE", help="A name of `jawenv list agents`, or a maneuver file.")
]
Seed = Annotated[int, typer.Option(help="Of the first patient and its noise.", metavar="N")]
Cohort = Annotated[
    str | None,
    typer.Option(
        help="Population that the patient is believed to come from; anyone unless the recording says.", metavar="NAME"
    ),
]
Knowledge = Annotated[
    str | None,
    typer.Option(
        help="What is known of anatomy and device: exact, imaged or bench, or a file; bench unless the recording says.",
        metavar="NAME",
    ),
]
Anatomy = Annotated[
    Path | None,
    typer.Option(help="File of the patient's anatomy; without one the motion tells the jaw's size.", metavar="FILE"),
]
HeadTilt = Annotated[
    float | None, typer.Option("--head-tilt", help="Pitch of the head, looking down above 0; -80 lies.", metavar="DEG")
]
Columns = Annotated[
    Path | None,
    typer.Option(help="File with the names, units and signs that the recording has for ours.", metavar="FILE"),
]
Resample = Annotated[
    float | None, typer.Option(help="Interpolate uneven times to so many rows a second.", metavar="HZ")
]

WORLD = "World: patient, device and what the filter knows"
_ENVIRONMENT, _SET = "env", "settings"


def takes_world(
    *without: str, defaults: Mapping[str, object] | None = None, otherwise: str = ""
) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Decorator of a command with a parameter ``world``: it has the options of a world behind its own instead.

    The command gets a mapping of those that were given, ``env`` among them, as ``Configuration.from_mapping`` takes it.

    Args:
        without: arguments that the command sets itself.
        defaults: of arguments that have another default in this command, for the help; None says none.
        otherwise: where a default comes from that is not the one stated, for the help.
    """

    def decorated(command: Callable[..., Any]) -> Callable[..., Any]:
        stated = inspect.signature(command, eval_str=True)
        options = _options(without, defaults or {}, otherwise)
        names = [option.name for option in options]
        parameters = [*(own for own in stated.parameters.values() if own.name != "world"), *options]

        @wraps(command)
        def run(**arguments: Any) -> Any:
            given = {name: arguments.pop(name) for name in names}
            world = {name: value for name, value in given.items() if value not in (None, [])}
            return command(**arguments, world=_world(world))

        vars(run)["__signature__"] = stated.replace(
            parameters=[parameter.replace(kind=parameter.KEYWORD_ONLY) for parameter in parameters]
        )
        run.__annotations__ = {parameter.name: parameter.annotation for parameter in parameters}
        return run

    return decorated


def takes_together(command: Callable[..., Any]) -> Callable[..., Any]:
    """Decorator of a command: in place of a parameter whose default is a dataclass it has an option for each field."""
    stated = inspect.signature(command, eval_str=True)
    together: dict[str, Any] = {}
    parameters = []
    for name, parameter in stated.parameters.items():
        if is_dataclass(parameter.default):
            together[name] = parameter.default
            for field, kind in get_type_hints(type(parameter.default), include_extras=True).items():
                default = getattr(parameter.default, field)
                parameters.append(parameter.replace(name=field, default=default, annotation=kind))
        else:
            parameters.append(parameter)

    @wraps(command)
    def run(**arguments: Any) -> Any:
        for name, default in together.items():
            arguments[name] = replace(default, **{field: arguments.pop(field) for field in vars(default)})
        return command(**arguments)

    vars(run)["__signature__"] = stated.replace(parameters=parameters)
    run.__annotations__ = {parameter.name: parameter.annotation for parameter in parameters}
    return run


def _options(without: tuple[str, ...], defaults: Mapping[str, object], otherwise: str) -> list[inspect.Parameter]:
    from jawenv.envs.configuration import Configuration

    env = "Environment, as jawenv/JawSides-v3, JawSides or sides; Jaw, or that of trained runs, by default."
    more = "Another argument of the environment (docs/environment.md#arguments), as reward=worst; may be repeated."
    kinds = {
        _ENVIRONMENT: _annotated(str, "--env", env, "NAME"),
        **{
            argument.name: _option(argument, defaults.get(argument.name, argument.default), otherwise)
            for argument in fields(Configuration)
            if argument.metadata["option"]
        },
        _SET: _annotated(list[str], "--set", more, "NAME=VALUE"),
    }
    return [
        inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=None, annotation=kind)
        for name, kind in kinds.items()
        if name not in without
    ]


def _option(argument: Field[Any], default: object, otherwise: str) -> Any:
    """The option of an argument: its name, its help and its kind of value."""
    kind = {"fields": list[str], "number": float}.get(argument.metadata["option"], str)
    said = "" if default is None else f" [default: {default}{otherwise}]"
    name = f"--{argument.name.replace('_', '-')}"
    return _annotated(kind, name, argument.metadata["help"] + said, argument.metadata["metavar"])


def _annotated(kind: Any, name: str, help: str, metavar: str) -> Any:
    return Annotated[kind | None, typer.Option(name, help=help, metavar=metavar, rich_help_panel=WORLD)]


def _world(options: Mapping[str, Any]) -> dict[str, Any]:
    """Arguments as the environment takes them."""
    from jawenv.envs.configuration import Configuration, plain_value

    arguments = {argument.name: argument.metadata["option"] for argument in fields(Configuration)}
    settable = [name for name, option in arguments.items() if not option and name != "model"]
    world: dict[str, Any] = {}
    for text in options.get(_SET, ()):
        name, _, value = text.partition("=")
        if name not in settable:
            raise not_among("--set", name, settable)
        world[name] = _plain(value)
    for name, value in options.items():
        if name != _SET:
            world[name] = _fields(name, value) if arguments.get(name) == "fields" else value
    return {name: plain_value(name, value) if name in _MAY_BE_FILES else value for name, value in world.items()}


def _plain(text: str) -> Any:
    """A number or a truth value that a text says, else the text."""
    try:
        return float(text)
    except ValueError:
        return {"true": True, "false": False}.get(text.lower(), text)


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
