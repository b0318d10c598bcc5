"""Options that commands have in common."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

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
Details = Annotated[bool, typer.Option("--details", help="Print all entries, and all tables of them.")]
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
