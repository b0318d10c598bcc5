"""One default of the control mode, and agents that are played in their own."""

import inspect
from types import SimpleNamespace

import gymnasium as gym
import numpy as np
import pytest
import typer

import eval.commands.app
import jawenv
import training.cli
from agents import load_agent
from agents.clairvoyant import Clairvoyant
from eval.kept.entries import Settings
from eval.studies.design import Design as Study
from jawenv.controls import CONTROLS, DEFAULT_CONTROL, control_of
from jawenv.envs.configuration import Configuration

SHORT = {"episode_s": 1.0, "track_bound": False}


def test_one_default_for_all() -> None:
    assert Configuration().control == Settings().world.control == DEFAULT_CONTROL == "targets"
    assert gym.make("jawenv/Jaw-v3").unwrapped.configuration.control == DEFAULT_CONTROL  # type: ignore[attr-defined]
    assert gym.make_vec("jawenv/Jaw-v3").unwrapped.configuration.control == DEFAULT_CONTROL  # type: ignore[attr-defined]
    assert jawenv.Player("hold_still").control == load_agent("hold_still").control == DEFAULT_CONTROL  # type: ignore[attr-defined]
    assert inspect.signature(Clairvoyant).parameters["control"].default == DEFAULT_CONTROL
    study = Study(title="T", entries=("hold_still",), patients=1, seed=0)
    assert study.controls == (DEFAULT_CONTROL,)


@pytest.mark.parametrize("app", [eval.commands.app.commands(), training.cli.app], ids=["eval", "training"])
def test_commands_have_the_same_default_or_none(app: typer.Typer) -> None:
    found = []
    for command in typer.main.get_command(app).commands.values():  # type: ignore[attr-defined]
        found += [option.default for option in command.params if option.name == "control"]
    assert found and set(found) <= {DEFAULT_CONTROL, None}  # None leaves it to the configuration


@pytest.mark.parametrize("control", list(CONTROLS))
def test_a_player_is_played_in_its_control(control: str) -> None:
    """To the bit what the same control in the environment's arguments gives."""
    agent = jawenv.Player("slow_opening", control=control)  # type: ignore[arg-type]
    taken = jawenv.play(agent, patients=2, seed=0, env_kwargs=SHORT)
    asked = jawenv.play(agent, patients=2, seed=0, env_kwargs=SHORT | {"control": control})
    np.testing.assert_array_equal(taken.belief_mean, asked.belief_mean)
    assert len(taken.time) == 1 + CONTROLS[control].steps_per_s


@pytest.mark.parametrize(
    ("agent", "asked"),
    [
        (jawenv.Player("slow_opening", control="targets"), "force"),
        (jawenv.Player("slow_opening", control="force"), "targets"),
        (load_agent("ppo_trismus"), "force"),
        (load_agent("clairvoyant"), "trajectory"),
    ],
    ids=lambda value: getattr(value, "name", value),
)
def test_a_contradiction_is_one_line_that_names_both(agent: object, asked: str) -> None:
    with pytest.raises(jawenv.InputError) as caught:
        jawenv.play(agent, patients=1, seed=0, env_kwargs={"control": asked})
    name, own = agent.name, agent.control  # type: ignore[attr-defined]
    assert str(caught.value) == f"control is {asked!r}; allowed for agent {name!r}, whose actions are of it: {own}"


def test_agents_without_a_control_leave_it_to_the_environment() -> None:
    assert control_of(load_agent("random"), {}) is None
    assert control_of(SimpleNamespace(control=None), {"control": "force"}) == "force"
    assert len(jawenv.play(load_agent("random"), patients=1, seed=0, env_kwargs=SHORT).time) == 6
