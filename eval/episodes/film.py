"""``python -m eval play``: an episode in a window, or as a film."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import zip_longest
from pathlib import Path
from typing import TYPE_CHECKING, Any

import gymnasium as gym
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
from jawenv.playing.agents import checked_decision, introduce, own_seed
from jawenv.rendering.film import PairRenderer

if TYPE_CHECKING:
    from eval.kept.entries import Entry
    from jawenv.rendering import Scene

FORMATS = (".mp4", ".webp")
FULL_WIDTH, FULL_HEIGHT = 1280, 720
_OVER = object()


@dataclass(frozen=True)
class Film:
    """One player of a film."""

    entry: Entry = field(repr=False)  # who plays, and in which environment
    seed: int = 0  # of patient and noise
    patient: Path | None = None  # file of a patient; one is drawn from the cohort by default
    start_s: float = 0.0  # where the film begins, s
    width: int = FULL_WIDTH  # of its pictures, pixels; a multiple of 32
    every: int = 1  # of the control steps one is shown

    def __post_init__(self) -> None:
        """Check the numbers."""
        if not 320 <= self.width <= FULL_WIDTH or self.width % 32:
            raise InputError(f"width is {self.width}; allowed: a multiple of 32, 320 to {FULL_WIDTH}")
        if self.every < 1:
            raise InputError(f"every is {self.every}; allowed: 1 or more")
        if not self.start_s >= 0.0:
            raise InputError(f"start_s is {self.start_s:g}; allowed: 0 or more")


class Episode:
    """One episode, step by step.

    Args:
        film: one player of the film.
        mode: render mode of the environment.
        console: where progress is shown.

    Attributes:
        name: who plays, in words.
        title: above every picture.
        rate: pictures per second.
        outcome: result of the episode in a sentence; empty before its end.
    """

    def __init__(self, film: Film, mode: str, console: Console) -> None:
        self._film, self._console = film, console
        made: Any = gym.make(film.entry.env_id, render_mode=mode, **film.entry.env_kwargs)
        self._env = made.unwrapped
        self._steps_per_s: float = self._env.configuration.steps_per_s
        self.name = words.label(film.entry.label)
        self.title = self._env.picture_title = _title(film)
        self.rate = self._steps_per_s / film.every
        self.outcome = ""
        if film.start_s >= film.entry.env_kwargs["episode_s"]:
            raise InputError(f"start_s is {film.start_s:g}; allowed: a time within the episode")

    def steps(self) -> Iterator[None]:
        """Play and yield at each step of the film, the last one too; `picture` and `scene` are of that step."""
        film, env, agent = self._film, self._env, self._film.entry.agent
        try:
            options = None if film.patient is None else {"patient": film.patient}
            observation, info = env.reset(seed=film.seed, options=options)
            agent.reset(1, own_seed())
            introduce(agent, env)
            state, start, ended, step = None, np.ones(1, dtype=bool), False, 0
            with Progress(env.configuration.steps, "steps", self._console) as progress:
                while not ended:
                    if step >= film.start_s * self._steps_per_s and step % film.every == 0:
                        yield
                    action, state = checked_decision(agent.predict(observation[None], state, start), agent)
                    observation, _, terminated, truncated, info = env.step(action[0])
                    start, ended, step = np.zeros(1, dtype=bool), terminated or truncated, step + 1
                    progress.advance_to(step)
            yield
            self.outcome = _sentence(film.entry.label, info, env.unwrapped.parameter_names)
        finally:
            env.close()

    def picture(self) -> NDArray[np.uint8]:
        """The picture of this step, in mode "rgb_array"."""
        picture: NDArray[np.uint8] = self._env.render()
        return picture

    def scene(self, title: str) -> Scene:
        """This step as the renderer takes it."""
        scene: Scene = build_scene(self._env.simulation, title)
        return scene


def show(film: Film, console: Console) -> str:
    """Play the episode in a window, in real time.

    Returns:
        Result of the episode in a sentence.
    """
    episode = Episode(film, "human", console)
    for _ in episode.steps():
        pass
    return episode.outcome


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
    episodes = [Episode(film, "rgb_array", console) for film in films]
    rates = [f"{episode.rate:g}" for episode in episodes]
    if len(set(rates)) > 1:
        raise InputError(f"control_hz is {' and '.join(rates)}; allowed: one rate for both")
    pictures = _pictures(episodes[0]) if len(episodes) == 1 else _pairs(*episodes)
    scaled = (_scaled(picture, films[0].width) for picture in pictures)
    try:
        with alone(path), atomic_write(path) as unfinished:
            (write_webp if path.suffix == ".webp" else write_mp4)(unfinished, scaled, episodes[0].rate)
    except OSError as error:
        raise InputError(f"video: {path} cannot be written: {error}") from error
    return "\n".join(episode.outcome for episode in episodes)


def _pictures(episode: Episode) -> Iterator[NDArray[np.uint8]]:
    for _ in episode.steps():
        yield episode.picture()


def _pairs(left: Episode, right: Episode) -> Iterator[NDArray[np.uint8]]:
    """Two episodes in step; one that ends earlier stays as it was."""
    renderer, shown = PairRenderer(), {}
    for steps in zip_longest(left.steps(), right.steps(), fillvalue=_OVER):
        for episode, step in zip((left, right), steps, strict=True):
            if step is not _OVER:
                shown[episode] = episode.scene(episode.name)
        yield renderer.draw(shown[left], shown[right])


def _scaled(picture: NDArray[np.uint8], width: int) -> NDArray[np.uint8]:
    """The picture, so many pixels wide."""
    if width == FULL_WIDTH:
        return picture
    from PIL import Image

    size = (width, width * FULL_HEIGHT // FULL_WIDTH)
    return np.asarray(Image.fromarray(picture).resize(size, Image.Resampling.LANCZOS))


def _title(film: Film) -> str:
    """Caption of a picture: maneuver, model, patient and control mode."""
    name, model, kwargs = words.label(film.entry.label), model_of_env(film.entry.env_id).title, film.entry.env_kwargs
    patient = f"{kwargs['cohort']} patient" if film.patient is None else f"patient {film.patient.stem}"
    return f"{name}: {model}, {patient}, seed {film.seed}, {kwargs['control']} control"


def _sentence(label: str, info: dict[str, Any], parameter_names: tuple[str, ...]) -> str:
    worst = int(np.argmax(info["belief_sd"]))
    name = parameter_names[worst].replace("_", " ").replace("log ", "").replace("/", " of the ")
    end = ", a hard limit was crossed" if info["violation"] else ""
    return (
        f"{label}: after {info['time']:g} s {np.sum(info['belief_sd'] <= 0.05)} of {len(info['belief_sd'])} parameters "
        f"are within 5 %, least known is {name} ({100.0 * info['belief_sd'][worst]:.1f} %){end}"
    )
