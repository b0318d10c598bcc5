"""``python -m training optimise``: search a maneuver and write its file."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated, Any

import typer
import yaml
from rich.console import Console

from jawenv.controls import DEFAULT_CONTROL
from jawenv.errors import InputError
from jawenv.files import atomic_write
from jawenv.locks import alone
from jawenv.progress import Progress

Output = Annotated[Path, typer.Option(metavar="FILE", help="Maneuver file to write; its stem is the maneuver's name.")]
Overwrite = Annotated[
    bool, typer.Option("--overwrite", help="Replace the file, and begin anew where a search was left off.")
]
CRITERIA = {"worst": "the largest sd", "D": "the determinant of the covariance", "A": "the mean variance"}
OVER = {
    "mean": "on average over {patients} patients",
    "tail": "of those third of {patients} patients who are known least",
    "nominal": "of the patient with the medians of the cohort",
}


def optimise(
    output: Output,
    cohort: Annotated[str, typer.Option(help="Population of the patients.", metavar="NAME")] = "trismus",
    control: Annotated[str, typer.Option(help="force, trajectory or targets.")] = DEFAULT_CONTROL,
    horizon_s: Annotated[float, typer.Option(help="Length of an episode.", metavar="S")] = 10.0,
    criterion: Annotated[str, typer.Option(help="worst (the largest sd), D (determinant) or A (trace).")] = "worst",
    over: Annotated[str, typer.Option(help="mean of the patients, tail (the worst third) or nominal.")] = "mean",
    patients: Annotated[int, typer.Option(help="Patients that each candidate is played with.", metavar="N")] = 12,
    generations: Annotated[int, typer.Option(help="Generations of CMA-ES.", metavar="N")] = 120,
    population: Annotated[int, typer.Option(help="Candidates in a generation.", metavar="N")] = 14,
    sigma: Annotated[float, typer.Option(help="First step size, of numbers from 0 to 1.")] = 0.12,
    refine: Annotated[str, typer.Option(help="Maneuver (name or file) whose targets are varied.", metavar="M")] = "",
    then: Annotated[str, typer.Option(help="Maneuver that follows a refined one after the horizon.", metavar="M")] = "",
    seed: Annotated[int, typer.Option(help="Of the search.", metavar="N")] = 0,
    overwrite: Overwrite = False,
) -> int:
    """Search the open-loop maneuver after which the parameters are known best, within comfort.

    A search that was stopped goes on when the same command is given again. The losses so far stand beside the file,
    in NAME.search.txt. Two sines on each of the four channels are searched; with --refine, offsets of a maneuver's
    targets, one for each channel and 0.4 s.
    """
    from training.search.optimise import Design, search

    check_output(output)
    settings: dict[str, Any] = {
        "cohort": cohort,
        "control": control,
        "horizon_s": horizon_s,
        "criterion": criterion,
        "over": over,
        "patients": patients,
        "generations": generations,
        "population": population,
        "sigma": sigma,
        "refine": refine,
        "then": then,
        "seed": seed,
    }
    design = Design(**settings)
    with alone(output):
        log = search_log(output, overwrite)
        console = Console(highlight=False, markup=False, stderr=True)
        try:
            with Progress(generations, "generations", console) as progress:

                def report(done: int, found: Any) -> None:
                    progress.note("best", f"best loss {found.judged.loss:.3f}")
                    progress.advance_to(done)

                found = search(design, log, report)
        except KeyboardInterrupt:
            console.print(f"stopped; the same command goes on from {log}", soft_wrap=True)
            return 130
        if progress.done == 0 and output.exists():
            console.print(already_done(output, log), soft_wrap=True)
            return 0
        _write(output, design, found)
        judged = found.judged
        console.print(
            f"{output}: largest sd {100.0 * judged.worst_sd:.2f} % after {horizon_s:g} s (median of the search's own "
            f"patients), discomfort {judged.discomfort_s:.3f} s, governor {judged.governor:.1%}, "
            f"hard limits crossed by {judged.violated:.0%}" + ("" if judged.feasible else "; NOT within comfort"),
            soft_wrap=True,
        )
        return 0


def _write(output: Path, design: Any, found: Any) -> None:
    """The maneuver file, with the command that made it."""
    searched = (
        f"{Path(design.refine).stem!r} with its targets varied"
        if design.refine
        else "Two sines on opening, side, fore-aft force and roll,"
    )
    about = {
        "name": output.stem,
        "title": title_of(output),
        "description": (
            f"{searched} by CMA-ES for {CRITERIA[design.criterion]} "
            f"{OVER[design.over].format(patients=design.patients)} of {design.cohort!r}, {design.horizon_s:g} s after "
            f"the start, within comfort, in {design.control} control."
            + (f" Then {Path(design.then).stem!r}." if design.then else "")
        ),
        "source": "optimal input design (Goodwin and Payne 1977, chapter 6) by CMA-ES (Hansen and Ostermeier 2001)",
    }
    maneuver = design.form().maneuver(found.numbers, about)
    write_found(output, maneuver.model_dump(mode="json", exclude_none=True, exclude_defaults=True), "optimise", design)


def check_output(output: Path) -> None:
    """Make sure that a maneuver file can be written there, before minutes are spent on it.

    Raises:
        InputError: another ending than .yaml, a folder that does not exist or may not be written, or a stem that is no
            maneuver's name.
    """
    if output.parent.is_dir() and not os.access(output.parent, os.W_OK):
        raise InputError(f"--output: {output} given, but {output.parent} may not be written")
    if output.suffix != ".yaml" or not output.parent.is_dir():
        raise InputError(f"--output: {output} given, allowed is a .yaml file in a folder that exists")
    if not output.stem.isidentifier() or output.stem != output.stem.lower():
        raise InputError(f"--output: {output.stem!r} is no name; allowed: small letters, digits and underscores")


def search_log(output: Path, overwrite: bool) -> Path:
    """The file beside a maneuver file that keeps what its search has found so far.

    Args:
        output: the maneuver file.
        overwrite: begin anew, without what is kept.

    Raises:
        InputError: the maneuver file exists, and no search that could go on has left it.
    """
    log = output.with_suffix(".search.txt")
    if overwrite:
        log.unlink(missing_ok=True)
    elif output.exists() and not log.exists():
        raise InputError(f"--output: {output} exists already; replace it with --overwrite")
    return log


def already_done(output: Path, log: Path) -> str:
    """What a command says that is given again after its search is done."""
    return f"{output} is there already, and {log} has all of its search; nothing to do (--overwrite begins anew)"


def title_of(output: Path) -> str:
    """A maneuver's title, from the name of its file."""
    return output.stem.replace("_", " ").capitalize()


def write_found(output: Path, content: dict[str, Any], command: str, design: Any) -> None:
    """Write a maneuver file whose first lines are the command that made it.

    Args:
        output: the file.
        content: of the maneuver.
        command: of ``python -m training``.
        design: its fields that are not the defaults are the command's options.
    """
    defaults = type(design)().about()
    options = [f"--{k.replace('_', '-')} {v}" for k, v in design.about().items() if v != defaults[k]]
    line = " ".join([f"python -m training {command}", f"--output {output.name}", *options])
    text = yaml.safe_dump(content, sort_keys=False, width=110, default_flow_style=None)
    with atomic_write(output) as unfinished:
        unfinished.write_text(f"# Found, not made by hand, by\n# {line}\n{text}", encoding="utf-8")
