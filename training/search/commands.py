"""The command ``refine``, which writes maneuver files."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated

import typer
import yaml
from rich.console import Console

from jawenv.base.errors import InputError
from jawenv.base.files import write_text
from jawenv.base.locks import alone
from jawenv.base.progress import Progress

SOURCE = "optimal input design (Goodwin and Payne 1977, chapter 6) by Adam (Kingma and Ba 2015) through the twin"
_INTERRUPTED = 130


def refine(
    output: Annotated[
        Path, typer.Option(metavar="FILE", help="Maneuver file to write; its stem is the maneuver's name.")
    ],
    refine: Annotated[str, typer.Option(metavar="M", help="Maneuver (name or file) where the search begins.")],
    cohort: Annotated[str, typer.Option(metavar="NAME", help="Population of the patients.")] = "trismus",
    updates: Annotated[int, typer.Option(metavar="N", help="Of the targets.", min=1)] = 80,
    patients: Annotated[int, typer.Option(metavar="N", help="New ones in each update.", min=1)] = 64,
    horizon_s: Annotated[float, typer.Option(metavar="S", help="Length of the maneuver.")] = 10.0,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace the file.")] = False,
) -> int:
    """Refine a maneuver by the gradient of the differentiable twin, within comfort. Minutes; it is not resumed."""
    from jawenv.playing.maneuvers.written import maneuver_of_targets
    from training.search.gradient import DECISION_S, search

    _check(output, overwrite)
    console = Console(highlight=False, markup=False, stderr=True)
    with alone(output):
        try:
            with Progress(updates, "updates", console) as progress:

                def report(done: int, worst: float, discomfort: float) -> None:
                    progress.note(
                        "figures", f"log of the largest sd {worst:.3f}, discomfort {discomfort:.3f} s in 30 s"
                    )
                    progress.advance_to(done)

                targets = search(refine, cohort, updates, patients, horizon_s, report)
        except KeyboardInterrupt:
            console.print("stopped; the same command begins anew", soft_wrap=True)
            return _INTERRUPTED
        header = {
            "name": output.stem,
            "title": output.stem.replace("_", " ").capitalize(),
            "description": f"{Path(refine).stem!r} with its targets varied by gradient for the largest sd of "
            f"{cohort!r} after {horizon_s:g} s.",
            "source": SOURCE,
        }
        content = maneuver_of_targets(targets, DECISION_S, header).model_dump(
            mode="json", exclude_none=True, exclude_defaults=True
        )
        text = yaml.safe_dump(content, sort_keys=False, width=110, default_flow_style=None)
        options = (
            f"--refine {refine} --cohort {cohort} --updates {updates} --patients {patients} --horizon-s {horizon_s:g}"
        )
        command = f"python -m training refine --output {output.name} {options}"
        write_text(output, f"# Found, not made by hand, by\n# {command}\n{text}")
        console.print(f"{output}: {horizon_s:g} s", soft_wrap=True)
        return 0


def _check(output: Path, overwrite: bool) -> None:
    """Make sure that a maneuver file can be written there, before minutes are spent on it."""
    if output.parent.is_dir() and not os.access(output.parent, os.W_OK):
        raise InputError(f"--output is {output}; allowed: a file in a folder that may be written")
    if output.suffix != ".yaml" or not output.parent.is_dir():
        raise InputError(f"--output is {output}; allowed: a .yaml file in a folder that exists")
    if not output.stem.isidentifier() or output.stem != output.stem.lower():
        raise InputError(f"--output is {output}; allowed: a name of small letters, digits and underscores")
    if output.exists() and not overwrite:
        raise InputError(f"--output: {output} exists already; replace it with --overwrite")
