"""``python -m training optimise``: search a maneuver and write its file."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from jawenv.controls import DEFAULT_CONTROL
from jawenv.ladder import env_id_of, title_of_env
from jawenv.progress import Progress
from training.search.session import Anew, ManeuverFile, check_output, named, search_maneuver, write_found

if TYPE_CHECKING:
    from training.search.optimise import Design

SOURCE = "optimal input design (Goodwin and Payne 1977, chapter 6) by CMA-ES (Hansen and Ostermeier 2001)"
CRITERIA = {"worst": "the largest sd", "D": "the determinant of the covariance", "A": "the mean variance"}
OVER = {
    "mean": "on average over {patients} patients",
    "tail": "of those third of {patients} patients who are known least",
    "nominal": "of the patient with the medians of the cohort",
}


def optimise(
    output: ManeuverFile,
    cohort: Annotated[str, typer.Option(help="Population of the patients.", metavar="NAME")] = "trismus",
    control: Annotated[str, typer.Option(help="force, trajectory or targets.", metavar="NAME")] = DEFAULT_CONTROL,
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
    env: Annotated[str, typer.Option(help="Environment: Jaw, JawImaged, ...", metavar="NAME")] = "Jaw",
    overwrite: Anew = False,
) -> int:
    """Search the open-loop maneuver after which the parameters are known best, within comfort.

    A search that was stopped goes on when the same command is given again. The losses so far stand beside the file,
    in NAME.search.txt. Two sines on each of the four channels are searched; with --refine, offsets of a maneuver's
    targets, one for each channel and 0.4 s.
    """
    given = dict(locals())
    from training.search.optimise import Design, Found, search

    check_output(output)
    design = Design.of(given)

    def run(log: Path, progress: Progress) -> tuple[Found, bool]:
        def report(done: int, found: Found) -> None:
            progress.note("best", f"best loss {found.judged.loss:.3f}")
            progress.advance_to(done)

        found = search(design, log, report)
        return found, progress.done > 0

    def write(found: Found) -> str:
        about = named(output, _description(design), SOURCE)
        content = (
            design.form()
            .maneuver(found.numbers, about)
            .model_dump(mode="json", exclude_none=True, exclude_defaults=True)
        )
        write_found(output, content, "optimise", design)
        judged = found.judged
        return (
            f"largest sd {100.0 * judged.worst_sd:.2f} % after {horizon_s:g} s (median of the search's own "
            f"patients), discomfort {judged.discomfort_s:.3f} s, governor {judged.governor:.1%}, "
            f"hard limits crossed by {judged.violated:.0%}" + ("" if judged.feasible else "; NOT within comfort")
        )

    return search_maneuver(output, overwrite, generations, "generations", run, write)


def _description(design: Design) -> str:
    searched = (
        f"{Path(design.refine).stem!r} with its targets varied"
        if design.refine
        else "Two sines on opening, side, fore-aft force and roll,"
    )
    return (
        f"{searched} by CMA-ES for {CRITERIA[design.criterion]} "
        f"{OVER[design.over].format(patients=design.patients)} of {design.cohort!r}, {design.horizon_s:g} s after "
        f"the start, within comfort, in {design.control} control."
        + (f" Played in {title_of_env(env_id_of(design.env))}." if design.env != "Jaw" else "")
        + (f" Then {Path(design.then).stem!r}." if design.then else "")
    )
