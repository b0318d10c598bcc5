"""The folder that a training run leaves behind: all that is needed to use, repeat or continue the run.

::

    runs/<name>/config.yaml        every setting, defaults included
                repeat.json        command lines, seeds, versions, git commit, machine
                env.json           specification of the environment
                base_maneuver.json the maneuver that the policy corrects, if it is a residual
                distillation.yaml  whose decisions were learnt, if it was distilled from a planner
                labels/            round_<number>.npz, what the planner would do
                best_model.zip     policy with the best evaluation
                final_model.zip    policy at the end
                checkpoints/       step_<steps>.zip, the latest few
                evaluations.csv    every evaluation on the validation cohort
                tensorboard/       learning curves
"""

from __future__ import annotations

import json
import re
import shlex
import shutil
import sys
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

from agents.residual import BASE_FILE
from jawenv.errors import InputError
from jawenv.files import atomic_write, read_mapping, remove_unfinished, write_json, write_text
from jawenv.playing.maneuvers import Maneuver
from jawenv.versions import made_with
from training.run.config import TrainingConfig

if TYPE_CHECKING:
    from stable_baselines3.common.base_class import BaseAlgorithm

_CHECKPOINT = re.compile(r"step_(\d+)\.zip")


class RunFolder:
    """Paths and files of one run."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.config_file = path / "config.yaml"
        self.repeat_file = path / "repeat.json"
        self.env_file = path / "env.json"
        self.best_model = path / "best_model.zip"
        self.final_model = path / "final_model.zip"
        self.checkpoints = path / "checkpoints"
        self.evaluations = path / "evaluations.csv"
        self.tensorboard = path / "tensorboard"
        self.distillation_file = path / "distillation.yaml"
        self.labels = path / "labels"

    def exists(self) -> bool:
        """Whether the folder holds a run."""
        return self.config_file.exists()

    def check_settings(self, wanted: TrainingConfig) -> None:
        """Make sure that the run in this folder has the settings wanted, its number of steps aside.

        Raises:
            InputError: it has others; the message names them.
        """
        present = self.open()
        fields = [name for name in TrainingConfig.model_fields if name != "steps"]
        other = [name for name in fields if getattr(present, name) != getattr(wanted, name)]
        if other:
            raise InputError(
                f"the run in {self.path} has other settings ({', '.join(other)}); "
                f"continue it as it is with --resume {self.path}, or replace it with --overwrite"
            )

    def check_free(self, overwrite: bool) -> None:
        """Make sure that a new run may be written here.

        Raises:
            InputError: it holds a run and ``overwrite`` is False, or it holds something that is not a run.
        """
        if not self.path.exists():
            return
        if not self.path.is_dir():
            raise InputError(f"output {self.path} is a file; name a folder")
        if any(self.path.iterdir()) and not self.exists():
            raise InputError(f"output {self.path} is a folder that holds something other than a run; name another one")
        if self.exists() and not overwrite:
            raise InputError(
                f"{self.path} already holds a run; continue it with --resume {self.path}, "
                "or replace it with --overwrite"
            )

    def create(
        self,
        config: TrainingConfig,
        env_spec: str,
        world_seed: int,
        base: Maneuver | None = None,
        distillation: str | None = None,
    ) -> None:
        """Make the folder in place of an older one, whole or not at all, with the files that say what this run is.

        Args:
            config: of the run.
            env_spec: of the environment, as JSON.
            world_seed: of the first training world.
            base: the maneuver that the policy corrects. A copy is kept: its file may change or go.
            distillation: settings of a distillation, as YAML.

        Raises:
            InputError: the folder cannot be written.
        """
        new, old = (self.path.with_name(f".{self.path.name}.{age}") for age in ("new", "old"))
        try:
            for left in (new, old):
                if left.exists():
                    shutil.rmtree(left)
            RunFolder(new)._fill(config, env_spec, world_seed, base, distillation)
            if self.path.exists():
                self.path.rename(old)
            new.rename(self.path)
            if old.exists():
                shutil.rmtree(old)
        except OSError as error:
            raise InputError(f"output {self.path}: {error.strerror}") from None

    def _fill(
        self,
        config: TrainingConfig,
        env_spec: str,
        world_seed: int,
        base: Maneuver | None,
        distillation: str | None,
    ) -> None:
        self.checkpoints.mkdir(parents=True)
        config.save(self.config_file)
        write_text(self.env_file, env_spec + "\n")
        seeds = {
            "training": config.seed,
            "validation": [config.evaluation.seed, config.evaluation.seed + config.evaluation.patients - 1],
        }
        repeat = made_with(sessions=[_session(0, world_seed)], seeds=seeds)
        write_text(self.repeat_file, json.dumps(repeat, indent=2) + "\n")
        if base is not None:
            write_json(self.path / BASE_FILE, base)
        if distillation is not None:
            write_text(self.distillation_file, distillation)

    def remove_unfinished(self) -> None:
        """Remove what a killed process was writing. Nobody else may be at work in the folder."""
        for folder in (self.path, self.checkpoints, self.labels):
            remove_unfinished(folder)

    def add_session(self, config: TrainingConfig, from_step: int, world_seed: int) -> None:
        """Note that the run was resumed, and with which number of steps as its new end."""
        config.save(self.config_file)
        try:
            repeat = read_mapping(self.repeat_file)
            repeat["sessions"].append(_session(from_step, world_seed))
        except (KeyError, TypeError, AttributeError) as error:
            raise InputError(f"{self.repeat_file} is damaged: {' '.join(str(error).split())}") from error
        write_text(self.repeat_file, json.dumps(repeat, indent=2) + "\n")

    def open(self) -> TrainingConfig:
        """The configuration of the run that this folder holds.

        Raises:
            InputError: there is no run here, or its configuration is damaged.
        """
        if not self.exists():
            raise InputError(f"{self.path} holds no run: there is no {self.config_file.name} in it")
        return TrainingConfig.load(self.config_file)

    def save_model(self, model: BaseAlgorithm, path: Path) -> None:
        """Save the model with its optimiser; a crash while saving leaves the older file whole."""
        path.parent.mkdir(parents=True, exist_ok=True)
        with atomic_write(path) as unfinished, unfinished.open("wb") as file:
            model.save(file)

    def save_checkpoint(self, model: BaseAlgorithm, keep: int) -> Path:
        """Save the model under its number of steps, and drop all but the latest ``keep`` checkpoints."""
        path = self.checkpoints / f"step_{model.num_timesteps:010d}.zip"
        self.save_model(model, path)
        for old in self._checkpoint_files()[:-keep]:
            old.unlink()
        return path

    def latest_checkpoint(self) -> Path | None:
        """The checkpoint with the most steps, or None."""
        files = self._checkpoint_files()
        return files[-1] if files else None

    def _checkpoint_files(self) -> list[Path]:
        if not self.checkpoints.is_dir():
            return []
        return sorted(
            (path for path in self.checkpoints.iterdir() if _CHECKPOINT.fullmatch(path.name)),
            key=lambda path: int(path.stem.removeprefix("step_")),
        )


def _session(from_step: int, world_seed: int) -> dict[str, Any]:
    return {
        "command": shlex.join(["python", "-m", "training", *sys.argv[1:]]),
        "started": datetime.now(UTC).isoformat(timespec="seconds"),
        "from_step": from_step,
        "world_seed": world_seed,
    }
