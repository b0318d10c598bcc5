"""Commands: ``python -m training train ppo`` and ``export``."""

from __future__ import annotations

import shlex
import sys
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from jawenv.errors import InputError
from training.optimise_command import optimise

app = typer.Typer(
    help="Train agents that identify a patient's closing muscles.",
    add_completion=False,
    rich_markup_mode="markdown",
    pretty_exceptions_enable=False,
)
train_app = typer.Typer(help="Train an agent; one command per algorithm.")
app.add_typer(train_app, name="train")
app.command("optimise")(optimise)

ConfigFile = Annotated[
    Path | None,
    typer.Option(metavar="FILE", help="YAML file of settings; default training/configs/ppo.yaml."),
]
Environment = Annotated[
    str | None,
    typer.Option("--env", metavar="NAME", help="Environment: jawenv/JawSides-v1, or JawSides, or sides."),
]
Output = Annotated[
    Path | None,
    typer.Option(metavar="FOLDER", help="Folder of the run; default runs/CONFIG[-ENV]-seedSEED."),
]
Steps = Annotated[
    int | None,
    typer.Option(metavar="N", help="Environment steps to train for, over all worlds."),
]
Seed = Annotated[int | None, typer.Option(metavar="N", help="Seed; equal seeds give equal policies.")]
Worlds = Annotated[int | None, typer.Option(metavar="N", help="Worlds stepped at once.")]
Device = Annotated[str | None, typer.Option(metavar="NAME", help="Where the network runs: cpu, cuda, ...")]
Resume = Annotated[
    Path | None,
    typer.Option(metavar="RUN", help="Go on with the run in this folder, from its latest checkpoint."),
]
Continue = Annotated[
    bool,
    typer.Option("--continue", help="Go on with the run in the output folder if there is one; else start it."),
]
Overwrite = Annotated[bool, typer.Option("--overwrite", help="Replace the run in the output folder.")]


@app.callback()
def _root() -> None:
    """Train agents that identify a patient's closing muscles."""


@train_app.command("ppo")
def ppo(
    config: ConfigFile = None,
    env: Environment = None,
    output: Output = None,
    steps: Steps = None,
    seed: Seed = None,
    n_envs: Worlds = None,
    device: Device = None,
    resume: Resume = None,
    continue_: Continue = False,
    overwrite: Overwrite = False,
) -> int:
    """Train a PPO policy; Ctrl-C saves a checkpoint that --resume goes on from.

    The run folder holds best_model.zip (by evaluation on a validation cohort), final_model.zip, checkpoints,
    evaluations.csv, a TensorBoard log, and all that is needed to repeat the run. Options given here win over
    the settings file.
    """
    from jawenv.ladder import model_of_env
    from training import train
    from training.config import DEFAULT_CONFIG, TrainingConfig
    from training.run import RunFolder

    console = Console(highlight=False, markup=False)
    if overwrite and continue_:
        raise InputError("--overwrite cannot be combined with --continue")
    if resume is not None:
        settings = {"config": config, "env": env, "output": output, "seed": seed, "n-envs": n_envs, "device": device}
        flags = {"continue": continue_, "overwrite": overwrite}
        for name in (name for name, value in (settings | flags).items() if value not in (None, False)):
            raise InputError(f"--{name} cannot be combined with --resume, which keeps the settings of the run")
        return train.resume(RunFolder(resume), console, steps)
    source = config or DEFAULT_CONFIG
    wanted, stem = TrainingConfig.load(source), source.stem
    if env is not None:
        model = model_of_env(env)
        wanted, stem = wanted.in_env(model.env_id), f"{stem}-{model.title}"
    wanted = wanted.changed(steps=steps, seed=seed, n_envs=n_envs, device=device)
    run = RunFolder(output or Path("runs") / f"{stem}-seed{wanted.seed}")
    if continue_ and run.exists():
        run.check_settings(wanted)
        return train.resume(run, console, wanted.steps)
    return train.start(wanted, run, console, overwrite)


@app.command("export")
def export_command(
    run: Annotated[Path, typer.Argument(metavar="RUN", help="Folder of the run.")],
    output: Annotated[Path, typer.Option(metavar="FOLDER", help="Folder of the exported policy.")],
    results: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="YAML, JSON or TOML file with what the policy reached, for the card."),
    ] = None,
    licence: Annotated[str, typer.Option(metavar="NAME", help="Licence of the weights.")] = "MIT",
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace an exported policy in the folder.")] = False,
) -> None:
    """Write a run's best policy as plain weights with a model card, to be shared.

    FOLDER holds policy.safetensors and card.json. It can be given wherever a run can, needs no PyTorch, and unlike a
    checkpoint runs no code when it is loaded.
    """
    from training.export import export
    from training.run import RunFolder

    command = shlex.join(["python", "-m", "training", *sys.argv[1:]])
    card = export(RunFolder(run), output, results=results, licence=licence, command=command, overwrite=overwrite)
    Console(highlight=False, markup=False).print(
        f"exported the {card.algorithm} policy of {run} after {card.steps:,} steps: {output}", soft_wrap=True
    )


def main(arguments: list[str] | None = None) -> int:
    """Run the command line.

    Returns:
        Exit code: 0 done, 2 unusable input, 130 stopped by a signal.
    """
    if arguments is None:
        arguments = sys.argv[1:]
    try:
        return int(app(arguments or ["--help"], prog_name="python -m training", standalone_mode=False) or 0)
    except InputError as error:
        message = str(error)
    except typer.TyperException as error:
        message = error.format_message()
    print(f"error: {' '.join(message.split())}", file=sys.stderr)
    return 2
