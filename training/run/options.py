"""Options that commands have in common."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

Config = Annotated[
    str | None,
    typer.Argument(metavar="CONFIG", help="A shipped configuration (ppo, sac, tqc, ...) or a YAML file."),
]
Environment = Annotated[
    str | None,
    typer.Option("--env", metavar="NAME", help="Environment: jawenv/JawSides-v3, or JawSides, or sides."),
]
ResidualOn = Annotated[
    str | None,
    typer.Option(metavar="MANEUVER", help="Train a correction of this maneuver (name or file)."),
]
Reward = Annotated[
    str | None,
    typer.Option(metavar="NAME", help="What is paid for: mixed, worst, uncertainty, score or bound."),
]
TargetDiscomfort = Annotated[
    float | None,
    typer.Option(metavar="S", help="Discomfort allowed on average, s in 30 s; its price is then learned."),
]
Output = Annotated[
    Path | None,
    typer.Option(metavar="FOLDER", help="Folder of the run; default runs/CONFIG[-ENV]-seedSEED."),
]
Steps = Annotated[
    int | None,
    typer.Option(metavar="N", help="Environment steps to train for, over all worlds."),
]
Seed = Annotated[int | None, typer.Option(metavar="N", help="Seed; equal seeds give equal policies.")]
Seeds = Annotated[
    str | None,
    typer.Option(metavar="LIST", help="Several seeds, 0-4 or 0,1,2, each into OUTPUT-seedK; finished ones are left."),
]
Worlds = Annotated[int | None, typer.Option(metavar="N", help="Worlds stepped at once.")]
Device = Annotated[str | None, typer.Option(metavar="NAME", help="Where the network runs: cpu, cuda, ...")]
Resume = Annotated[
    Path | None,
    typer.Option(metavar="RUN", help="Go on with the run in this folder, from its latest checkpoint."),
]
Continue = Annotated[
    bool,
    typer.Option("--continue", help="Go on with the run in the output folder if there is one; else start it."),
]
Overwrite = Annotated[bool, typer.Option("--overwrite", help="Replace the run in the output folder.")]
Runs = Annotated[list[Path], typer.Argument(metavar="RUN...", help="Run folders; those of several seeds are averaged.")]
Figure = Annotated[Path, typer.Option(metavar="FILE", help="The picture to write, a .png.")]
Trials = Annotated[int, typer.Option(metavar="N", help="Trials that the study shall have in the end.")]
Storage = Annotated[
    str,
    typer.Option(metavar="URL", help="Database of the study: sqlite:///runs/tune.db, postgresql://..., mysql://..."),
]
Study = Annotated[str | None, typer.Option(metavar="NAME", help="Name of the study; default the configuration's.")]
