"""One data set per entry: all steps of the first patients' episodes, each in a single environment."""

from __future__ import annotations

import os
import re
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
from rich.console import Console

import jawenv
from eval.episodes.croissant import write_croissant
from eval.kept.entries import Entry, Settings, load_entries
from eval.kept.tables import made_with
from jawenv.base.errors import InputError
from jawenv.base.extras import needs
from jawenv.base.locks import alone
from jawenv.base.progress import Progress
from jawenv.ladder import model_of_env
from jawenv.playing.agents import checked_decision, introduce, own_seed

REFERENCES = ("random", "hold_still", "slow_opening", "opening_with_swings_and_fore_aft", "refined")
FORMATS = ("arrow", "hdf5")
VERSION = 0
_FOLDER = "MINARI_DATASETS_PATH"


def _dataset_id(entry: Entry) -> str:
    """Its name, as ``jawenv/jaw/refined-v0``."""
    name = re.sub(r"[^A-Za-z0-9_]+", "_", entry.label).strip("_")
    return f"jawenv/{model_of_env(entry.env_id).name}/{name}-v{VERSION}"


@dataclass(frozen=True)
class Form:
    """Parts of a data set, and their form."""

    file_format: str = "arrow"  # of `FORMATS`
    croissant: bool = False  # a description for machines

    def require_packages(self) -> None:
        """An error in one line where a package is missing."""
        if self.croissant:
            with needs("--croissant", "mlcroissant", group="dataset"):
                import mlcroissant  # noqa: F401
        if self.file_format == "hdf5":
            with needs("--format hdf5", "h5py", group="dataset"):
                import h5py  # noqa: F401


def write_all(
    specs: Sequence[str],
    settings: Settings,
    output: Path,
    form: Form,
    command: str,
    console: Console,
    *,
    fresh: bool = False,
    trust: bool = False,
) -> list[str]:
    """Write a data set for every entry.

    Args:
        specs: maneuvers, files, runs, exported policies or agents of one's own.
        settings: on whom and how they are played.
        output: folder that Minari will find them in.
        form: what is written of each.
        command: for the description.
        console: where progress is shown.
        fresh: whether data sets that are there are replaced.
        trust: whether stable-baselines3 checkpoints may be unpickled.

    Returns:
        Names of the data sets.
    """
    with needs("python -m eval dataset", "minari", group="dataset"):
        import minari
    form.require_packages()
    git = made_with(command)["git"]
    made = f"Made by: {command}; jawenv {jawenv.__version__}" + (f", commit {git['commit']}" if git else "")
    entries = load_entries(specs, settings.world, trust=trust)
    for entry in entries:
        if entry.planned:
            raise InputError(
                f"{entry.label} plans in copies of the worlds; allowed: entries that decide by observation"
            )
        if (output / _dataset_id(entry)).exists() and not fresh:
            raise InputError(f"{output / _dataset_id(entry)} exists; use --fresh, or another --output")
    output.mkdir(parents=True, exist_ok=True)
    with (
        alone(output),
        _datasets_in(output),
        Progress(len(entries) * settings.patients, "episodes", console) as progress,
    ):
        for number, entry in enumerate(entries):
            if (output / _dataset_id(entry)).exists():
                minari.delete_dataset(_dataset_id(entry))
            progress.say(entry.label)
            done = number * settings.patients
            description = _description(entry, settings, made)
            _write(entry, settings, form.file_format, description, partial(_advance, progress, done))
            if form.croissant:
                write_croissant(output / _dataset_id(entry), _dataset_id(entry), description)
    return [_dataset_id(entry) for entry in entries]


def _advance(progress: Progress, done: int, more: int) -> None:
    progress.advance_to(done + more)


def _description(entry: Entry, settings: Settings, made: str) -> str:
    words = (entry.description or entry.label).rstrip(".")
    return f"{words}. Seeds {settings.seed} to {settings.seed + settings.patients - 1}. {made}"


def _write(
    entry: Entry, settings: Settings, file_format: str, description: str, progress: Callable[[int], None]
) -> None:
    import minari

    seeds = range(settings.seed, settings.seed + settings.patients)
    env = gym.make(entry.env_id, **entry.env_kwargs)
    collector = minari.DataCollector(env, record_infos=True, data_format=file_format)
    try:
        for i, seed in enumerate(seeds):
            _play(entry, collector, seed, i)
            progress(i + 1)
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", "`(code_permalink|author_email)` is set to None")  # there is none
            collector.create_dataset(
                _dataset_id(entry),
                eval_env=gym.make(entry.env_id, **entry.env_kwargs),
                algorithm_name=entry.label,
                author="jawenv",
                description=description,
            )
    finally:
        collector.close()


def _play(entry: Entry, env: Any, seed: int, place: int) -> None:
    """One episode, from ``reset(seed=seed)``; the agent draws by its place in the data set."""
    observation, _ = env.reset(seed=seed)
    entry.agent.reset(1, own_seed(place))
    introduce(entry.agent, env)
    state, start, ended = None, np.ones(1, dtype=np.bool_), False
    while not ended:
        action, state = checked_decision(entry.agent.predict(observation[None], state, start), entry.agent)
        observation, _, terminated, truncated, _ = env.step(np.asarray(action[0], dtype=np.float32))
        start, ended = np.zeros(1, dtype=np.bool_), terminated or truncated


@contextmanager
def _datasets_in(folder: Path) -> Iterator[None]:
    """Minari keeps its data sets in this folder."""
    before = os.environ.get(_FOLDER)
    os.environ[_FOLDER] = str(folder.resolve())
    try:
        yield
    finally:
        if before is None:
            del os.environ[_FOLDER]
        else:
            os.environ[_FOLDER] = before
