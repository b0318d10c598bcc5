"""An agent's averaged targets as a maneuver that anyone can play."""

import numpy as np
import pytest
from safetensors.numpy import load_file, save_file

import agents
import jawenv
from agents.replay import Replay, replays_of, targets_of
from jawenv.base.errors import InputError
from jawenv.playing.maneuvers import Maneuver, Player
from jawenv.playing.maneuvers.written import save_maneuver
from tests.recorded import Actions

KWARGS = {"control": "targets", "episode_s": 2.0}


def played(agent, patients=2, **kwargs):
    watched = Actions()
    arguments = {**KWARGS, "track_bound": False, **kwargs}
    recording = jawenv.play(agent, patients=patients, seed=5000, env_kwargs=arguments, on_step=watched)
    return np.stack(watched.actions, axis=1), recording


def test_the_replay_of_a_maneuver_is_that_maneuver():
    agent = agents.load_agent("opening_with_swings_and_fore_aft", control="targets")
    replay, _ = replays_of(agent, patients=2, seed=5000, env_kwargs=KWARGS)
    again, recording = played(Player(replay, control="targets"))
    once, original = played(agent)
    np.testing.assert_allclose(again, once, atol=1e-4)
    np.testing.assert_allclose(recording.belief_sd, original.belief_sd, rtol=0.02)


def test_a_replay_is_the_mean_over_patients_and_the_same_for_all(tmp_path):
    agent = agents.load_agent("random", control="targets")
    replay, _ = replays_of(agent, patients=2, seed=5000, env_kwargs=KWARGS)
    mean = targets_of(played(agent)[0], 0.2).mean(axis=0)
    np.testing.assert_allclose(replay.targets(np.arange(1, 11) * 0.2).value, mean, atol=1e-4)
    path = save_maneuver(replay, tmp_path / "replay.yaml")
    assert Maneuver.load(path) == replay
    actions = played(Player(path, control="targets"), patients=3)[0]
    assert np.ptp(actions, axis=0).max() == 0.0 and np.ptp(actions, axis=1).max() > 0.1


def test_a_yoked_replay_gives_each_world_what_another_patient_got(tmp_path):
    agent = agents.load_agent("random", control="targets")
    replays_of(agent, patients=2, seed=5000, env_kwargs=KWARGS)[1].save(tmp_path / "yoked.safetensors")
    again = agents.load_agent(tmp_path / "yoked.safetensors", control="targets")
    once, expected = played(again, patients=3)[0], played(agent)[0]
    np.testing.assert_array_equal(once, expected[[0, 1, 0]])
    np.testing.assert_array_equal(played(again, patients=3)[0], once)
    with pytest.raises(InputError):
        agents.load_agent(tmp_path / "yoked.safetensors", control="targets", control_hz=10)
    save_file({"actions": np.full((2, 3, 4), 2.0), "decision_hz": np.array(5.0)}, tmp_path / "wrong.safetensors")
    with pytest.raises(InputError):
        agents.load_agent(tmp_path / "wrong.safetensors", control="targets")
    save_file({"actions": np.zeros((2, 3, 4)), "decision_hz": np.array(-5.0)}, tmp_path / "wrong.safetensors")
    with pytest.raises(InputError):
        agents.load_agent(tmp_path / "wrong.safetensors", control="targets")


@pytest.mark.parametrize("actions", [np.full((2, 3, 4), 2), np.zeros((0, 3, 4)), np.zeros((2, 0, 4))])
def test_actions_of_another_kind_or_none_are_refused(tmp_path, actions):
    save_file({"actions": actions, "decision_hz": np.array(5.0)}, tmp_path / "wrong.safetensors")
    with pytest.raises(InputError):
        Replay.load(tmp_path / "wrong.safetensors")


def test_a_policy_in_force_control_is_replayed_by_its_targets(tmp_path):
    """A replay of recorded actions, itself recorded in force control, is these actions."""
    drawn = agents.load_agent("random", control="targets")
    replays_of(drawn, patients=2, seed=5020, env_kwargs=KWARGS)[1].save(tmp_path / "first.safetensors")
    followed, kwargs = (
        agents.load_agent(tmp_path / "first.safetensors", control="force"),
        {**KWARGS, "control": "force"},
    )
    maneuver, yoked = replays_of(followed, patients=2, seed=5020, env_kwargs=kwargs)
    yoked.save(tmp_path / "second.safetensors")
    first, second = (load_file(tmp_path / f"{name}.safetensors") for name in ("first", "second"))
    np.testing.assert_allclose(second["actions"], first["actions"], atol=1e-6)
    ends = targets_of(first["actions"], 0.2).mean(axis=0)
    np.testing.assert_allclose(maneuver.targets(np.arange(1, 11) * 0.2).value, ends, atol=1e-4)


def test_targets_are_no_faster_than_the_device():
    ends = targets_of(np.ones((1, 10, 4)), 0.2)[0]
    np.testing.assert_allclose(ends[0], [0.18, 0.6, 0.3, 0.6])
    np.testing.assert_allclose(ends[-1], 1.0)
