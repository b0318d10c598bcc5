"""The commands of ``python -m training``."""

from __future__ import annotations

import shlex
import sys
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console

from jawenv.commands.options import takes_world
from jawenv.commands.running import command_line, run
from jawenv.errors import InputError
from training.run import options
from training.search.commands import optimise, refine, twin

app = command_line("Train agents that identify a patient's closing muscles.")
app.command("optimise")(optimise)
app.command("twin")(twin)
app.command("refine")(refine)


@app.command("train")
@takes_world("device")
def train(
    world: dict[str, Any],
    config: options.Config = None,
    residual_on: options.ResidualOn = None,
    reward: options.Reward = None,
    target_discomfort: options.TargetDiscomfort = None,
    output: options.Output = None,
    steps: options.Steps = None,
    seed: options.Seed = None,
    seeds: options.Seeds = None,
    n_envs: options.Worlds = None,
    device: options.Device = None,
    resume: options.Resume = None,
    continue_: options.Continue = False,
    overwrite: options.Overwrite = False,
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
    changes: dict[str, object] = {
        **{name.replace("_", "-"): value for name, value in world.items()},
        "residual-on": residual_on,
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
    training_config, stem = asked_for(
        config,
        world | {"reward": reward},
        residual_on=residual_on,
        target_discomfort=target_discomfort,
        steps=steps,
        seed=seed,
        n_envs=n_envs,
        device=device,
    )
    if seeds is not None:
        for name, value in {"seed": seed, **flags}.items():
            if value not in (None, False):
                raise InputError(f"--{name} cannot be combined with --seeds, which begins or continues each run")
        stem_path = output or Path("runs") / stem
        return training.train_seeds(training_config, training.parse_seeds(seeds), stem_path, console)
    run = RunFolder(output or Path("runs") / f"{stem}-seed{training_config.seed}")
    if continue_ and run.exists():
        run.check_settings(training_config)
        return training.resume(run, console, training_config.steps)
    return training.start(training_config, run, console, overwrite)


@app.command("plot")
def plot(runs: options.Runs, output: options.Figure = Path("runs/learning_curves.png")) -> int:
    """Draw learning curves: worst sd and discomfort over steps, mean and 95 % interval over seeds."""
    from training.run.plot import draw

    print(draw(runs, output))
    return 0


@app.command("tune")
def tune(
    config: options.Config = None,
    trials: options.Trials = 20,
    storage: options.Storage = "sqlite:///runs/tune.db",
    study: options.Study = None,
    env: options.Environment = None,
    residual_on: options.ResidualOn = None,
    steps: options.Steps = None,
    output: options.Output = None,
) -> int:
    """Search an algorithm's settings with Optuna; the same command goes on with a study that was stopped."""
    from training.run.config import asked_for
    from training.run.tune import search

    training_config, stem = asked_for(config, {"env": env}, residual_on=residual_on, steps=steps)
    name = study or stem
    folder = output or Path("runs") / f"tune-{name}"
    return search(training_config, name, trials, storage, folder, Console(highlight=False, markup=False))


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

    FOLDER holds policy.safetensors, card.json and a README.md made of it. It can be given wherever a run can, needs no
    PyTorch, and unlike a checkpoint runs no code when it is loaded.
    """
    from training.run.export import export
    from training.run.folder import RunFolder

    command = shlex.join(["python", "-m", "training", *sys.argv[1:]])
    card = export(RunFolder(run), output, results=results, licence=licence, command=command, overwrite=overwrite)
    Console(highlight=False, markup=False).print(
        f"exported the {card.algorithm} policy of {run} after {card.steps:,} steps: {output}", soft_wrap=True
    )


@app.command("onnx")
def onnx_command(
    policy: Annotated[Path, typer.Argument(metavar="POLICY", help="A shipped policy's name, or the folder of one.")],
    output: Annotated[Path, typer.Option(metavar="FILE.onnx", help="Where it is written.")],
) -> None:
    """Write a policy as ONNX, to be read from C++, MATLAB or a browser (docs/environment.md#a-policy-as-onnx)."""
    from training.run.onnx_file import write_onnx

    write_onnx(policy, output)
    print(f"{output}: observation (N, size), step (N,) -> action (N, 4)")


def main(arguments: list[str] | None = None) -> int:
    """Run the command line.

    Returns:
        Exit code: 0 done, 2 unusable input, 130 stopped by a signal.
    """
    return run(app, "python -m training", arguments, "fewer worlds (--n-envs), or a smaller buffer,")
