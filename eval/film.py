"""``python -m eval play``: an episode in a window, or as a film."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import gymnasium as gym
import numpy as np
from numpy.typing import NDArray
from rich.console import Console

from eval.report import words
from jawenv.errors import InputError
from jawenv.files import atomic_write
from jawenv.ladder import model_of_env
from jawenv.locks import alone
from jawenv.playing.protocol import checked_decision
from jawenv.progress import Progress

if TYPE_CHECKING:
    from eval.entries import Entry

FORMATS = (".mp4", ".gif")
FULL_WIDTH, FULL_HEIGHT = 1280, 720


@dataclass(frozen=True)
class Film:
    """What is shown.

    Attributes:
        entry: who plays, and in which environment.
        seed: of patient and noise.
        patient: file of a patient; one is drawn from the cohort by default.
        start_s: where the film begins, s.
        width: of its pictures, pixels; a multiple of 32.
        every: of the control steps one is shown.
    """

    entry: Entry = field(repr=False)
    seed: int = 0
    patient: Path | None = None
    start_s: float = 0.0
    width: int = FULL_WIDTH
    every: int = 1

    def __post_init__(self) -> None:
        """Check the numbers.

        Raises:
            InputError: one is out of range.
        """
        if not 320 <= self.width <= FULL_WIDTH or self.width % 32:
            raise InputError(f"width: {self.width} given, allowed is a multiple of 32, 320 to {FULL_WIDTH}")
        if self.every < 1:
            raise InputError(f"every: {self.every} given, allowed is 1 or more")
        if not self.start_s >= 0.0:
            raise InputError(f"start_s: {self.start_s:g} given, allowed is 0 or more")


class Episode:
    """One episode, step by step.

    Args:
        film: what is shown.
        mode: render mode of the environment.
        console: where progress is shown.

    Attributes:
        title: above every picture.
        rate: pictures per second.
        outcome: what the episode came to, in a sentence; empty before its end.
    """

    def __init__(self, film: Film, mode: str, console: Console) -> None:
        self._film, self._console = film, console
        made: Any = gym.make(film.entry.env_id, render_mode=mode, **film.entry.env_kwargs)
        self._env = made.unwrapped
        self._steps_per_s: float = self._env.configuration.steps_per_s
        self.title = self._env.picture_title = _title(film)
        self.rate = self._steps_per_s / film.every
        self.outcome = ""
        if film.start_s >= film.entry.env_kwargs["episode_s"]:
            raise InputError(f"start_s: {film.start_s:g} given, allowed is a time within the episode")

    def pictures(self) -> Iterator[NDArray[np.uint8]]:
        """The pictures of the steps that are shown, in mode "rgb_array"; none in a window, which shows every step."""
        film, env, agent = self._film, self._env, self._film.entry.agent
        drawn = env.render_mode == "rgb_array"
        try:
            options = None if film.patient is None else {"patient": film.patient}
            observation, info = env.reset(seed=film.seed, options=options)
            agent.reset(1, film.seed)
            state, start, ended, step = None, np.ones(1, dtype=bool), False, 0
            with Progress(env.configuration.steps, "steps", self._console) as progress:
                while not ended:
                    if drawn and step >= film.start_s * self._steps_per_s and step % film.every == 0:
                        yield env.render()
                    action, state = checked_decision(agent.predict(observation[None], state, start), agent)
                    observation, _, terminated, truncated, info = env.step(action[0])
                    start, ended, step = np.zeros(1, dtype=bool), terminated or truncated, step + 1
                    progress.advance_to(step)
            if drawn:
                yield env.render()
            self.outcome = _sentence(film.entry.label, info, env.unwrapped.parameter_names)
        finally:
            env.close()


def show(film: Film, console: Console) -> str:
    """Play the episode in a window, in real time.

    Returns:
        What the episode came to, in a sentence.

    Raises:
        InputError: there is no display, or the environment or the patient is refused.
    """
    episode = Episode(film, "human", console)
    list(episode.pictures())
    return episode.outcome


def write(film: Film, path: Path, console: Console) -> str:
    """Write the episode as a film, in real time.

    Args:
        film: what is shown.
        path: .mp4 or .gif.
        console: where progress is shown.

    Returns:
        What the episode came to, in a sentence.

    Raises:
        InputError: another ending, a folder that cannot be written to, a file in use, or what the environment refuses.
    """
    if path.suffix not in FORMATS:
        raise InputError(f"video: {path} given, allowed is a file that ends in {' or '.join(FORMATS)}")
    if not path.parent.is_dir():
        raise InputError(f"video: {path} given, allowed is a file in a folder that exists")
    episode = Episode(film, "rgb_array", console)
    try:
        with alone(path), atomic_write(path) as unfinished:
            (_write_gif if path.suffix == ".gif" else _write_mp4)(unfinished, episode, film.width)
    except OSError as error:
        raise InputError(f"video: {path} cannot be written: {error}") from error
    return episode.outcome


def _write_mp4(path: Path, episode: Episode, width: int) -> None:
    import imageio.v2 as imageio

    own = path.with_name(path.name + ".mp4")  # the writer goes by the ending
    try:
        writer: Any
        with imageio.get_writer(own, fps=episode.rate, macro_block_size=2) as writer:
            for picture in episode.pictures():
                writer.append_data(_scaled(picture, width))
        own.replace(path)
    finally:
        own.unlink(missing_ok=True)


def _write_gif(path: Path, episode: Episode, width: int) -> None:
    """All pictures have the colours of the whole film: most come with knowledge, of which the first shows none."""
    from eval.gif import write_gif

    write_gif(path, (_scaled(picture, width) for picture in episode.pictures()), episode.rate)


def _scaled(picture: NDArray[np.uint8], width: int) -> NDArray[np.uint8]:
    """The picture, so many pixels wide."""
    if width == FULL_WIDTH:
        return picture
    from PIL import Image

    size = (width, width * FULL_HEIGHT // FULL_WIDTH)
    return np.asarray(Image.fromarray(picture).resize(size, Image.Resampling.LANCZOS))


def _title(film: Film) -> str:
    """What a picture says of the film: maneuver, model, patient and control mode."""
    name, model, kwargs = words.label(film.entry.label), model_of_env(film.entry.env_id).title, film.entry.env_kwargs
    patient = f"{kwargs['cohort']} patient" if film.patient is None else f"patient {film.patient.stem}"
    return f"{name}: {model}, {patient}, seed {film.seed}, {kwargs['control']} control"


def _sentence(label: str, info: dict[str, Any], parameter_names: tuple[str, ...]) -> str:
    worst = int(np.argmax(info["belief_sd"]))
    name = parameter_names[worst].replace("_", " ").replace("log ", "").replace("/", " of the ")
    end = ", a hard limit was crossed" if info["violation"] else ""
    return (
        f"{label}: after {info['time']:g} s {np.sum(info['belief_sd'] <= 0.05)} of {len(info['belief_sd'])} parameters "
        f"are known to 5 %, least known is {name} ({100.0 * info['belief_sd'][worst]:.1f} %){end}"
    )
