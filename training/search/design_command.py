"""``python -m training design``: design a maneuver second by second and write its file."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from jawenv.progress import Progress
from training.search.session import Anew, ManeuverFile, check_output, named, search_maneuver, write_found

if TYPE_CHECKING:
    from jawenv.playing.maneuvers import Maneuver


def design(
    output: ManeuverFile,
    cohort: Annotated[str, typer.Option(help="Population of the patients.", metavar="NAME")] = "trismus",
    horizon_s: Annotated[float, typer.Option(help="Length of the maneuver.", metavar="S")] = 10.0,
    goal: Annotated[str, typer.Option(help="What shall grow: mixed, worst or uncertainty (as the rewards).")] = "mixed",
    over: Annotated[str, typer.Option(help="mean of the patients, or tail (the worst third).")] = "mean",
    patients: Annotated[int, typer.Option(help="Patients that each plan is tried on.", metavar="N")] = 24,
    look_ahead_s: Annotated[float, typer.Option(help="How far a plan looks.", metavar="S")] = 3.0,
    candidates: Annotated[int, typer.Option(help="Sequences tried in a round.", metavar="N")] = 48,
    rounds: Annotated[int, typer.Option(help="Rounds of a plan.", metavar="N")] = 5,
    comfort_weight: Annotated[float, typer.Option(help="Nats that a second of discomfort is worth.")] = 60.0,
    seed: Annotated[int, typer.Option(help="Of the search.", metavar="N")] = 0,
    overwrite: Anew = False,
) -> int:
    """Design an open-loop maneuver second by second: all patients are moved alike, by the plan that teaches most.

    A few minutes for 10 s of a maneuver. Comfort is a price here; `optimise` has it as a constraint. A design that was
    stopped goes on when the same command is given again. The plans so far stand beside the file, in NAME.search.txt.
    """
    given = dict(locals())
    from training.search.sequential import SequentialDesign, design_maneuver

    check_output(output)
    wanted = SequentialDesign.of(given)
    description = (
        f"Designed second by second: each plan is the one after which {patients} patients of {cohort!r} "
        f"are known best{', the least known third of them counting,' if over == 'tail' else ''} within comfort."
    )
    source = "receding-horizon input design (Goodwin and Payne 1977, chapter 6) by random search"
    about = named(output, description, source)

    def search(log: Path, progress: Progress) -> tuple[Maneuver, bool]:
        def report(done: int, planned_now: bool) -> None:
            if planned_now:
                progress.advance_to(done)
            else:
                progress.skip(1)

        maneuver, plans_made = design_maneuver(wanted, about, log, report)
        return maneuver, plans_made > 0

    def write(maneuver: Maneuver) -> str:
        write_found(output, maneuver.model_dump(mode="json", exclude_none=True), "design", wanted)
        return f"{horizon_s:g} s"

    return search_maneuver(output, overwrite, wanted.steps, "steps of the maneuver", search, write)
