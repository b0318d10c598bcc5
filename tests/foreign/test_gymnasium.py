"""Gymnasium's own checks and wrappers, on every environment."""

import copy
import pickle

import cloudpickle
import gymnasium as gym
import numpy as np
import pytest
from foreign.library import ids_and_controls, ids_controls_and_pictures, library
from gymnasium import wrappers
from gymnasium.utils.env_checker import check_env, data_equivalence, data_shares_objects
from gymnasium.wrappers import vector as vector_wrappers

import jawenv  # noqa: F401 - registers the environments

pytestmark = library("gymnasium")
TWO, THREE = np.full(4, 2.0, np.float32), np.float32(3.0)
COPIES = {
    "deepcopy": copy.deepcopy,
    "pickle": lambda env: pickle.loads(pickle.dumps(env)),
    "cloudpickle": lambda env: cloudpickle.loads(cloudpickle.dumps(env)),
}


class HastyClock:
    """In place of pygame's, so that no picture waits for its turn."""

    def tick(self, _):
        return 0


@pytest.mark.parametrize(("env_id", "control", "render_mode"), ids_controls_and_pictures())
def test_check_env(env_id, control, render_mode, monkeypatch):
    """`check_env`: every id, control mode and render mode"""
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    monkeypatch.setattr("pygame.time.Clock", HastyClock)
    env = gym.make(env_id, control=control, render_mode=render_mode, episode_s=1.0).unwrapped
    check_env(env, skip_render_check=render_mode is None)


@pytest.mark.parametrize(("env_id", "control"), ids_and_controls())
def test_native_vector_form(env_id, control):
    """Native vector form: spaces, fresh arrays, and world i as `SyncVectorEnv` has it"""
    forms = ("vector_entry_point", "sync")
    native, sync = (gym.make_vec(env_id, 2, vectorization_mode=form, control=control, episode_s=1.0) for form in forms)
    assert (native.observation_space, native.action_space) == (sync.observation_space, sync.action_space)
    actions = np.random.default_rng(0).uniform(-1, 1, (8, 2, 4)).astype(np.float32)
    last = native.reset(seed=3)
    assert data_equivalence(last, sync.reset(seed=3), exact=True)
    for action in actions:
        one, other = native.step(action), sync.step(action)
        assert data_equivalence(one[:4], other[:4], exact=True)
        assert not data_shares_objects(one, last)
        last = one
        assert native.observation_space.contains(one[0])


@pytest.mark.parametrize("way", COPIES)
def test_copies(way):
    """Copies in mid-episode through a stack of wrappers: `deepcopy`, `pickle`, `cloudpickle`"""
    env = gym.make("jawenv/Jaw-v3", max_episode_steps=20)
    env = wrappers.NormalizeReward(wrappers.RecordEpisodeStatistics(env))
    env.reset(seed=1)
    actions = np.random.default_rng(0).uniform(-1, 1, (20, 4)).astype(np.float32)
    for action in actions[:7]:
        env.step(action)
    other = COPIES[way](env)
    for action in actions[7:]:
        one, another = env.step(action), other.step(action)
        assert data_equivalence(one[:4], another[:4], exact=True)
    assert one[3] and one[4]["episode"]["r"] == another[4]["episode"]["r"]


def test_async_vector_env():
    """`AsyncVectorEnv`: worlds in processes of their own"""
    arguments = {"num_envs": 2, "episode_s": 0.6}
    asynchronous = gym.make_vec("jawenv/Jaw-v3", vectorization_mode="async", **arguments)
    native = gym.make_vec("jawenv/Jaw-v3", **arguments)
    try:
        np.testing.assert_array_equal(asynchronous.reset(seed=3)[0], native.reset(seed=3)[0])
        for action in np.random.default_rng(0).uniform(-1, 1, (5, 2, 4)).astype(np.float32):
            for one, other in zip(asynchronous.step(action)[:4], native.step(action)[:4], strict=True):
                np.testing.assert_array_equal(one, other)
        assert asynchronous.get_attr("parameter_names") == native.get_attr("parameter_names")
    finally:
        asynchronous.close()


WRAPPERS = {
    "DelayObservation": lambda env: wrappers.DelayObservation(env, 1),
    "FlattenObservation": wrappers.FlattenObservation,
    "FrameStackObservation": lambda env: wrappers.FrameStackObservation(env, 3),
    "MaxAndSkip": lambda env: wrappers.MaxAndSkipObservation(env, 2),
    "NormalizeObservation": wrappers.NormalizeObservation,
    "RenderCollection": wrappers.RenderCollection,
    "RescaleAction": lambda env: wrappers.RescaleAction(env, -TWO, TWO),
    "RescaleObservation": lambda env: wrappers.RescaleObservation(env, -THREE, THREE),
    "StickyAction": lambda env: wrappers.StickyAction(env, 0.5),
    "TimeAwareObservation": wrappers.TimeAwareObservation,
}


@pytest.mark.parametrize("name", WRAPPERS)
def test_wrappers(name):
    """Wrappers of the single form: observations stay in the space that they state"""
    env = WRAPPERS[name](gym.make("jawenv/Jaw-v3", episode_s=1.0, max_episode_steps=5, render_mode="rgb_array"))
    observation, _ = env.reset(seed=0)
    env.action_space.seed(0)
    ended = False
    while not ended:
        assert env.observation_space.contains(observation)
        observation, _, terminated, truncated, _ = env.step(env.action_space.sample())
        ended = terminated or truncated
    env.close()


VECTOR_WRAPPERS = {
    "ClipReward": lambda env: vector_wrappers.ClipReward(env, -1.0, 1.0),
    "DictInfoToList": vector_wrappers.DictInfoToList,
    "NormalizeObservation": vector_wrappers.NormalizeObservation,
    "NormalizeReward": vector_wrappers.NormalizeReward,
    "RecordEpisodeStatistics": vector_wrappers.RecordEpisodeStatistics,
    "RescaleAction": lambda env: vector_wrappers.RescaleAction(env, -TWO, TWO),
}


@pytest.mark.parametrize(
    ("name", "mode"),
    [
        (name, mode)
        for name in VECTOR_WRAPPERS
        for mode in ("next_step", "same_step")
        if (name, mode) != ("NormalizeObservation", "same_step")
    ],  # which Gymnasium refuses
)
def test_vector_wrappers(name, mode):
    """Wrappers of the native vector form, through ends of episodes in both ways to begin anew"""
    env = VECTOR_WRAPPERS[name](gym.make_vec("jawenv/Jaw-v3", 2, episode_s=0.6, autoreset_mode=mode))
    observation, _ = env.reset(seed=0)
    env.action_space.seed(0)
    for _ in range(8):
        assert env.observation_space.contains(observation)
        observation, reward, *_ = env.step(env.action_space.sample())
        assert np.isfinite(reward).all()
    env.close()


@pytest.mark.parametrize("form", ["single", "native vector"])
def test_record_video(form, tmp_path):
    """`RecordVideo` of the single and of the native vector form"""
    pytest.importorskip("moviepy")
    arguments = {"episode_s": 0.6, "render_mode": "rgb_array"}
    if form == "single":
        env = wrappers.RecordVideo(gym.make("jawenv/Jaw-v3", **arguments), str(tmp_path / "films"))
        action = np.zeros(4, np.float32)
    else:
        env = vector_wrappers.RecordVideo(gym.make_vec("jawenv/Jaw-v3", 2, **arguments), str(tmp_path / "films"))
        action = np.zeros((2, 4), np.float32)
    env.reset(seed=0)
    for _ in range(3):
        env.step(action)
    env.close()
    assert len(list((tmp_path / "films").glob("*.mp4"))) == 1
