"""What several commands ask for in the same words."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import Annotated, Any

import typer

from jawenv.commands import options as common
from jawenv.errors import InputError

ENTRIES = "Names, maneuver files, training runs, exported policies, or agents of your own as package.module:Name."

Entry = Annotated[str, typer.Argument(metavar="MANEUVER|FILE|RUN", help="A name, a maneuver file or a training run.")]
OneOrTwo = Annotated[
    list[str],
    typer.Argument(metavar="MANEUVER|FILE|RUN ...", help="A name, a maneuver file or a training run; or two of these."),
]
Environment = Annotated[
    str | None,
    typer.Option(
        "--env",
        help="Environment: jawenv/JawSides-v2, or JawSides, or sides; that of the trained runs by default.",
        metavar="NAME",
    ),
]
EnvironmentOrJaw = Annotated[
    str, typer.Option("--env", help="Environment: jawenv/JawSides-v2, or JawSides, or sides.", metavar="NAME")
]
EpisodeS = Annotated[float, typer.Option("--episode-s", help="Length of every episode, s.", metavar="S")]
Patients = Annotated[int, typer.Option(help="How many; the same for all that is compared.", metavar="N")]
Seed = Annotated[int, typer.Option(help="Of the first patient and its noise.", metavar="N")]
Cohort = Annotated[str, typer.Option(help="Population the patients are drawn from.", metavar="NAME")]
Control = Annotated[
    str, typer.Option(help="force, trajectory or targets; a trained run keeps its own.", metavar="NAME")
]
Sensors = Annotated[str, typer.Option(help="pose or point; a trained run keeps its own.", metavar="NAME")]
Output = Annotated[Path, typer.Option(help="Folder of results and report.", metavar="FOLDER")]
Fresh = Annotated[bool, typer.Option("--fresh", help="Compute again what the folder already holds.")]
Details = Annotated[bool, typer.Option("--details", help="Print all entries, and all tables of them.")]
Trust = Annotated[
    bool,
    typer.Option("--trust", help="Unpickle checkpoints that lie in no run's folder: they can run code as they load."),
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
Effects = Annotated[
    list[str] | None,
    typer.Option(
        "--reality",
        help="Effect that the filter does not know, as creep_share=0.3; may be repeated.",
        metavar="FIELD=VALUE",
    ),
]
Changes = Annotated[
    list[str] | None,
    typer.Option(
        "--device",
        help="Another value of a field of the device, as cell_force_N=0.2; may be repeated.",
        metavar="FIELD=VALUE",
    ),
]
Believed = Annotated[
    str | None,
    typer.Option(
        "--estimator",
        help="midline: the filter takes a jaw with two condyles for one with a single point on the fossa.",
        metavar="NAME",
    ),
]
Known = Annotated[
    str,
    typer.Option(
        "--knowledge",
        help="What the filter knows of anatomy and device: exact, imaged, or a file of sds.",
        metavar="NAME",
    ),
]

Comfort = common.Comfort
Anatomy = common.Anatomy
ForceSensor = common.ForceSensor


def world(
    reality: list[str] | None = None,
    device: list[str] | None = None,
    estimator: str | None = None,
    knowledge: str = "exact",
    comfort: Path | None = None,
    anatomy: Path | None = None,
    force_sensor: str = "cell",
) -> dict[str, Any]:
    """What these options say of the world and of what the filter knows of it, as `Settings` takes it.

    Raises:
        InputError: a text is no field with a number, a file cannot be read, or a value is not allowed.
    """
    return {
        "reality": effects(reality),
        "device": changes(device),
        "estimator": estimator,
        "knowledge": known_within(knowledge),
        "force_sensor": force_sensor,
        **common.own_comfort_and_anatomy(comfort, anatomy),
    }


def known_within(given: str) -> dict[str, float]:
    """The sds that a name or a file says, those above 0.

    Raises:
        InputError: there is no such name or file, or it is damaged.
    """
    from jawenv.anatomy.knowledge import knowledge

    return {name: value for name, value in asdict(knowledge(given)).items() if value > 0.0}


def effects(texts: list[str] | None) -> dict[str, float]:
    """The effects that ``--reality`` gives, as `Settings` takes them.

    Raises:
        InputError: a text is no field with a number.
    """
    return _fields("reality", texts, "creep_share=0.3")


def changes(texts: list[str] | None) -> dict[str, float]:
    """The fields of the device that ``--device`` gives, as `Settings` takes them.

    Raises:
        InputError: a text is no field with a number.
    """
    return _fields("device", texts, "cell_force_N=0.2")


def _fields(option: str, texts: list[str] | None, example: str) -> dict[str, float]:
    fields = {}
    for text in texts or []:
        name, _, value = text.partition("=")
        try:
            fields[name] = float(value)
        except ValueError:
            raise InputError(f"{option}: {text!r} given, allowed is FIELD=VALUE with a number, as {example}") from None
    return fields
