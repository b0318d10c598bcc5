"""The commands of ``python -m training``."""

from __future__ import annotations

import shlex
import sys
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console

from jawenv.base.errors import InputError
from jawenv.commands.options import takes_world
from jawenv.commands.running import command_line, run
from training.search.commands import refine, twin

Config = Annotated[
    str | None,
    typer.Argument(metavar="CONFIG", help="A shipped configuration (ppo, sac, tqc, ...) or a YAML file."),
]
Environment = Annotated[
    str | None,
    typer.Option("--env", metavar="NAME", help="Environment: jawenv/JawSides-v3, or JawSides, or sides."),
]
ResidualOn = Annotated[
    str | None,
    typer.Option(metavar="MANEUVER", help="Train a correction of this maneuver (name or file)."),
]
Reward = Annotated[
    str | None,
    typer.Option(metavar="NAME", help="What is paid for, a name of docs/environment.md#reward."),
]
TargetDiscomfort = Annotated[
    float | None,
    typer.Option(metavar="S", help="Discomfort allowed on average, s in 30 s; its price is then learned."),
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
Seeds = Annotated[
    str | None,
    typer.Option(metavar="LIST", help="Several seeds, 0-4 or 0,1,2, each into OUTPUT-seedK; finished ones are left."),
]
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
Runs = Annotated[list[Path], typer.Argument(metavar="RUN...", help="Run folders; those of several seeds are averaged.")]
Figure = Annotated[Path, typer.Option(metavar="FILE", help="The picture to write, a .png.")]
Trials = Annotated[int, typer.Option(metavar="N", help="Trials that the study shall have in the end.")]
Storage = Annotated[
    str,
    typer.Option(metavar="URL", help="Database of the study: sqlite:///runs/tune.db, postgresql://..., mysql://..."),
]

app = command_line("Train agents that identify a patient's closing muscles.")
app.command("twin")(twin)
app.command("refine")(refine)


@app.command("train")
@takes_world("device")
def train(
    world: dict[str, Any],
    config: Config = None,
    residual_on: ResidualOn = None,
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
    workers: Annotated[int | None, typer.Option(metavar="N", min=1, help="Of --seeds: so many side by side.")] = None,
    backend: Annotated[
        str | None, typer.Option(metavar="NAME", help="Of --seeds: loky, this machine; ray, RAY_ADDRESS's cluster.")
    ] = None,
) -> int:
    """Train a policy; Ctrl-C saves a checkpoint that --resume goes on from.

    The run folder holds the best policy (by evaluation on a validation cohort) as weights and a card, checkpoints,
    evaluations.csv, a TensorBoard log, and all that is needed to repeat the run. Options given here win over
    the settings file.
    """
    from training.run import train as training
    from training.run.config import asked_for
    from training.run.folder import RunFolder
    from training.run.seeds import train_seeds

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
        others = {"seeds": seeds, "output": output, "workers": workers, "backend": backend, **changes, **flags}
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
        return train_seeds(training_config, seeds, stem_path, console, workers, backend)
    for name in (name for name, given in {"workers": workers, "backend": backend}.items() if given is not None):
        raise InputError(f"--{name} belongs to --seeds, whose runs it spreads")
    run = RunFolder(output or Path("runs") / f"{stem}-seed{training_config.seed}")
    if continue_ and run.exists():
        run.check_settings(training_config)
        return training.resume(run, console, training_config.steps)
    return training.start(training_config, run, console, overwrite)


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
    env: Environment = None,
    residual_on: ResidualOn = None,
    steps: Steps = None,
    output: Output = None,
) -> int:
    """Search an algorithm's settings with Optuna; the same command goes on with a study that was stopped."""
    from training.run.config import asked_for
    from training.run.tune import search

    training_config, stem = asked_for(config, {"env": env}, residual_on=residual_on, steps=steps)
    folder = output or Path("runs") / f"tune-{stem}"
    return search(training_config, stem, trials, storage, folder, Console(highlight=False, markup=False))


@app.command("export")
def _export_command(
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

    FOLDER holds policy.safetensors, card.json, a README.md made of it, and evaluations.csv if the run has one. It can
    be given wherever a run can, needs no PyTorch, and unlike a checkpoint runs no code when it is loaded.
    """
    from training.run.export import export
    from training.run.folder import RunFolder

    command = shlex.join(["python", "-m", "training", *sys.argv[1:]])
    card = export(RunFolder(run), output, results=results, licence=licence, command=command, overwrite=overwrite)
    Console(highlight=False, markup=False).print(
        f"exported the {card.algorithm} policy of {run} after {card.steps:,} steps: {output}", soft_wrap=True
    )


@app.command("onnx")
def _onnx_command(
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
