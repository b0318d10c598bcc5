"""A comparison from start to end: every entry on the same patients with the same noise."""

from __future__ import annotations

import math
import platform
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, field
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from eval.comparison import results
from eval.comparison.results import Results
from eval.entries import Entry, fingerprint
from jawenv.anatomy import cohort
from jawenv.device.device import device_of
from jawenv.errors import InputError
from jawenv.ladder import model_of_env
from jawenv.reality import check_reality
from jawenv.rollout import DEFAULT_ENV, play

CONTROLS = ("force", "trajectory")
SENSORS = ("pose", "point")
_PACKAGES = ("jawenv", "gymnasium", "numpy", "numba", "scipy", "stable-baselines3", "torch")

Progress = Callable[[Entry, int, int], None]


@dataclass(frozen=True)
class Settings:
    """On whom and how the entries of a study are played.

    Attributes:
        patients: how many, >= 1; patient i is drawn, and its noise made, by the seed `seed + i`.
        cohort: name of the population they are drawn from.
        seed: of the first patient, >= 0.
        control: `force` or `trajectory`.
        sensors: `pose` or `point`.
        episode_s: length of every episode, > 0.
        env: id of the environment; as given, also its short name or its model's.
        device: fields of `jawenv.Device` with other values, which the filter knows; none by default.
        reality: effects that the filter does not know, fields of `jawenv.reality.Reality`; none by default.
        estimator: mechanics that the filter believes in; the environment's own by default.

    Raises:
        InputError: a value is not allowed.
    """

    patients: int = 64
    cohort: str = "trismus"
    seed: int = 0
    control: str = "force"
    sensors: str = "pose"
    episode_s: float = 30.0
    env: str = DEFAULT_ENV
    reality: dict[str, float] = field(default_factory=dict)
    device: dict[str, float] = field(default_factory=dict)
    estimator: str | None = None

    def __post_init__(self) -> None:
        """Check every value, and spell the environment's id out."""
        model = model_of_env(self.env)
        object.__setattr__(self, "env", model.env_id)
        if self.patients < 1:
            raise InputError(f"patients: {self.patients} given, allowed is 1 or more")
        if self.seed < 0:
            raise InputError(f"seed: {self.seed} given, allowed is 0 or more")
        if not (math.isfinite(self.episode_s) and self.episode_s > 0.0):
            raise InputError(f"episode_s: {self.episode_s} given, allowed is a number of seconds above 0")
        for name, value, allowed in (("control", self.control, CONTROLS), ("sensors", self.sensors, SENSORS)):
            if value not in allowed:
                raise InputError(f"{name}: {value!r} given, allowed are {', '.join(allowed)}")
        if self.estimator not in (None, *model.estimators):
            known = ", ".join(model.estimators)
            raise InputError(f"estimator: {self.estimator!r} given, allowed in {self.env} are {known}")
        cohort(self.cohort)
        check_reality(self.reality)
        device_of(self.device)

    @property
    def env_kwargs(self) -> dict[str, Any]:
        """Arguments of the environment."""
        given: dict[str, Any] = {
            "control": self.control,
            "sensors": self.sensors,
            "cohort": self.cohort,
            "episode_s": self.episode_s,
        }
        changed = {"reality": self.reality, "device": self.device, "estimator": self.estimator}
        return given | {name: value for name, value in changed.items() if value}


def play_entry(entry: Entry, settings: Settings, progress: Progress | None = None) -> Results:
    """Play one entry on all patients and reduce the recording to its tables.

    Args:
        entry: what to play.
        settings: on whom.
        progress: called with (entry, steps done, steps in all).
    """

    def report(done: int, total: int) -> None:
        if progress is not None:
            progress(entry, done, total)

    recording = play(
        entry.agent,
        patients=settings.patients,
        seed=settings.seed,
        env_kwargs=entry.env_kwargs,
        env_id=entry.env_id,
        progress=report,
    )
    return results.from_recording(recording, entry.label, settings.seed, entry.about())


def compare(
    entries: Sequence[Entry],
    settings: Settings,
    output: Path | None = None,
    *,
    command: str = "",
    fresh: bool = False,
    progress: Progress | None = None,
    finished: Callable[[Entry, bool], None] | None = None,
) -> Results:
    """Play every entry on the same patients and noise; keep each as soon as it is finished.

    Args:
        entries: what to compare.
        settings: on whom and how.
        output: folder for `patients.parquet` and `curves.parquet`, and under `entries/` one pair per entry,
            which is used again when nothing that decides its results has changed; without a folder nothing is kept.
        command: how the user asked for it, for the results' metadata.
        fresh: compute every entry again.
        progress: called with (entry, steps done, steps in all).
        finished: called with (entry, whether it was kept from before).

    Returns:
        The tables of the study, as saved.

    Raises:
        InputError: no entry, or one of another environment than the settings'; the output folder cannot be used, or a
            kept file is damaged.
    """
    if not entries:
        raise InputError("nothing to compare: name a maneuver or a training run, or use --all-maneuvers")
    for entry in entries:
        if entry.env_id != settings.env:
            raise InputError(f"{entry.label} plays {entry.env_id}, but this comparison is in {settings.env}")
    kept = None if output is None else _kept_in(output)
    parts = []
    for entry in entries:
        stem = f"{fingerprint(entry, asdict(settings))}."
        known = kept is not None and not fresh and (kept / f"{stem}patients.parquet").exists()
        part = results.load(kept, stem) if kept is not None and known else play_entry(entry, settings, progress)
        if kept is not None and not known:
            results.save(part, kept, stem)
        parts.append(part)
        if finished is not None:
            finished(entry, known)
    study = results.join(parts, _about(entries, settings, command))
    if output is not None:
        results.save(study, output)
    return study


def _kept_in(output: Path) -> Path:
    """The folder of finished entries, made where it is missing."""
    kept = output / "entries"
    try:
        kept.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"output {output}: {error.strerror}") from None
    return kept


def _about(entries: Sequence[Entry], settings: Settings, command: str) -> dict[str, Any]:
    return {
        "command": command,
        "settings": asdict(settings),
        "entries": [entry.about() for entry in entries],
        "versions": versions(),
        "finished": time.strftime("%Y-%m-%d %H:%M UTC", time.gmtime()),
    }


def versions() -> dict[str, str]:
    """Python, the machine, and the packages that decide results."""
    found = {"python": platform.python_version(), "machine": platform.platform()}
    for package in _PACKAGES:
        try:
            found[package] = version(package)
        except PackageNotFoundError:
            found[package] = "not installed"
    return found
