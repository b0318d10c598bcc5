"""An agent's averaged targets as a maneuver that anyone can play."""

import numpy as np
import pytest

import agents
import jawenv
from agents.replay import Recorder, replay_of, replays_of, save_maneuver, targets_of
from jawenv.errors import InputError
from jawenv.maneuvers import Maneuver, Player

KWARGS = {"control": "targets", "episode_s": 2.0}


def played(agent, patients=2, **kwargs):
    recorder = Recorder(agent)
    recording = jawenv.play(
        recorder, patients=patients, seed=5000, env_kwargs={**KWARGS, "track_bound": False, **kwargs}
    )
    return np.stack(recorder.actions, axis=1), recording


def test_the_replay_of_a_maneuver_is_that_maneuver():
    agent = agents.load_agent("opening_with_swings_and_fore_aft", control="targets")
    replay = replay_of(agent, patients=2, seed=5000, env_kwargs=KWARGS)
    again, recording = played(Player(replay, control="targets"))
    once, original = played(agent)
    np.testing.assert_allclose(again, once, atol=1e-4)
    np.testing.assert_allclose(recording.belief_sd, original.belief_sd, rtol=0.02)


def test_a_replay_is_the_mean_over_patients_and_the_same_for_all(tmp_path):
    agent = agents.load_agent("random", control="targets")
    replay = replay_of(agent, patients=2, seed=5000, env_kwargs=KWARGS)
    mean = targets_of(played(agent)[0], 0.2).mean(axis=0)
    np.testing.assert_allclose(replay.targets(np.arange(1, 11) * 0.2).value, mean, atol=1e-4)
    path = save_maneuver(replay, tmp_path / "replay.yaml")
    assert Maneuver.load(path) == replay
    actions = played(Player(path, control="targets"), patients=3)[0]
    assert np.ptp(actions, axis=0).max() == 0.0 and np.ptp(actions, axis=1).max() > 0.1


@pytest.mark.parametrize("control", ["force", "trajectory"])
def test_a_replay_plays_in_every_control_mode(control):
    agent = agents.load_agent("random", control="targets")
    replay = replay_of(agent, patients=2, seed=5000, env_kwargs=KWARGS)
    actions, recording = played(Player(replay, control=control), control=control)
    assert np.isfinite(actions).all() and recording.time[-1] == pytest.approx(2.0)


def test_a_yoked_replay_gives_each_world_what_another_patient_got(tmp_path):
    agent = agents.load_agent("random", control="targets")
    replays_of(agent, patients=2, seed=5000, env_kwargs=KWARGS)[1].save(tmp_path / "yoked.npz")
    again = agents.load_agent(tmp_path / "yoked.npz", control="targets")
    once, expected = played(again, patients=3)[0], played(agent)[0]
    np.testing.assert_array_equal(once, expected[[0, 1, 0]])
    np.testing.assert_array_equal(played(again, patients=3)[0], once)
    with pytest.raises(InputError, match="control is 'force'; allowed for recorded actions: targets$"):
        agents.load_agent(tmp_path / "yoked.npz")
    np.savez(tmp_path / "wrong.npz", name="wrong", actions=np.full((2, 3, 4), 2.0))
    with pytest.raises(InputError, match=r"wrong.npz: actions have shape \(2, 3, 4\); allowed: \(N, T, 4\), each in"):
        agents.load_agent(tmp_path / "wrong.npz", control="targets")


def test_targets_are_no_faster_than_the_device():
    ends = targets_of(np.ones((1, 10, 4)), 0.2)[0]
    np.testing.assert_allclose(ends[0], [0.18, 0.6, 0.3, 0.6])
    np.testing.assert_allclose(ends[-1], 1.0)


def test_another_control_mode_and_another_ending_are_refused(tmp_path):
    agent = agents.load_agent("hold_still")
    with pytest.raises(InputError, match="^replay of 'hold_still': control is 'force'; allowed: targets$"):
        replay_of(agent, patients=1, seed=5000, env_kwargs={"control": "force"})
    maneuver = Maneuver.named("hold_still")
    with pytest.raises(InputError, match="^output is .*; allowed: a file that ends in .yaml$"):
        save_maneuver(maneuver, tmp_path / "replay.txt")
