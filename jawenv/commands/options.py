"""What several commands of ``jawenv`` ask for in the same words."""

from __future__ import annotations

from typing import Annotated

import typer

Maneuver = Annotated[
    str, typer.Argument(metavar="MANEUVER|FILE", help="A name of `jawenv list maneuvers`, or a maneuver file.")
]
Model = Annotated[str, typer.Option(help="One of `jawenv list models`.", metavar="NAME")]
Cohort = Annotated[str, typer.Option(help="One of `jawenv list cohorts`, or a cohort file.", metavar="NAME")]
Seed = Annotated[int, typer.Option(help="Of the first patient and its noise.", metavar="N")]
Control = Annotated[str, typer.Option(help="force, trajectory or targets.", metavar="NAME")]
Known = Annotated[
    str,
    typer.Option("--knowledge", help="What the filter knows of anatomy and device: exact or imaged.", metavar="NAME"),
]
EpisodeS = Annotated[float, typer.Option("--episode-s", help="Length of an episode, s.", metavar="S")]
