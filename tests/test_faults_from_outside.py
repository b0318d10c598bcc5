"""What goes wrong outside of the project is told in one line, and never by a traceback or in silence."""

from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest

import jawenv
from agents import load_agent
from jawenv import InputError
from jawenv.envs.registration import ENVIRONMENTS
from jawenv.envs.vector_arguments import enough_memory
from tests.processes import python

ROOT = Path(__file__).parents[1]
ASCII = {"PYTHONIOENCODING": "ascii", "PYTHONUTF8": "0", "COLUMNS": "100"}


def ran(*arguments: str, **environment: str) -> Any:
    return python(*arguments, cwd=ROOT, env=environment, check=False)


@pytest.mark.parametrize("inside", ["", "/below"])
def test_a_cache_folder_that_is_a_file(inside: str, tmp_path: Path) -> None:
    place = tmp_path / "cache"
    place.touch()
    code = """
import gymnasium as gym, jawenv
try:
    gym.make("jawenv/JawHinge-v3").reset(seed=0)
except jawenv.InputError as error:
    print(error)
"""
    told = ran("-c", code, JAWENV_CACHE_DIR=f"{place}{inside}").stdout
    start = f"JAWENV_CACHE_DIR: compiled kernels cannot be kept in {place}{inside}/kernels (Not a directory); "
    assert told == f"{start}allowed: a folder that can be written, or one that holds all that is played\n"


@pytest.mark.parametrize("arguments", [("eval", "calibrate", "--help"), ("training", "train", "--help")])
def test_a_terminal_without_unicode(arguments: tuple[str, ...]) -> None:
    """Signs that it cannot show are question marks; `eval calibrate --help` has some."""
    shown = ran("-m", *arguments, **ASCII)
    assert shown.returncode == 0, shown.stderr
    assert shown.stdout.isascii() and "--help" in shown.stdout
    assert shown.stderr == ""


def test_a_table_on_a_terminal_without_unicode(tmp_path: Path) -> None:
    options = ("--patients", "2", "--episode-s", "1", "--output", str(tmp_path / "study"))
    shown = ran("-m", "eval", "compare", "hold_still", *options, **ASCII)
    assert shown.returncode == 0, shown.stderr
    assert "hold still" in shown.stdout and shown.stdout.isascii()


class Answering:
    """An agent that answers every observation alike."""

    name = "mute"

    def __init__(self, answer: object) -> None:
        self.answer = answer

    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        return self.answer


@pytest.mark.parametrize(
    ("answer", "shown"),
    [(None, "None"), ((None, None), "(None, None)"), (0.5, "0.5"), ((0.5, None), "(0.5, None)"), ("open", "'open'")],
)
def test_an_agent_that_gives_no_actions(answer: object, shown: str) -> None:
    with pytest.raises(InputError) as caught:
        jawenv.play(Answering(answer), patients=2, seed=0)
    allowed = "allowed: an array of actions, and a state"
    assert str(caught.value) == f"agent 'mute': predict() gives {shown}; {allowed}"


def test_an_action_of_nothing() -> None:
    env = gym.make("jawenv/JawHinge-v3").unwrapped
    env.reset(seed=0)
    with pytest.raises(InputError, match=r"^action is None; allowed: numbers of shape \(4,\)$"):
        env.step(None)


def test_a_name_that_ends_the_program() -> None:
    with pytest.raises(InputError, match="^agent 'sys:exit': cannot be made: SystemExit$"):
        load_agent("sys:exit")


def test_a_module_that_ends_the_program(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "leaving.py").write_text("raise SystemExit('no licence')\n")
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(tmp_path))
    with pytest.raises(InputError, match="module 'leaving' cannot be imported: SystemExit: no licence$"):
        load_agent("leaving:Agent")


@pytest.mark.parametrize("options", [1, "patient", ["patient"], np.ones(2)])
def test_options_that_are_no_mapping(options: object) -> None:
    for env, names in (
        (gym.make("jawenv/JawHinge-v3"), "patient, episode_key, asked"),
        (gym.make_vec("jawenv/JawHinge-v3", num_envs=2), "patients, reset_mask, episode_keys, asked"),
    ):
        with pytest.raises(InputError) as caught:
            env.reset(options=options)
        told = str(caught.value)
        assert told.startswith("options is ") and told.endswith(f"; allowed: a mapping with {names}, or None")
        assert "\n" not in told


@pytest.mark.parametrize("env_id", ENVIRONMENTS)
@pytest.mark.parametrize("number", [10**9, 10**20])
def test_more_worlds_than_there_is_memory(env_id: str, number: int) -> None:
    with pytest.raises(InputError) as caught:
        gym.make_vec(env_id, num_envs=number)
    assert str(caught.value) == f"num_envs is {number}; allowed: as many as fit the memory"


def test_other_refusals_keep_their_words() -> None:
    with pytest.raises(InputError, match="^another$"), enough_memory(2):
        raise InputError("another")
