"""What several commands of ``jawenv`` ask for in the same words."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Annotated, Any

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
Comfort = Annotated[
    Path | None, typer.Option(help="File of comfort limits that differ from the default's.", metavar="FILE")
]
Anatomy = Annotated[
    Path | None,
    typer.Option(help="File of attachments, mandible and fossa that differ from the default's.", metavar="FILE"),
]
ForceSensor = Annotated[
    str,
    typer.Option("--force-sensor", help="How the device knows its force: cell, motors or straps.", metavar="NAME"),
]


def own_comfort_and_anatomy(comfort: Path | None, anatomy: Path | None) -> dict[str, Any]:
    """What the files of ``--comfort`` and ``--anatomy`` say, as the environment takes it; nothing where none is given.

    Mappings, not paths: what is kept with results stays what was played, whatever becomes of the files.

    Raises:
        InputError: a file cannot be read or is damaged, or says what is not allowed.
    """
    from jawenv.anatomy import Anatomy as OwnAnatomy
    from jawenv.device.comfort_settings import Comfort as OwnComfort

    own: dict[str, Any] = {}
    if comfort is not None:
        own["comfort"] = _checked(comfort, OwnComfort.from_dict)
    if anatomy is not None:
        own["anatomy"] = _checked(anatomy, OwnAnatomy.from_dict)
    return own


def _checked(file: Path, build: Callable[[Mapping[str, Any]], object]) -> dict[str, Any]:
    """The mapping in a file that ``build`` takes."""
    from jawenv.files import read_into

    def said(data: Mapping[str, Any]) -> dict[str, Any]:
        build(data)
        return dict(data)

    return read_into(file, said)
