"""The commands ``optimise`` and ``refine``, which write maneuver files, and ``twin``, by which ``refine`` goes."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.console import Console

from jawenv.base.errors import InputError
from jawenv.base.progress import Progress
from jawenv.base.seeds import TUNING
from jawenv.commands.options import takes_world
from jawenv.ladder import env_id_of, title_of_env
from jawenv.playing.agents import Array
from training.search.session import (
    INTERRUPTED,
    Anew,
    ManeuverFile,
    check_output,
    named,
    quiet_console,
    search_maneuver,
    until_stopped,
    write_found,
)
from training.search.settings import GradientSearch, Refinement, takes

if TYPE_CHECKING:
    from training.search.optimise import Found

Overwrite = Annotated[bool, typer.Option("--overwrite", help="Replace the file.")]
SOURCE = "optimal input design (Goodwin and Payne 1977, chapter 6) by CMA-ES (Hansen and Ostermeier 2001)"
BY_GRADIENT = "optimal input design (Goodwin and Payne 1977, chapter 6) by Adam (Kingma and Ba 2015) through the twin"
CRITERIA = {"worst": "the largest sd", "D": "the determinant of the covariance", "A": "the mean variance"}
OVER = {
    "mean": "on average over {patients} patients",
    "tail": "of those third of {patients} patients who are known least",
    "nominal": "of the patient with the medians of the cohort",
}


@takes(Refinement)
def optimise(output: ManeuverFile, settings: Refinement, overwrite: Anew = False) -> int:
    """Refine a maneuver until the parameters are known best after it, within comfort.

    What is searched are offsets of its targets, one for each channel and 0.4 s. A search that was stopped goes on when
    the same command is given again. What it has found so far stands beside the file, in NAME.search.pkl, which is
    unpickled: that can run code, so let nobody else put one there.
    """
    from training.search.optimise import knots_of, search

    check_output(output)
    log = output.with_suffix(".search.pkl")

    def run(progress: Progress) -> tuple[Found, bool]:
        def report(done: int, lowest: float) -> None:
            progress.note("best", f"best loss {lowest:.3f}")
            progress.advance_to(done)

        result = search(settings, log, report)
        return result, progress.done > 0

    def write(result: Found) -> str:
        header = named(output, _description(settings), SOURCE)
        content = (
            knots_of(settings)
            .maneuver(result.numbers, header)
            .model_dump(mode="json", exclude_none=True, exclude_defaults=True)
        )
        write_found(output, content, "optimise", settings)
        judged = result.judged
        return (
            f"largest sd {100.0 * judged.worst_sd:.2f} % after {settings.horizon_s:g} s (median of the search's own "
            f"patients), discomfort {judged.discomfort_s:.3f} s, governor {judged.governor:.1%}, "
            f"hard limits crossed by {judged.violated:.0%}" + ("" if judged.feasible else "; NOT within comfort")
        )

    return search_maneuver(output, log, overwrite, settings.generations, "generations", run, write)


def _description(design: Refinement) -> str:
    return (
        f"{Path(design.refine).stem!r} with its targets varied by CMA-ES for {CRITERIA[design.criterion]} "
        f"{OVER[design.over].format(patients=design.patients)} of {design.cohort!r}, {design.horizon_s:g} s after "
        f"the start, within comfort, in {design.control} control."
        + (f" Played in {title_of_env(env_id_of(design.env))}." if design.env != "Jaw" else "")
    )


@takes_world()
def twin(
    world: dict[str, Any],
    patients: Annotated[int, typer.Option(help="How many are compared.", metavar="N")] = 120,
    seed: Annotated[int, typer.Option(help="Of the first.", metavar="N")] = TUNING.start,
    agent: Annotated[
        str | None, typer.Option(help="Agent on whose path they are compared.", metavar="MANEUVER|FILE|RUN")
    ] = None,
) -> None:
    """Compare the differentiable twin with the environment and its filter, over 10 s of maneuvers or an agent."""
    from training.search.agreement import agreement

    Console(highlight=False, markup=False).print(agreement(world, patients, seed, agent).table(), soft_wrap=True)


@takes(GradientSearch)
def refine(output: ManeuverFile, settings: GradientSearch, overwrite: Overwrite = False) -> int:
    """Refine a maneuver by the gradient of the differentiable twin, within comfort. Minutes; it is not resumed."""
    from jawenv.playing.maneuvers.written import maneuver_of_targets
    from training.search.gradient import DECISION_S
    from training.search.gradient import refine as search

    check_output(output)
    if output.exists() and not overwrite:
        raise InputError(f"--output: {output} exists already; replace it with --overwrite")
    console = quiet_console()

    def work(progress: Progress) -> Array:
        def report(done: int, worst: float, discomfort: float) -> None:
            progress.note("figures", f"log of the largest sd {worst:.3f}, discomfort {discomfort:.3f} s in 30 s")
            progress.advance_to(done)

        return search(settings, report)

    targets = until_stopped(work, settings.updates, "updates", console, "from the beginning")
    if targets is None:
        return INTERRUPTED
    whose = f"of {settings.cohort!r} after {settings.horizon_s:g} s"
    text = f"{settings.refine!r} with its targets varied by gradient for the largest sd {whose}."
    found = maneuver_of_targets(targets, DECISION_S, named(output, text, BY_GRADIENT))
    content = found.model_dump(mode="json", exclude_none=True, exclude_defaults=True)
    write_found(output, content, "refine", settings)
    console.print(f"{output}: {settings.horizon_s:g} s", soft_wrap=True)
    return 0
