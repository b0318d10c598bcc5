"""``python -m training distill``: learn a planner's decisions."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
import yaml
from rich.console import Console

from jawenv.commands.options import takes_world
from jawenv.errors import InputError
from jawenv.files import read_model, validate, write_text
from jawenv.locks import alone
from jawenv.progress import Progress
from training.options import Config, Output, Overwrite, ResidualOn, Reward, Seed, configured
from training.search.session import INTERRUPTED, quiet_console, until_stopped

if TYPE_CHECKING:
    from training.run.config import TrainingConfig
    from training.run.folder import RunFolder
    from training.search.distill import Distillation


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
    from training.run.folder import RunFolder
    from training.search.distill import Distillation, check_distillable

    wanted, stem = configured(config, world.pop("env", None), residual_on)
    wanted = wanted.changed(seed=seed).with_env_kwargs(**world, reward=reward)
    check_distillable(wanted)
    given = {"planner": planner, "rounds": rounds, "patients": patients}
    settings = validate(Distillation, given, "command line")
    run = RunFolder(output or Path("runs") / f"{stem}-seed{wanted.seed}")
    console = quiet_console()
    with alone(run.path):
        return _learn(wanted, settings, run, console, overwrite)


def _learn(wanted: TrainingConfig, settings: Distillation, run: RunFolder, console: Console, overwrite: bool) -> int:
    """Gather labels and learn from them, round by round; the exit code."""
    from training.run.train import Session, base_targets
    from training.search.distill import distill, is_finished, seconds_of

    rounds = settings.rounds
    begun = not overwrite and _is_begun(run, wanted, settings)
    if begun and is_finished(run, rounds):
        console.print(f"{run.path} has all of its {rounds} rounds; nothing to do (--overwrite begins anew)")
        return 0
    if begun:
        run.remove_unfinished()
    else:
        run.check_free(overwrite)
    base = base_targets(wanted, run.path if begun else None)
    with Session(wanted, console, 0, base) as session:
        if not begun and base is not None:
            run.create(wanted, session.env_spec, session.world_seed, base.maneuver, _text(settings))
        write_text(run.distillation_file, _text(settings))

        def gather(progress: Progress) -> bool:
            distill(session, settings, run, progress)
            return True

        total = rounds * settings.patients * seconds_of(wanted)
        if not until_stopped(gather, total, "seconds of patients", console, "after the last finished round"):
            return INTERRUPTED
    console.print(f"the policy of the best round: {run.best_model}", soft_wrap=True)
    return 0


def _is_begun(run: RunFolder, wanted: TrainingConfig, settings: Distillation) -> bool:
    """Whether the folder holds a distillation that goes on.

    Raises:
        InputError: it holds one with other settings.
    """
    file = run.distillation_file
    if not (run.exists() and file.is_file()):
        return False
    run.check_settings(wanted)
    present = read_model(file, type(settings))
    fields = type(settings).model_fields
    other = [name for name in fields if name != "rounds" and getattr(present, name) != getattr(settings, name)]
    if other:
        raise InputError(f"the run in {run.path} has other settings ({', '.join(other)}); replace it with --overwrite")
    return True


def _text(settings: Distillation) -> str:
    return yaml.safe_dump(settings.model_dump(mode="json"), sort_keys=False)
