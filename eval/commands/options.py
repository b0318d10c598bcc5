"""The common ground of commands: options, the terminal, and the command as typed."""

from __future__ import annotations

import os
import shlex
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from jawenv.base.seeds import REPORTS
from jawenv.commands.options import takes_together as takes_together
from jawenv.commands.options import takes_world as takes_world

ENTRIES = "Names, maneuver files, training runs, exported policies, or agents of your own as package.module:Name."

Entry = Annotated[str, typer.Argument(metavar="MANEUVER|FILE|RUN", help="A name, a maneuver file or a training run.")]
OneOrTwo = Annotated[
    list[str],
    typer.Argument(metavar="MANEUVER|FILE|RUN ...", help="A name, a maneuver file or a training run; or two of these."),
]
Patients = Annotated[int, typer.Option(help="How many; the same for all that is compared.", metavar="N")]
Seed = Annotated[int, typer.Option(help="Of the first patient and its noise.", metavar="N")]
Output = Annotated[Path, typer.Option(help="Folder of results and report.", metavar="FOLDER")]
Fresh = Annotated[bool, typer.Option("--fresh", help="Compute again what the folder already holds.")]
Workers = Annotated[int | None, typer.Option(help="Processes; all cores by default.", metavar="N", min=1)]
Trust = Annotated[
    bool,
    typer.Option("--trust", help="Unpickle checkpoints (.zip): they can run code as they load."),
]
Reference = Annotated[
    str | None, typer.Option(help="Entry that the others are compared with; the best by default.", metavar="NAME")
]
LargestDiscomfort = Annotated[
    float, typer.Option(help="Mean discomfort, s per 30 s, up to which an entry is ranked.", metavar="S")
]
LargestViolation = Annotated[
    float, typer.Option(help="Share of episodes crossing a hard limit up to which an entry is ranked.", metavar="SHARE")
]


@dataclass(frozen=True)
class Played:
    """Patients of a command, and the folder of its results."""

    output: Output
    patients: Patients = 64
    seed: Seed = REPORTS[0].start
    fresh: Fresh = False
    trust: Trust = False


@dataclass(frozen=True)
class Ranked:
    """Limits of a ranking, and its reference."""

    reference: Reference = None
    largest_discomfort_s: LargestDiscomfort = 0.1
    largest_violation: LargestViolation = 0.01


class _Terminal(Console):
    """A console that goes on in silence when its reader has left, as ``head`` does: the results are still written."""

    def on_broken_pipe(self) -> None:
        """See rich."""
        self.quiet = True
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def terminal() -> Console:
    """A terminal of its own width, or a log wide enough for the tables."""
    return _Terminal(highlight=False, width=None if sys.stdout.isatty() else 120)


def typed() -> str:
    """The command as it was given, for the results."""
    return shlex.join(["python", "-m", "eval", *sys.argv[1:]])
