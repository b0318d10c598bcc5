"""From what a user types to an agent."""

from pathlib import Path
from typing import Literal

from agents.baselines import RandomPolicy
from agents.maneuver import FOLDER, Maneuver
from agents.player import Player
from agents.policies import load_policy
from agents.protocol import Agent
from jawenv.errors import InputError

RANDOM = "random"
MANEUVER_SUFFIXES = (".yaml", ".yml", ".json", ".toml")


def names() -> tuple[str, ...]:
    """The hand-made maneuvers that come with the project, in alphabetical order."""
    return tuple(sorted(path.stem for path in FOLDER.glob("*.yaml")))


def load_agent(
    spec: str | Path, *, control: Literal["force", "trajectory"] = "force", control_hz: float = 20.0
) -> Agent:
    """Find or load an agent.

    Args:
        spec: a hand-made maneuver's name (`names()`), `random`, a maneuver file, a training run's folder or a
            stable-baselines3 checkpoint.
        control: control mode of the environment that the agent shall play.
        control_hz: control steps per second of that environment.

    Raises:
        InputError: an unknown name, or a file that is not what it should be; one line that says so.
    """
    path = Path(spec)
    if str(spec) == RANDOM:
        return RandomPolicy()
    if str(spec) in names():
        maneuver = Maneuver.load(FOLDER / f"{spec}.yaml")
        return Player(maneuver, control=control, control_hz=control_hz)
    if path.suffix in MANEUVER_SUFFIXES:
        return Player(Maneuver.load(path), control=control, control_hz=control_hz)
    if path.exists() or path.suffix == ".zip":
        from jawenv.envs.observation import OBSERVATION_LAYOUT

        size = max(part.stop for part in OBSERVATION_LAYOUT.values())
        return load_policy(path, observation_size=size)
    known = ", ".join((*names(), RANDOM))
    raise InputError(
        f"agent '{spec}': unknown; allowed: {known}, a maneuver file ({', '.join(MANEUVER_SUFFIXES)}), "
        "a run folder or a checkpoint .zip"
    )
