"""From a name, file or folder to an agent."""

from pathlib import Path

import pytest

import agents
import jawenv
from jawenv.base.errors import InputError
from jawenv.playing.agents import Agent
from jawenv.playing.excitation import Excitation
from jawenv.playing.maneuvers.maneuver import Player


@pytest.mark.parametrize("name", [*jawenv.maneuver_names(), "random"])
def test_every_name_gives_an_agent_of_that_name(name: str) -> None:
    agent = agents.load_agent(name, control="trajectory", control_hz=10.0)
    assert isinstance(agent, Agent) and agent.name == name
    assert isinstance(agent, Excitation if name == "random" else Player)


def test_a_file_that_is_no_checkpoint_and_a_folder_that_is_no_run_are_named(tmp_path: Path) -> None:
    (tmp_path / "weights.pt").write_bytes(b"weights")
    with pytest.raises(InputError):
        agents.load_agent(tmp_path / "weights.pt")
    with pytest.raises(InputError):
        agents.load_agent(tmp_path)
