"""Draw the picture of each environment's page: ``python docs/figures/draw_environments.py``."""

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


def drawn(env_id: str) -> np.ndarray:
    """The jaw some seconds into a maneuver, (height, width, 3)."""
    env = gym.make(env_id, control="targets").unwrapped
    agent = jawenv.Player(MANEUVER, control="targets")
    observation, info = env.reset(seed=0)
    agent.reset(1, 0)
    while info["time"] < SHOWN_S:
        action, _ = agent.predict(observation)
        observation, _, _, _, info = env.step(action)
    picture = JawRenderer(WIDTH).draw(build_scene(env.simulation))
    env.close()
    return picture


if __name__ == "__main__":
    FOLDER.mkdir(exist_ok=True)
    for env_id in (*ENVIRONMENTS, KNOWN_WITHIN_SDS):
        place = FOLDER / f"{env_id.removeprefix('jawenv/')}.webp"
        Image.fromarray(drawn(env_id)).save(place, quality=80)
        print(place)
