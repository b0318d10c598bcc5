"""Agents in a process of their own: the same actions, and no hand on the environment."""

import sys

import numpy as np
import pytest

from eval.benchmark.agent_process import load_apart
from jawenv.envs.info import WorldReader
from jawenv.errors import InputError
from jawenv.playing.rollout import play
from tests.eval.benchmark.conftest import play as play_benchmark

SOURCE = '''
import numpy as np
from jawenv.envs.info import WorldReader

WorldReader.cheats_at_import = True


class Cheat:
    """Makes the belief the truth."""

    name = "cheat"
    control = "targets"

    def reset(self, num_envs, seed=None):
        print("a word of the agent")
        WorldReader.cheats, old = True, WorldReader.all
        WorldReader.all = lambda reader: {**old(reader), "belief_mean": old(reader)["truth"]}

    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        state = 0.0 if state is None else state + 0.001
        return np.full((len(observation), 4), state, np.float32), state


class Other(Cheat):
    name = "two\\nlines"


class Planner(Cheat):
    def attach(self, env):
        pass


class Ends(Cheat):
    def predict(self, *args):
        raise SystemExit


class Shape(Cheat):
    def predict(self, observation, *args):
        return [[1.0, "x"]], None

'''


@pytest.fixture(autouse=True)
def here(tmp_path, monkeypatch):
    (tmp_path / "apart_agents.py").write_text(SOURCE)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", [entry for entry in sys.path if entry])


def test_a_module_has_no_hand_on_the_environment_and_keeps_its_state():
    agent = load_apart("apart_agents:Cheat", control="targets")
    first, second = (agent.predict(np.zeros((1, 3), np.float32))[0][0, 0] for _ in range(2))
    assert second == pytest.approx(first + 0.001)
    assert (agent.name, agent.control) == ("cheat", "targets") and agent.description == ""
    recording = play(agent, patients=2, seed=0, env_kwargs={"control": "targets", "episode_s": 2.0})
    assert not np.allclose(recording.belief_mean[:, -1], recording.truth)
    assert "apart_agents" not in sys.modules and not hasattr(WorldReader, "cheats_at_import")


def test_the_benchmark_runs_modules_apart_from_loading_to_fingerprints(tmp_path):
    assert play_benchmark(tmp_path / "out", "apart_agents:Cheat") == 0
    assert "apart_agents" not in sys.modules and not hasattr(WorldReader, "cheats_at_import")


@pytest.mark.parametrize("name", ["Other", "Planner", "Ends", "Shape"])
def test_what_an_agent_does_wrong_is_one_line(name):
    with pytest.raises(InputError) as caught:
        load_apart(f"apart_agents:{name}").predict(np.zeros((1, 3), np.float32))
    assert "\n" not in str(caught.value)
