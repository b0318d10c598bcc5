"""Draw the film and the picture of each environment's page: ``python docs/figures/draw_environments.py``."""

from __future__ import annotations

import sys
from pathlib import Path

import gymnasium as gym
import numpy as np
from PIL import Image

ROOT = Path(__file__).parents[2]
if str(ROOT) not in sys.path:
    sys.path.append(str(ROOT))

import jawenv  # noqa: E402
from jawenv.envs.registration import ENVIRONMENTS  # noqa: E402
from jawenv.envs.shown_world import build_scene  # noqa: E402
from jawenv.ladder import KNOWN_WITHIN_SDS  # noqa: E402
from jawenv.rendering.film import JawRenderer  # noqa: E402

FOLDER = Path(__file__).parent / "environments"
MANEUVER, SHOWN_S, WIDTH = "opening_with_swings", 4.0, 864
"""A film of less than five seconds, which plays once: nobody has to stop it."""


def filmed(env_id: str) -> list[tuple[float, np.ndarray]]:
    """How long each view of a maneuver's first seconds is shown, s, and the view, (height, width, 3)."""
    env = gym.make(env_id, control="targets").unwrapped
    agent = jawenv.Player(MANEUVER, control="targets")
    renderer, views = JawRenderer(WIDTH), []
    observation, info = env.reset(seed=0)
    agent.reset(1)
    while info["time"] < SHOWN_S:
        action, _ = agent.predict(observation)
        before = info["time"]
        observation, _, _, _, info = env.step(action)
        views.append((info["time"] - before, renderer.draw(build_scene(env.simulation))))
    env.close()
    return views


def save(views: list[tuple[float, np.ndarray]], title: str) -> None:
    """The film, and its last view as the picture."""
    images = [Image.fromarray(view) for _, view in views]
    images[-1].save(FOLDER / f"{title}.webp", quality=80)
    shown_ms = [round(1000 * seconds) for seconds, _ in views]
    film = FOLDER / f"{title}_film.webp"
    images[0].save(film, save_all=True, append_images=images[1:], duration=shown_ms, loop=1, quality=70, method=6)
    print(f"{film}: {film.stat().st_size / 1e3:.0f} kB, {len(images)} views")


if __name__ == "__main__":
    FOLDER.mkdir(exist_ok=True)
    for env_id in (*ENVIRONMENTS, KNOWN_WITHIN_SDS):
        save(filmed(env_id), env_id.removeprefix("jawenv/"))
