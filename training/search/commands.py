"""The commands ``design`` and ``optimise``, which write maneuver files, and ``distill``, which trains a policy."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
import yaml
from rich.console import Console

from jawenv.commands.options import takes_world
from jawenv.controls import DEFAULT_CONTROL
from jawenv.errors import InputError
from jawenv.files import read_model, validate, write_text
from jawenv.ladder import env_id_of, title_of_env
from jawenv.locks import alone
from jawenv.progress import Progress
from training.run.options import Config, Output, Overwrite, ResidualOn, Reward, Seed
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

if TYPE_CHECKING:
    from jawenv.playing.maneuvers import Maneuver
    from training.run.config import TrainingConfig
    from training.run.folder import RunFolder
    from training.search.distill import Distillation
    from training.search.optimise import Found, Refinement

SOURCE = "optimal input design (Goodwin and Payne 1977, chapter 6) by CMA-ES (Hansen and Ostermeier 2001)"
CRITERIA = {"worst": "the largest sd", "D": "the determinant of the covariance", "A": "the mean variance"}
OVER = {
    "mean": "on average over {patients} patients",
    "tail": "of those third of {patients} patients who are known least",
    "nominal": "of the patient with the medians of the cohort",
}


def optimise(
    output: ManeuverFile,
    refine: Annotated[str, typer.Option(help="Maneuver (name or file) whose targets are varied.", metavar="M")],
    cohort: Annotated[str, typer.Option(help="Population of the patients.", metavar="NAME")] = "trismus",
    control: Annotated[str, typer.Option(help="force, trajectory or targets.", metavar="NAME")] = DEFAULT_CONTROL,
    horizon_s: Annotated[float, typer.Option(help="Length of an episode.", metavar="S")] = 10.0,
    criterion: Annotated[str, typer.Option(help="worst (the largest sd), D (determinant) or A (trace).")] = "worst",
    over: Annotated[str, typer.Option(help="mean of the patients, tail (the worst third) or nominal.")] = "mean",
    patients: Annotated[int, typer.Option(help="Patients that each candidate is played with.", metavar="N")] = 12,
    generations: Annotated[int, typer.Option(help="Generations of CMA-ES.", metavar="N")] = 120,
    population: Annotated[int, typer.Option(help="Candidates in a generation.", metavar="N")] = 14,
    sigma: Annotated[float, typer.Option(help="First step size of the offsets.")] = 0.12,
    then: Annotated[str, typer.Option(help="Maneuver that follows after the horizon.", metavar="M")] = "",
    seed: Annotated[int, typer.Option(help="Of the search.", metavar="N")] = 0,
    env: Annotated[str, typer.Option(help="Environment: Jaw, JawImaged, ...", metavar="NAME")] = "Jaw",
    overwrite: Anew = False,
) -> int:
    """Refine a maneuver until the parameters are known best after it, within comfort.

    What is searched are offsets of its targets, one for each channel and 0.4 s. A search that was stopped goes on when
    the same command is given again. What it has found so far stands beside the file, in NAME.search.pkl, which is
    unpickled: that can run code, so let nobody else put one there.
    """
    options = dict(locals())
    from training.search.optimise import Refinement, search

    check_output(output)
    design, log = Refinement.of(options), output.with_suffix(".search.pkl")

    def run(progress: Progress) -> tuple[Found, bool]:
        def report(done: int, lowest: float) -> None:
            progress.note("best", f"best loss {lowest:.3f}")
            progress.advance_to(done)

        result = search(design, log, report)
        return result, progress.done > 0

    def write(result: Found) -> str:
        header = named(output, _description(design), SOURCE)
        content = (
            design.knots()
            .maneuver(result.numbers, header)
            .model_dump(mode="json", exclude_none=True, exclude_defaults=True)
        )
        write_found(output, content, "optimise", design)
        judged = result.judged
        return (
            f"largest sd {100.0 * judged.worst_sd:.2f} % after {horizon_s:g} s (median of the search's own "
            f"patients), discomfort {judged.discomfort_s:.3f} s, governor {judged.governor:.1%}, "
            f"hard limits crossed by {judged.violated:.0%}" + ("" if judged.feasible else "; NOT within comfort")
        )

    return search_maneuver(output, log, overwrite, generations, "generations", run, write)


def _description(design: Refinement) -> str:
    return (
        f"{Path(design.refine).stem!r} with its targets varied by CMA-ES for {CRITERIA[design.criterion]} "
        f"{OVER[design.over].format(patients=design.patients)} of {design.cohort!r}, {design.horizon_s:g} s after "
        f"the start, within comfort, in {design.control} control."
        + (f" Played in {title_of_env(env_id_of(design.env))}." if design.env != "Jaw" else "")
        + (f" Then {Path(design.then).stem!r}." if design.then else "")
    )


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
    stopped goes on when the same command is given again. The plans so far stand beside the file, in NAME.search.npz.
    """
    options = dict(locals())
    from training.search.sequential import SequentialDesign, design_maneuver

    check_output(output)
    settings = SequentialDesign.of(options)
    description = (
        f"Designed second by second: each plan is the one after which {patients} patients of {cohort!r} "
        f"are known best{', the least known third of them counting,' if over == 'tail' else ''} within comfort."
    )
    source = "receding-horizon input design (Goodwin and Payne 1977, chapter 6) by random search"
    header = named(output, description, source)

    log = output.with_suffix(".search.npz")

    def search(progress: Progress) -> tuple[Maneuver, bool]:
        def report(done: int, planned_now: bool) -> None:
            if planned_now:
                progress.advance_to(done)
            else:
                progress.skip(1)

        maneuver, plans_made = design_maneuver(settings, header, log, report)
        return maneuver, plans_made > 0

    def write(maneuver: Maneuver) -> str:
        write_found(output, maneuver.model_dump(mode="json", exclude_none=True), "design", settings)
        return f"{horizon_s:g} s"

    return search_maneuver(output, log, overwrite, settings.steps, "steps of the maneuver", search, write)


@takes_world()
def distill(
    world: dict[str, Any],
    config: Config = "distilled",
    planner: Annotated[str, typer.Option(metavar="NAME", help="Whose decisions are learnt.")] = "receding_horizon",
    residual_on: ResidualOn = None,
    reward: Reward = None,
    rounds: Annotated[int, typer.Option(metavar="N", help="How often labels are gathered.")] = 8,
    patients: Annotated[int, typer.Option(metavar="N", help="New patients in each round.")] = 12,
    output: Output = None,
    seed: Seed = None,
    overwrite: Overwrite = False,
) -> int:
    """Learn a planner's decisions: a policy that decides at once what the planner needs up to a second for.

    In the first round the planner plays; then the policy learnt so far does, and the planner labels its steps. Up to
    a second of computing for each second of a patient. One that was stopped goes on after its last finished round when
    the same command is given again. The run's folder is like any other: compare, export, or `train --resume` it.
    """
    from training.run.config import asked_for
    from training.run.folder import RunFolder
    from training.search.distill import Distillation, check_distillable

    training, stem = asked_for(config, world | {"reward": reward}, residual_on=residual_on, seed=seed)
    check_distillable(training)
    options = {"planner": planner, "rounds": rounds, "patients": patients}
    settings = validate(Distillation, options, "command line")
    run = RunFolder(output or Path("runs") / f"{stem}-seed{training.seed}")
    console = quiet_console()
    with alone(run.path):
        return _learn(training, settings, run, console, overwrite)


def _learn(training: TrainingConfig, settings: Distillation, run: RunFolder, console: Console, overwrite: bool) -> int:
    """Gather labels and learn from them, round by round; the exit code."""
    from training.run.train import TrainingSession, base_targets
    from training.search.distill import distill as learn_from_planner
    from training.search.distill import is_finished, seconds_of

    rounds = settings.rounds
    begun = not overwrite and _is_begun(run, training, settings)
    if begun and is_finished(run, rounds):
        console.print(f"{run.path} has all of its {rounds} rounds; nothing to do (--overwrite begins anew)")
        return 0
    if begun:
        run.remove_unfinished()
    else:
        run.check_free(overwrite)
    base = base_targets(training, run.path if begun else None)
    with TrainingSession(training, run, console, 0, base) as session:
        if not begun and base is not None:
            run.create(training, session.world_seed, base.maneuver, _text(settings))
        write_text(run.distillation_file, _text(settings))

        def gather(progress: Progress) -> bool:
            learn_from_planner(session, settings, progress)
            return True

        total = rounds * settings.patients * seconds_of(training)
        if not until_stopped(gather, total, "seconds of patients", console, "after the last finished round"):
            return INTERRUPTED
    console.print(f"the policy of the best round: {run.path}", soft_wrap=True)
    return 0


def _is_begun(run: RunFolder, training: TrainingConfig, settings: Distillation) -> bool:
    """Whether the folder holds a distillation that goes on.

    Raises:
        InputError: it holds one with other settings.
    """
    file = run.distillation_file
    if not (run.exists() and file.is_file()):
        return False
    run.check_settings(training)
    present = read_model(file, type(settings))
    fields = type(settings).model_fields
    other = [name for name in fields if name != "rounds" and getattr(present, name) != getattr(settings, name)]
    if other:
        raise InputError(f"the run in {run.path} has other settings ({', '.join(other)}); replace it with --overwrite")
    return True


def _text(settings: Distillation) -> str:
    return yaml.safe_dump(settings.model_dump(mode="json"), sort_keys=False)
