"""Running of commands, and their help: no flag is shown with a value, and no argument with a type of Python."""

from __future__ import annotations

import os
import re
import sys
from importlib.metadata import version
from io import TextIOWrapper
from typing import Annotated, Any

import typer
from typer.core import TyperArgument, TyperGroup, TyperOption

from jawenv.base.errors import InputError, out_of_memory, reason_of

_NO_NUMBER = re.compile(r"Input should be a valid (integer|number), unable to parse string as an? \1")
"""Typer's message about a word in place of a number."""
_WORDS = {"integer": "whole number", "number": "number"}


def _say_version(asked: bool) -> None:
    if asked:
        print(f"jawenv {version('jawenv')}")
        raise typer.Exit


def _options_of_all(
    version: Annotated[
        bool, typer.Option("--version", help="Say which version this is.", callback=_say_version, is_eager=True)
    ] = False,
) -> None:
    """The options of a command line itself."""


class _Commands(TyperGroup):
    """A group of commands; its flags and theirs are shown as ``--flag`` in place of ``--flag <bool>``."""

    def get_params(self, ctx: Any) -> list[Any]:
        """Options of the group itself."""
        return _without_values(super().get_params(ctx))

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """The command of a name; None if there is none."""
        command = super().get_command(ctx, cmd_name)
        if command is not None:
            _without_values(command.get_params(ctx))
        return command


def _without_values(params: list[Any]) -> list[Any]:
    for param in params:
        if isinstance(param, TyperOption) and param.is_bool_flag:
            param.metavar = ""
        elif isinstance(param, TyperArgument):
            setattr(param, "display_type_rich", lambda ctx: None)  # noqa: B010  (a method; its name says what it takes)
    return params


def command_line(help: str) -> typer.Typer:
    """A command line without commands yet, which knows ``-h`` and ``--version``."""
    app = typer.Typer(
        cls=_Commands,
        help=help,
        add_completion=False,
        pretty_exceptions_enable=False,
        rich_markup_mode="markdown",
        context_settings={"help_option_names": ["-h", "--help"]},
    )
    app.callback(help=help)(_options_of_all)
    return app


def run(app: typer.Typer, name: str, arguments: list[str] | None, less_memory: str) -> int:
    """Run a command line, and say what is wrong with it in one line.

    Args:
        app: the commands.
        name: of the program.
        arguments: those of this process by default.
        less_memory: what needs less, where memory does not suffice.

    Returns:
        Exit code: 0 done, 2 unusable input, 130 interrupted.
    """
    if arguments is None:
        arguments = sys.argv[1:]
    if isinstance(sys.stdout, TextIOWrapper):
        sys.stdout.reconfigure(errors="replace")  # a terminal without Unicode shows a question mark
    try:
        code = int(app(arguments or ["--help"], prog_name=name, standalone_mode=False) or 0)
        if sys.stdout is not None:
            sys.stdout.flush()
        return code
    except BrokenPipeError:
        _give_up_stdout()
        return 0
    except InputError as error:
        message = str(error)
    except MemoryError as error:
        message = f"{out_of_memory(error)}; {less_memory} need less"
    except OSError as error:
        if error.filename is not None:
            raise
        _give_up_stdout()  # a full disk, say
        message = f"the standard output cannot be written: {reason_of(error)}"
    except typer.TyperException as error:
        prefix = _faulty_value(error)
        message = _NO_NUMBER.sub(lambda match: f"{prefix}allowed: a {_WORDS[match[1]]}", error.format_message())
    print(f"error: {' '.join(message.split())}", file=sys.stderr)
    return 2


def _give_up_stdout() -> None:
    """Python writes what it still holds when the process ends: let that go nowhere."""
    with open(os.devnull, "w") as nowhere:
        os.dup2(nowhere.fileno(), sys.stdout.fileno())


def _faulty_value(error: typer.TyperException) -> str:
    """The faulty value of ``error`` and a semicolon; empty where typer's cause does not name it."""
    problems = getattr(error.__cause__, "errors", None)
    return f"'{problems()[0]['input']}'; " if callable(problems) else ""
