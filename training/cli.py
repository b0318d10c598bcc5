"""The commands of ``python -m training``."""

from __future__ import annotations

import shlex
import sys
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from jawenv.errors import InputError, out_of_memory
from training.help import Commands
from training.options import (
    Cohort,
    Config,
    Continue,
    Control,
    Device,
    Environment,
    Figure,
    Output,
    Overwrite,
    ResidualOn,
    Resume,
    Reward,
    Runs,
    Seed,
    Seeds,
    Steps,
    Storage,
    Study,
    TargetDiscomfort,
    Trials,
    Worlds,
    configured,
)
from training.search.design_command import design
from training.search.distill_command import distill
from training.search.optimise_command import optimise

app = typer.Typer(
    cls=Commands,
    help="Train agents that identify a patient's closing muscles.",
    add_completion=False,
    rich_markup_mode="markdown",
    pretty_exceptions_enable=False,
)
app.command("optimise")(optimise)
app.command("design")(design)
app.command("distill")(distill)


@app.callback()
def _root() -> None:
    """Train agents that identify a patient's closing muscles."""


@app.command("train")
def train(
    config: Config = None,
    env: Environment = None,
    residual_on: ResidualOn = None,
    control: Control = None,
    cohort: Cohort = None,
    reward: Reward = None,
    target_discomfort: TargetDiscomfort = None,
    output: Output = None,
    steps: Steps = None,
    seed: Seed = None,
    seeds: Seeds = None,
    n_envs: Worlds = None,
    device: Device = None,
    resume: Resume = None,
    continue_: Continue = False,
    overwrite: Overwrite = False,
) -> int:
    """Train a policy; Ctrl-C saves a checkpoint that --resume goes on from.

    The run folder holds best_model.zip (by evaluation on a validation cohort), final_model.zip, checkpoints,
    evaluations.csv, a TensorBoard log, and all that is needed to repeat the run. Options given here win over
    the settings file.
    """
    from training.run import several
    from training.run import train as training
    from training.run.folder import RunFolder

    console = Console(highlight=False, markup=False)
    changes: dict[str, object] = {"env": env, "residual-on": residual_on, "control": control, "cohort": cohort}
    changes |= {
        "reward": reward,
        "target-discomfort": target_discomfort,
        "seed": seed,
        "n-envs": n_envs,
        "device": device,
    }
    flags = {"continue": continue_, "overwrite": overwrite}
    if resume is not None:
        others = {"seeds": seeds, "output": output, **changes, **flags}
        if config is not None:
            raise InputError("CONFIG cannot be combined with --resume, which keeps the settings of the run")
        for name in (name for name, value in others.items() if value not in (None, False)):
            raise InputError(f"--{name} cannot be combined with --resume, which keeps the settings of the run")
        return training.resume(RunFolder(resume), console, steps)
    if overwrite and continue_:
        raise InputError("--overwrite cannot be combined with --continue")
    wanted, stem = configured(config, env, residual_on)
    wanted = wanted.changed(steps=steps, seed=seed, n_envs=n_envs, device=device)
    wanted = wanted.with_env_kwargs(control=control, cohort=cohort, reward=reward)
    if target_discomfort is not None:
        wanted = wanted.within_discomfort(target_discomfort)
    if seeds is not None:
        for name, value in {"seed": seed, **flags}.items():
            if value not in (None, False):
                raise InputError(f"--{name} cannot be combined with --seeds, which begins or continues each run")
        return several.train_seeds(wanted, several.parse_seeds(seeds), output or Path("runs") / stem, console)
    run = RunFolder(output or Path("runs") / f"{stem}-seed{wanted.seed}")
    if continue_ and run.exists():
        run.check_settings(wanted)
        return training.resume(run, console, wanted.steps)
    return training.start(wanted, run, console, overwrite)


@app.command("plot")
def plot(runs: Runs, output: Figure = Path("runs/learning_curves.png")) -> int:
    """Draw learning curves: worst sd and discomfort over steps, mean and 95 % interval over seeds."""
    from training.run.plot import draw

    print(draw(runs, output))
    return 0


@app.command("tune")
def tune(
    config: Config = None,
    trials: Trials = 20,
    storage: Storage = "sqlite:///runs/tune.db",
    study: Study = None,
    env: Environment = None,
    residual_on: ResidualOn = None,
    steps: Steps = None,
    output: Output = None,
) -> int:
    """Search an algorithm's settings with Optuna; the same command goes on with a study that was stopped."""
    from training.run.tune import search

    wanted, stem = configured(config, env, residual_on)
    name = study or stem
    folder = output or Path("runs") / f"tune-{name}"
    return search(wanted.changed(steps=steps), name, trials, storage, folder, Console(highlight=False, markup=False))


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
    from training.run.export import export
    from training.run.folder import RunFolder

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
    except MemoryError as error:
        message = f"{out_of_memory(error)}; fewer worlds (--n-envs), or a smaller buffer, need less"
    except typer.TyperException as error:
        message = error.format_message()
    print(f"error: {' '.join(message.split())}", file=sys.stderr)
    return 2
