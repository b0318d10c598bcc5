"""The commands ``twin`` and ``refine``."""

from __future__ import annotations

from typing import Annotated, Any

import typer
from rich.console import Console

from jawenv.commands.options import takes_world
from jawenv.errors import InputError
from jawenv.playing.protocol import Array
from jawenv.progress import Progress
from jawenv.seeds import TUNING
from training.search.session import (
    INTERRUPTED,
    ManeuverFile,
    check_output,
    named,
    quiet_console,
    until_stopped,
    write_found,
)

SOURCE = "optimal input design (Goodwin and Payne 1977, chapter 6) by Adam (Kingma and Ba 2015) through the twin"


@takes_world()
def twin(
    world: dict[str, Any],
    patients: Annotated[int, typer.Option(help="How many are compared.", metavar="N")] = 120,
    seed: Annotated[int, typer.Option(help="Of the first.", metavar="N")] = TUNING.start,
) -> None:
    """Compare the differentiable twin with the environment and its filter, after 10 s of perturbed maneuvers."""
    from training.twin.agreement import agreement

    Console(highlight=False, markup=False).print(agreement(world, patients, seed).table(), soft_wrap=True)


def refine(
    output: ManeuverFile,
    refine: Annotated[str, typer.Option(help="Maneuver (name or file) where the search begins.", metavar="M")],
    cohort: Annotated[str, typer.Option(help="Population of the patients.", metavar="NAME")] = "trismus",
    updates: Annotated[int, typer.Option(help="Of the targets.", metavar="N")] = 80,
    patients: Annotated[int, typer.Option(help="New ones in each update.", metavar="N")] = 64,
    horizon_s: Annotated[float, typer.Option(help="Length of the maneuver.", metavar="S")] = 10.0,
    target_discomfort_s: Annotated[float, typer.Option(help="Allowed on average, in 30 s.", metavar="S")] = 0.1,
    learning_rate: Annotated[float, typer.Option(help="First step size of the offsets.")] = 0.03,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace the file.")] = False,
) -> int:
    """Refine a maneuver by the gradient of the differentiable twin, within comfort. Minutes; it is not resumed."""
    options = dict(locals())
    from training.twin.search import DECISION_S, GradientSearch, maneuver_of
    from training.twin.search import refine as search

    check_output(output)
    if output.exists() and not overwrite:
        raise InputError(f"--output: {output} exists already; replace it with --overwrite")
    settings, console = GradientSearch.of(options), quiet_console()

    def work(progress: Progress) -> Array:
        def report(done: int, worst: float, discomfort: float) -> None:
            progress.note("figures", f"log of the largest sd {worst:.3f}, discomfort {discomfort:.3f} s in 30 s")
            progress.advance_to(done)

        return search(settings, report)

    targets = until_stopped(work, updates, "updates", console, "from the beginning")
    if targets is None:
        return INTERRUPTED
    text = f"{refine!r} with its targets varied by gradient for the largest sd of {cohort!r} after {horizon_s:g} s."
    write_found(output, maneuver_of(targets, DECISION_S, named(output, text, SOURCE)), "refine", settings)
    console.print(f"{output}: {horizon_s:g} s", soft_wrap=True)
    return 0
