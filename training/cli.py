"""The commands of ``python -m training``."""

from __future__ import annotations

import shlex
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console

from jawenv.base.errors import InputError
from jawenv.base.extras import of_the_clone
from jawenv.commands.options import takes_together, takes_world
from jawenv.commands.running import command_line, run
from training.search.commands import refine

Overwrite = Annotated[bool, typer.Option("--overwrite", help="Replace what the output folder holds.")]


@dataclass(frozen=True)
class _Overrides:
    """Settings that win over those of the file."""

    residual_on: Annotated[
        str | None, typer.Option(metavar="MANEUVER", help="Train a correction of this maneuver (name or file).")
    ] = None
    target_discomfort: Annotated[
        float | None,
        typer.Option(metavar="S", help="Discomfort allowed on average, s in 30 s; its price is then learned."),
    ] = None
    steps: Annotated[int | None, typer.Option(metavar="N", help="Environment steps to train for, over all worlds.")] = (
        None
    )
    seed: Annotated[int | None, typer.Option(metavar="N", help="Seed; equal seeds give equal policies.")] = None
    n_envs: Annotated[int | None, typer.Option(metavar="N", help="Worlds stepped at once.")] = None


@dataclass(frozen=True)
class _Folder:
    """Where the run lies, and what becomes of one that is there."""

    output: Annotated[
        Path | None, typer.Option(metavar="FOLDER", help="Folder of the run; default runs/CONFIG[-ENV]-seedSEED.")
    ] = None
    resume: Annotated[
        Path | None,
        typer.Option(metavar="RUN", help="Go on with the run in this folder, from its latest checkpoint."),
    ] = None
    continue_: Annotated[
        bool,
        typer.Option("--continue", help="Go on with the run in the output folder if there is one; else start it."),
    ] = False
    overwrite: Overwrite = False


app = command_line("Train agents that identify a patient's closing muscles.")
app.command("refine")(refine)


@app.command("train")
@takes_world(defaults=dict.fromkeys(("control", "cohort", "episode_s")))  # a configuration has its own
@takes_together
def train(
    world: dict[str, Any],
    config: Annotated[
        str | None,
        typer.Argument(metavar="CONFIG", help="A shipped configuration (apg, ppo, plain_ppo, ...) or a YAML file."),
    ] = None,
    overrides: _Overrides = _Overrides(),
    folder: _Folder = _Folder(),
) -> int:
    """Train a policy; Ctrl-C saves a checkpoint that --resume goes on from.

    The run folder holds the best policy (by evaluation on a validation cohort) as weights and a card, checkpoints,
    evaluations.csv, a TensorBoard log, and all that is needed to repeat the run. Options given here win over
    the settings file.
    """
    from training.run import train as training
    from training.run.config import asked_for
    from training.run.folder import RunFolder

    console = Console(highlight=False, markup=False)
    if folder.resume is not None:
        settings = {"CONFIG": config, **vars(folder), **vars(overrides), **world}
        for name, value in settings.items():
            if name not in ("resume", "steps") and value not in (None, False):
                option = name if name.isupper() else f"--{name.rstrip('_').replace('_', '-')}"
                raise InputError(f"{option} cannot be combined with --resume, which keeps the settings of the run")
        return training.resume(RunFolder(folder.resume), console, overrides.steps)
    if folder.overwrite and folder.continue_:
        raise InputError("--overwrite cannot be combined with --continue")
    training_config, stem = asked_for(config, world, **vars(overrides))
    run = RunFolder(folder.output or Path("runs") / f"{stem}-seed{training_config.seed}")
    if folder.continue_ and run.exists():
        run.check_settings(training_config)
        return training.resume(run, console, training_config.steps)
    return training.start(training_config, run, console, folder.overwrite)


@app.command("export")
def _export_command(
    run: Annotated[Path, typer.Argument(metavar="RUN", help="Folder of the run.")],
    output: Annotated[Path, typer.Option(metavar="FOLDER", help="Folder of the policy.")],
    results: Annotated[
        Path | None,
        typer.Option(metavar="FOLDER", help="Finished comparison with the run, whose figures the card gets."),
    ] = None,
    licence: Annotated[str, typer.Option(metavar="NAME", help="Licence of the weights.")] = "MIT",
    overwrite: Overwrite = False,
) -> None:
    """Write a run's best policy as plain weights with a model card, to be shared.

    FOLDER holds policy.safetensors, card.json, a README.md made of it, and evaluations.csv if the run has one. It can
    be given wherever a run can, needs no PyTorch, and unlike a checkpoint runs no code when it is loaded.
    """
    from training.run.export import export
    from training.run.folder import RunFolder

    command = shlex.join(["python", "-m", "training", *sys.argv[1:]])
    reached = ()
    if results is not None:
        reached = of_the_clone("--results", "eval.comparison.card_results", "eval").results_of_run(results, run)
    card = export(RunFolder(run), output, results=reached, licence=licence, command=command, overwrite=overwrite)
    Console(highlight=False, markup=False).print(
        f"exported the {card.algorithm} policy of {run} after {card.steps:,} steps: {output}", soft_wrap=True
    )


def main(arguments: list[str] | None = None) -> int:
    """Run the command line.

    Returns:
        Exit code: 0 done, 2 unusable input, 130 stopped by a signal.
    """
    return run(app, "python -m training", arguments, "fewer worlds (--n-envs), or a smaller buffer,")
