"""The common ground of the commands that search: one output in use, progress, going on after a stop."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import fields
from pathlib import Path
from typing import Annotated, Any, TypeVar

import typer
import yaml
from rich.console import Console

from jawenv.base.errors import InputError
from jawenv.base.files import write_text
from jawenv.base.locks import alone
from jawenv.base.progress import Progress
from training.search.settings import SearchSettings

INTERRUPTED = 130
Found = TypeVar("Found")

ManeuverFile = Annotated[
    Path, typer.Option(metavar="FILE", help="Maneuver file to write; its stem is the maneuver's name.")
]
Anew = Annotated[
    bool, typer.Option("--overwrite", help="Replace the file, and begin anew where a search was left off.")
]


def quiet_console() -> Console:
    """Console on the standard error for the progress of a search, beside its result."""
    return Console(highlight=False, markup=False, stderr=True)


def until_stopped(
    work: Callable[[Progress], Found], total: float, unit: str, console: Console, goes_on: str
) -> Found | None:
    """Do some work with its progress shown.

    Args:
        work: gets the progress.
        total: how much there is to do.
        unit: of the counted progress, in the plural.
        console: where progress is shown.
        goes_on: how, after an interrupt.

    Returns:
        The result of the work; None after an interrupt.
    """
    try:
        with Progress(total, unit, console) as progress:
            return work(progress)
    except KeyboardInterrupt:
        console.print(f"stopped; the same command goes on {goes_on}", soft_wrap=True)
        return None


def search_maneuver(
    output: Path,
    log: Path,
    overwrite: bool,
    total: float,
    unit: str,
    search: Callable[[Progress], tuple[Found, bool]],
    write: Callable[[Found], str],
) -> int:
    """Search a maneuver, and keep the state of the search in a log beside its file.

    Args:
        output: the maneuver file, checked by `check_output`.
        log: state of the search, beside it; removed where the search begins anew.
        overwrite: begin anew.
        total: how much there is to do.
        unit: of the counted progress, in the plural.
        search: from progress to the result, and whether any part of it is new.
        write: writes the file and returns a line about it.

    Returns:
        The exit code: 0, or 130 after an interrupt.
    """
    console = quiet_console()
    with alone(output):
        if overwrite:
            log.unlink(missing_ok=True)
        elif output.exists() and not log.exists():
            raise InputError(f"--output: {output} exists already; replace it with --overwrite")
        done = until_stopped(search, total, unit, console, f"from {log}")
        if done is None:
            return INTERRUPTED
        result, new = done
        if new or not output.exists():
            console.print(f"{output}: {write(result)}", soft_wrap=True)
        else:
            console.print(
                f"{output} is there already, and {log} has all of its search; nothing to do (--overwrite begins anew)",
                soft_wrap=True,
            )
        return 0


def check_output(output: Path) -> None:
    """Make sure that a maneuver file can be written there, before minutes are spent on it."""
    if output.parent.is_dir() and not os.access(output.parent, os.W_OK):
        raise InputError(f"--output is {output}; allowed: a file in a folder that may be written")
    if output.suffix != ".yaml" or not output.parent.is_dir():
        raise InputError(f"--output is {output}; allowed: a .yaml file in a folder that exists")
    if not output.stem.isidentifier() or output.stem != output.stem.lower():
        raise InputError(f"--output is {output}; allowed: a name of small letters, digits and underscores")


def named(output: Path, description: str, source: str) -> dict[str, str]:
    """Header of a maneuver file: name and title from its path, description and source."""
    title = output.stem.replace("_", " ").capitalize()
    return {"name": output.stem, "title": title, "description": description, "source": source}


def write_found(output: Path, content: dict[str, Any], command: str, design: SearchSettings) -> None:
    """Write a maneuver file below the command that made it.

    Args:
        output: the file.
        content: of the maneuver.
        command: of ``python -m training``.
        design: its fields that are not the defaults are the command's options.
    """
    defaults = {field.name: field.default for field in fields(design)}
    options = [f"--{k.replace('_', '-')} {v}" for k, v in design.about().items() if v != defaults[k]]
    line = " ".join([f"python -m training {command}", f"--output {output.name}", *options])
    text = yaml.safe_dump(content, sort_keys=False, width=110, default_flow_style=None)
    write_text(output, f"# Found, not made by hand, by\n# {line}\n{text}")
