"""From a name, file or folder to an agent."""

from pathlib import Path

import pytest

import agents
from agents.excitation import Excitation
from jawenv.errors import InputError
from jawenv.playing.maneuvers.player import Player
from jawenv.playing.protocol import Agent


@pytest.mark.parametrize("name", [*agents.names(), "random"])
def test_every_name_gives_an_agent_of_that_name(name: str) -> None:
    agent = agents.load_agent(name, control="trajectory", control_hz=10.0)
    assert isinstance(agent, Agent) and agent.name == name
    assert isinstance(agent, Excitation if name == "random" else Player)


def test_unknown_name_lists_what_is_allowed() -> None:
    with pytest.raises(InputError) as caught:
        agents.load_agent("wiggle")
    message = str(caught.value)
    assert message.startswith("agent 'wiggle': unknown") and "\n" not in message
    assert all(name in message for name in (*agents.names(), "random", ".yaml", "run folder", ".zip"))


def test_a_file_that_is_no_checkpoint_and_a_folder_that_is_no_run_are_named(tmp_path: Path) -> None:
    (tmp_path / "weights.pt").write_bytes(b"weights")
    with pytest.raises(InputError):
        agents.load_agent(tmp_path / "weights.pt")
    with pytest.raises(InputError):
        agents.load_agent(tmp_path)


def test_a_policy_of_another_observation_size_is_refused(tmp_path: Path) -> None:
    import gymnasium as gym
    import numpy as np
    from stable_baselines3 import PPO

    class Small(gym.Env):
        observation_space = gym.spaces.Box(-1.0, 1.0, (5,), np.float32)
        action_space = gym.spaces.Box(-1.0, 1.0, (4,), np.float32)

    PPO("MlpPolicy", Small(), device="cpu", policy_kwargs={"net_arch": [4]}).save(tmp_path / "small.zip")
    with pytest.raises(InputError):
        agents.load_agent(tmp_path / "small.zip", trust=True)
    with pytest.raises(InputError):
        agents.load_agent(tmp_path / "small.zip", env_id="jawenv/JawHinge-v2", trust=True)


def test_importing_agents_loads_no_torch() -> None:
    import subprocess
    import sys

    code = "import sys, agents; sys.exit('torch' in sys.modules or 'matplotlib' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], cwd=Path(agents.__file__).parents[1]).returncode == 0
