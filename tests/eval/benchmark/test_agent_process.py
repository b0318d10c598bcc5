"""Agents in a process of their own: the same actions, no hand on the environment, and no way to hold the other up."""

import sys
import time

import numpy as np
import pytest

from eval.benchmark import agent_process
from eval.benchmark.agent_process import AgentProcess, load_apart
from eval.benchmark.tasks import TASKS
from jawenv.base.errors import InputError
from jawenv.envs.info import WorldReader
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


class Reads(Cheat):
    def reset(self, num_envs, seed=None):
        input("weights? ")


class StartsReader(Cheat):
    """Starts a program that reads what it inherits, and one that goes on for ever with all that is open."""

    def reset(self, num_envs, seed=None):
        import os, subprocess, sys, time

        subprocess.run([sys.executable, "-c", "import sys; sys.stdin.read(10)"])
        os.write(1, b"a word of the agent")
        if os.fork() == 0:
            time.sleep(1000)


class Sleeps(Cheat):
    def predict(self, observation, *args):
        import time

        time.sleep(1000)


class NotFinite(Cheat):
    def predict(self, observation, *args):
        return np.full((len(observation), 4), np.nan), None


class Told(Cheat):
    """Writes down what it is told."""

    def reset(self, num_envs, seed=None):
        with open("told.txt", "a") as file:
            print(num_envs, seed, file=file)


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


@pytest.mark.parametrize("name", ["Other", "Planner", "Ends", "Shape", "NotFinite"])
def test_what_an_agent_does_wrong_is_one_line(name):
    with pytest.raises(InputError) as caught:
        load_apart(f"apart_agents:{name}").predict(np.zeros((1, 3), np.float32))
    assert "\n" not in str(caught.value)


def test_an_agent_has_streams_of_its_own_and_its_children_end_with_it():
    agent = load_apart("apart_agents:StartsReader")
    agent.reset(1, 0)
    assert agent.predict(np.zeros((1, 3), np.float32))[0].shape == (1, 4)
    began = time.monotonic()
    del agent
    assert time.monotonic() - began < 5.0
    with pytest.raises(InputError, match="EOFError"):
        load_apart("apart_agents:Reads").reset(1, 0)


def test_a_decision_that_never_comes_is_one_line(monkeypatch):
    agent = load_apart("apart_agents:Sleeps")
    monkeypatch.setattr(agent_process, "DECISION_S", 0.5)
    for message in ("no answer within 0.5 s", "its process has ended"):
        with pytest.raises(InputError, match=message):
            agent.predict(np.zeros((1, 3), np.float32))


def test_an_agent_is_told_neither_the_worlds_seed_nor_the_task(tmp_path):
    """Nor anything made of the seed: other worlds, the same words."""
    agent, told = load_apart("apart_agents:Told"), []
    for seed in (0, 50_000):
        play(agent, patients=2, seed=seed, env_kwargs={"episode_s": 0.5})
        told.append((tmp_path / "told.txt").read_text())
        (tmp_path / "told.txt").unlink()
    assert told[0] == told[1] and not {"0", "1", "50000", "50001"} & set(told[0].split()[1:])
    play(agent, patients=2, seed=0, env_kwargs={"episode_s": 0.5}, agent_seed=1)
    assert (tmp_path / "told.txt").read_text() != told[0]
    question = agent_process._line({"spec": "apart_agents:Told", "settings": {"env_id": "jawenv/Jaw-v3"}}).decode()
    assert not any(task in question for task in TASKS)


SPEAKER = """#!{python}
import os, sys, time
def say(text):
    data = text if isinstance(text, bytes) else text.encode()
    while data:
        data = data[os.write(int(sys.argv[4]), data):]
questions = os.fdopen(int(sys.argv[3]), "rb")
questions.readline()
say({about!r} + "\\n")
questions.readline()
{body}
time.sleep(0.2)
"""
ABOUT = '{"name": "a", "description": "", "control": "targets", "made_of": []}'


@pytest.fixture
def speaker(tmp_path, monkeypatch):
    """A process that says what it is told to, in place of Python with an agent."""

    def make(body, about=ABOUT):
        path = tmp_path / "speaker"
        path.write_text(SPEAKER.format(python=sys.executable, about=about, body=body))
        path.chmod(0o755)
        with monkeypatch.context() as patch:
            patch.setattr(sys, "executable", str(path))
            return AgentProcess("m:A")

    return make


def says(answer):
    """The program of a process that says this."""
    return f"say({answer!r})"


@pytest.mark.parametrize(
    "action",
    [
        "[[NaN, 0, 0, 0]]",
        "[[1e400, 0, 0, 0]]",
        f"[[1{'0' * 400}, 0, 0, 0]]",
        f"[[1{'0' * 5000}, 0, 0, 0]]",
        "[[null, 0, 0, 0]]",
        '[["1", 0, 0, 0]]',
        "[[true, true, true, true]]",
        '{"a": 1}',
        "[" * 100_000,
        "[" * 900 + "]" * 900,
    ],
    ids=lambda action: action[:20],
)
def test_actions_that_are_no_finite_numbers_are_one_line(speaker, action):
    agent = speaker(says('{"action": ' + action + "}\n"))
    with pytest.raises(InputError) as caught:
        agent.predict(np.zeros((1, 5), np.float32))
    assert str(caught.value).isprintable()


SLOWLY = "for _ in range(100): say(' '); time.sleep(0.1)"
HELD = "if os.fork(): os._exit(0)\ntime.sleep(100)"
ANSWERS = {
    "by the byte": SLOWLY,
    "long": says("x" * 2**25),
    "two lines": says("{}\n{}\n"),
    "bytes": says(b"\xff\xfe{\n"),
    "deep": says('{"error": ' + "[" * 900 + "]" * 900 + "}\n"),
    "terminal": says('{"error": "\\ud800 \\u001b[2J"}\n'),
    "a child that stays": HELD,
    "silent": "time.sleep(100)",
}


@pytest.mark.parametrize("body", ANSWERS.values(), ids=ANSWERS)
def test_answers_of_another_form_or_by_the_byte_are_one_line_in_time(speaker, monkeypatch, body):
    agent = speaker(body)
    monkeypatch.setattr(agent_process, "DECISION_S", 2.0)
    began = time.monotonic()
    with pytest.raises(InputError) as caught:
        agent.reset(1, 0)
    del agent
    assert str(caught.value).isprintable() and time.monotonic() - began < 10.0


@pytest.mark.parametrize("about", [ABOUT.replace("[]", '"x"'), ABOUT.replace('"a"', "5"), ABOUT.replace('"a"', "[]")])
def test_what_an_agent_says_of_itself_is_checked(speaker, about):
    with pytest.raises(InputError):
        speaker("", about)


def test_a_control_mode_of_another_type_is_none(speaker):
    assert not hasattr(speaker("", ABOUT.replace('"targets"', "[1]")), "control")
