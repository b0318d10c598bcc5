"""``python -m eval play``: an episode in a window, or as a film."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import zip_longest
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from rich.console import Console

from eval.episodes.video import write_mp4, write_webp
from eval.figures import words
from jawenv.base.errors import InputError
from jawenv.base.files import atomic_write
from jawenv.base.locks import alone
from jawenv.base.progress import Progress
from jawenv.envs.shown_world import build_scene
from jawenv.ladder import model_of_env
from jawenv.playing.recording import Recording
from jawenv.rendering.pair import PairRenderer
from jawenv.rendering.renderer import Renderer

if TYPE_CHECKING:
    from eval.kept.entries import Entry
    from jawenv.rendering.scene import Scene

FORMATS = (".mp4", ".webp")
FULL_WIDTH, FULL_HEIGHT = 1280, 720


@dataclass(frozen=True)
class Film:
    """One player of a film."""

    entry: Entry = field(repr=False)  # who plays, and in which environment
    seed: int = 0  # of patient and noise
    patient: Path | None = None  # file of a patient; one is drawn from the cohort by default
    width: int = FULL_WIDTH  # of its pictures, pixels; a multiple of 32
    every: int = 1  # of the control steps one is shown

    def __post_init__(self) -> None:
        """Check the numbers."""
        if not 320 <= self.width <= FULL_WIDTH or self.width % 32:
            raise InputError(f"width is {self.width}; allowed: a multiple of 32, 320 to {FULL_WIDTH}")
        if self.every < 1:
            raise InputError(f"every is {self.every}; allowed: 1 or more")

    @property
    def rate(self) -> float:
        """Pictures per second."""
        return self.entry.world.steps_per_s / self.every

    @property
    def title(self) -> str:
        """Caption of a picture: maneuver, model, patient and control mode."""
        name, model = words.label(self.entry.label), model_of_env(self.entry.env_id).title
        cohort, control = (self.entry.env_kwargs[key] for key in ("cohort", "control"))
        patient = f"{cohort} patient" if self.patient is None else f"patient {self.patient.stem}"
        return f"{name}: {model}, {patient}, seed {self.seed}, {control} control"

    def play(self, title: str, console: Console, watch: Callable[[Scene], None]) -> str:
        """Play the episode, and show each step to ``watch``; returns its result in a sentence."""
        with Progress(self.entry.world.steps, "steps", console) as progress:
            recording = self.entry.play(
                [self.patient],  # type: ignore[list-item]  # a patient's file
                self.seed,
                lambda step, steps: progress.advance_to(step),
                lambda env, action: watch(build_scene(env.unwrapped.simulation, title)),
                track_bound=False,
            )
        return _sentence(self.entry.label, recording)

    def shown(self, scenes: Sequence[Scene]) -> list[Scene]:
        """The scenes of an episode that are in the film, the last one too."""
        return [scene for i, scene in enumerate(scenes) if scene is scenes[-1] or i % self.every == 0]


def show(film: Film, console: Console) -> str:
    """Play the episode in a window, in real time.

    Returns:
        Result of the episode in a sentence.
    """
    renderer = Renderer("human", film.entry.world.steps_per_s)
    try:
        return film.play(film.title, console, renderer.show)
    finally:
        renderer.close()


def write(films: Sequence[Film], path: Path, console: Console) -> str:
    """Write an episode as a film, or two beside each other, in real time.

    Args:
        films: one, or two that differ in the agent alone.
        path: .mp4 or .webp.
        console: where progress is shown.

    Returns:
        Results of the episodes, a sentence each.
    """
    if path.suffix not in FORMATS:
        raise InputError(f"video is {path}; allowed: a file that ends in {' or '.join(FORMATS)}")
    if not path.parent.is_dir():
        raise InputError(f"video is {path}; allowed: a file in a folder that exists")
    rates = [f"{film.rate:g}" for film in films]
    if len(set(rates)) > 1:
        raise InputError(f"control_hz is {' and '.join(rates)}; allowed: one rate for both")
    played: list[list[Scene]] = [[] for _ in films]
    titles = [films[0].title] if len(films) == 1 else [words.label(film.entry.label) for film in films]
    outcomes = [
        film.play(title, console, scenes.append) for film, title, scenes in zip(films, titles, played, strict=True)
    ]
    pictures = _pictures(films[0], played[0]) if len(films) == 1 else _pairs(films, played)
    scaled = (_scaled(picture, films[0].width) for picture in pictures)
    try:
        with alone(path), atomic_write(path) as unfinished:
            (write_webp if path.suffix == ".webp" else write_mp4)(unfinished, scaled, films[0].rate)
    except OSError as error:
        raise InputError(f"video: {path} cannot be written: {error}") from error
    return "\n".join(outcomes)


def _pictures(film: Film, scenes: Sequence[Scene]) -> Iterator[NDArray[np.uint8]]:
    renderer, shown = Renderer("rgb_array", film.rate), film.shown(scenes)
    for scene in scenes:
        renderer.note(scene.moment)
        if scene is shown[0]:
            yield renderer.draw(shown.pop(0))


def _pairs(films: Sequence[Film], played: Sequence[Sequence[Scene]]) -> Iterator[NDArray[np.uint8]]:
    """Two episodes in step; one that ends earlier stays as it was."""
    renderer, last = PairRenderer(), [scenes[-1] for scenes in played]
    for pair in zip_longest(*(film.shown(scenes) for film, scenes in zip(films, played, strict=True))):
        yield renderer.draw(*(scene or end for scene, end in zip(pair, last, strict=True)))


def _scaled(picture: NDArray[np.uint8], width: int) -> NDArray[np.uint8]:
    """The picture, so many pixels wide."""
    if width == FULL_WIDTH:
        return picture
    from PIL import Image

    size = (width, width * FULL_HEIGHT // FULL_WIDTH)
    return np.asarray(Image.fromarray(picture).resize(size, Image.Resampling.LANCZOS))


def _sentence(label: str, recording: Recording) -> str:
    last = int(recording.last[0])
    sd: Any = recording.belief_sd[0, last]
    worst = int(np.argmax(sd))
    name = recording.parameter_names[worst].replace("_", " ").replace("log ", "").replace("/", " of the ")
    end = ", a hard limit was crossed" if recording.violation[0].any() else ""
    return (
        f"{label}: after {recording.time[last]:g} s {np.sum(sd <= 0.05)} of {len(sd)} parameters "
        f"are within 5 %, least known is {name} ({100.0 * sd[worst]:.1f} %){end}"
    )
