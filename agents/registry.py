"""From what a user types to an agent."""

from pathlib import Path
from typing import Literal

from agents.excitation import EXCITATIONS
from agents.maneuver import FOLDER, Maneuver
from agents.player import Player
from agents.policies import load_policy
from agents.protocol import Agent
from jawenv.errors import InputError
from jawenv.ladder import model_of_env
from jawenv.rollout import DEFAULT_ENV

MANEUVER_SUFFIXES = (".yaml", ".yml", ".json", ".toml")


def names() -> tuple[str, ...]:
    """The maneuvers that come with the project, in alphabetical order."""
    return tuple(sorted(path.stem for path in FOLDER.glob("*.yaml")))


def load_agent(
    spec: str | Path,
    *,
    control: Literal["force", "trajectory"] = "force",
    control_hz: float = 20.0,
    env_id: str = DEFAULT_ENV,
) -> Agent:
    """Find or load an agent.

    Args:
        spec: a hand-made maneuver's name (`names()`), an excitation's (`EXCITATIONS`), a maneuver file, a training
            run's folder or a stable-baselines3 checkpoint.
        control: control mode of the environment that the agent shall play.
        control_hz: control steps per second of that environment.
        env_id: that environment, by its id or as `jawenv.ladder.model_of_env` takes it.

    Raises:
        InputError: an unknown name or environment, or a file that is not what it should be; one line that says so.
    """
    path, model = Path(spec), model_of_env(env_id)
    if str(spec) in EXCITATIONS:
        return EXCITATIONS[str(spec)](control_hz)
    if str(spec) in names():
        maneuver = Maneuver.load(FOLDER / f"{spec}.yaml")
        return Player(maneuver, control=control, control_hz=control_hz)
    if path.suffix in MANEUVER_SUFFIXES:
        return Player(Maneuver.load(path), control=control, control_hz=control_hz)
    if path.exists() or path.suffix == ".zip":
        from jawenv.envs.observation import observation_size

        return load_policy(path, observation_size=observation_size(len(model.muscles.parameter_names)))
    known = ", ".join((*names(), *EXCITATIONS))
    raise InputError(
        f"agent '{spec}': unknown; allowed: {known}, a maneuver file ({', '.join(MANEUVER_SUFFIXES)}), "
        "a run folder or a checkpoint .zip"
    )
