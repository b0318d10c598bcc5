"""The folder that a training run leaves behind: all that is needed to use, repeat or continue the run.

::

    runs/<name>/config.yaml        every setting, defaults included
                repeat.json        command lines, seeds, versions, git commit, machine
                base_maneuver.json the maneuver that the policy corrects, if it is a residual
                card.json          model card of the policy with the best evaluation, and
                policy.safetensors its weights (of another environment or network: best_model.zip)
                checkpoints/       step_<steps>.zip, the latest few, to go on from
                evaluations.csv    every evaluation on the validation cohort
                tensorboard/       learning curves
"""

from __future__ import annotations

import json
import re
import shlex
import sys
import tempfile
import zipfile
from collections.abc import Iterator
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

from agents.evaluations import FILE as EVALUATIONS
from jawenv.base.errors import InputError, reason_of
from jawenv.base.files import atomic_write, read_mapping, remove_unfinished, write_json, write_text
from jawenv.base.reading import LARGEST_TEXT, open_file
from jawenv.base.versions import made_with
from jawenv.playing.maneuvers import Maneuver
from jawenv.playing.policies.card import CARD
from training.run.config import BASE_FILE, TrainingConfig

if TYPE_CHECKING:
    from stable_baselines3.common.base_class import BaseAlgorithm

_CHECKPOINT = re.compile(r"step_(\d+)\.zip")


class RunFolder:
    """Paths and files of one run."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.config_file = path / "config.yaml"
        self.repeat_file = path / "repeat.json"
        self.best_model = path / "best_model.zip"
        self.checkpoints = path / "checkpoints"
        self.evaluations = path / EVALUATIONS
        self.tensorboard = path / "tensorboard"

    def exists(self) -> bool:
        """Whether the folder holds a run."""
        return self.config_file.exists()

    def has_policy(self) -> bool:
        """Whether the folder holds the best policy so far."""
        return (self.path / CARD).exists() or self.best_model.exists()

    def check_holds_run(self) -> None:
        """Make sure that the folder holds a run."""
        if not self.exists():
            raise InputError(f"{self.path} holds no run: there is no {self.config_file.name} in it")

    def open(self) -> TrainingConfig:
        """The configuration of the run that this folder holds."""
        self.check_holds_run()
        return TrainingConfig.load(self.config_file)

    def check_settings(self, config: TrainingConfig) -> None:
        """Make sure that the run in this folder has the settings wanted, its number of steps aside."""
        present = self.open()
        fields = [name for name in TrainingConfig.model_fields if name != "steps"]
        other = [name for name in fields if getattr(present, name) != getattr(config, name)]
        if other:
            raise InputError(
                f"the run in {self.path} has other settings ({', '.join(other)}); "
                f"continue it as it is with --resume {self.path}, or replace it with --overwrite"
            )

    def check_free(self, overwrite: bool) -> None:
        """Make sure that a new run may be written here."""
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
        world_seed: int,
        base: Maneuver | None = None,
    ) -> None:
        """Make the folder in place of an older one, whole or not at all, with the files that describe this run.

        Args:
            config: of the run.
            world_seed: of the first training world.
            base: the maneuver that the policy corrects. A copy is kept: its file may change or go.
        """
        target = self.path.resolve()  # a link to a folder stays one
        try:
            with tempfile.TemporaryDirectory(
                prefix=f".{target.name}.", suffix=".unfinished", dir=target.parent
            ) as made:
                new, old = Path(made, "new"), Path(made, "old")
                RunFolder(new)._fill(config, world_seed, base)
                if target.exists():
                    target.rename(old)
                try:
                    new.rename(target)
                finally:
                    if old.exists() and not target.exists():
                        old.rename(target)
        except OSError as error:
            raise InputError(f"output {self.path}: {reason_of(error)}") from None

    def _fill(self, config: TrainingConfig, world_seed: int, base: Maneuver | None) -> None:
        self.checkpoints.mkdir(parents=True)
        config.save(self.config_file)
        seeds = {
            "training": config.seed,
            "validation": [config.evaluation.seed, config.evaluation.seed + config.evaluation.patients - 1],
        }
        repeat = made_with(sessions=[_session(0, world_seed)], seeds=seeds, settings=config.as_mapping())
        write_text(self.repeat_file, json.dumps(repeat, indent=2) + "\n")
        if base is not None:
            write_json(self.path / BASE_FILE, base)

    def remove_unfinished(self) -> None:
        """Remove unfinished files of a killed process. Nobody else may be at work in the folder."""
        for folder in (self.path, self.checkpoints):
            remove_unfinished(folder)

    def add_session(self, config: TrainingConfig, from_step: int, world_seed: int) -> None:
        """Note that the run was resumed, and with which number of steps as its new end."""
        config.save(self.config_file)
        repeat = self._repeat()
        repeat["sessions"].append(_session(from_step, world_seed))
        write_text(self.repeat_file, json.dumps(repeat, indent=2) + "\n")

    def changed_settings(self, config: TrainingConfig) -> tuple[str, ...]:
        """Names of settings that were changed since the run began, as ``env.kwargs.cohort``; () of an older run."""
        began = self._repeat().get("settings")
        return tuple(_different("", began, config.as_mapping())) if isinstance(began, dict) else ()

    def commands(self) -> tuple[str, ...]:
        """The commands that made the run."""
        return tuple(str(session["command"]) for session in self._repeat()["sessions"])

    def _repeat(self) -> dict[str, Any]:
        repeat = read_mapping(self.repeat_file)
        sessions = repeat.get("sessions")
        if not isinstance(sessions, list) or not all(isinstance(one, dict) and "command" in one for one in sessions):
            raise InputError(f"{self.repeat_file} is damaged: sessions is no list of mappings with a command")
        return repeat

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


def _text_in(archive: zipfile.ZipFile, name: str) -> bytes:
    """The content of a member that is a text; too large a one is refused before it is unpacked."""
    size = archive.getinfo(name).file_size
    if size > LARGEST_TEXT:
        raise ValueError(f"{name}: has {size:,} bytes; allowed: {LARGEST_TEXT:,} at most")
    return archive.read(name)


def read_counts(checkpoint: Path) -> dict[str, Any]:
    """The plain text of a checkpoint, its steps and updates among it; its pickles stay text."""
    with open_file(checkpoint) as file:
        try:
            with zipfile.ZipFile(file) as archive:
                data: dict[str, Any] = json.loads(_text_in(archive, "data"))
            int(data["num_timesteps"]), int(data["_n_updates"])
        except Exception as error:  # a damaged archive or text can raise anything
            raise damaged(checkpoint, error) from None
    return data


def damaged(checkpoint: Path, error: Exception) -> InputError:
    """The error for a checkpoint that cannot be read."""
    reason = " ".join(str(error).split())[:200] or type(error).__name__
    return InputError(f"checkpoint {checkpoint} is damaged ({reason}); delete it to go on from the one before it")


def _different(name: str, before: Any, after: Any) -> Iterator[str]:
    """Names of the values that differ between two mappings, those within mappings with a dot."""
    if not isinstance(before, dict) or not isinstance(after, dict):
        if before != after:
            yield name
        return
    for key in {**before, **after}:
        yield from _different(f"{name}.{key}" if name else key, before.get(key), after.get(key))


def _session(from_step: int, world_seed: int) -> dict[str, Any]:
    return {
        "command": shlex.join(["python", "-m", "training", *sys.argv[1:]]),
        "started": datetime.now(UTC).isoformat(timespec="seconds"),
        "from_step": from_step,
        "world_seed": world_seed,
    }
