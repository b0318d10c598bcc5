"""Minari: episodes written, loaded and played again."""

import gc
import warnings

import gymnasium as gym
import pytest
from foreign.library import library

import jawenv  # noqa: F401 - registers the environments
from jawenv.controls import CONTROLS

# Minari leaves the removal of its temporary folder to the collector of garbage, which warns.
pytestmark = [*library("minari"), pytest.mark.filterwarnings("ignore:Implicitly cleaning up:ResourceWarning")]
minari = pytest.importorskip("minari")
ABOUT = {"algorithm_name": "random", "author": "a", "author_email": "a@b.c", "code_permalink": "-", "description": "-"}


@pytest.fixture(autouse=True)
def collected():
    """Garbage of a test warns in that test."""
    yield
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ResourceWarning)
        gc.collect()


@pytest.mark.parametrize("format_", ["hdf5", "arrow"])
@pytest.mark.parametrize("control", CONTROLS)
def test_a_data_set(control, format_, tmp_path, monkeypatch):
    """A data set with infos is written, loaded, its environment recovered, and every step replayed to the bit"""
    pytest.importorskip({"hdf5": "h5py", "arrow": "pyarrow"}[format_])
    monkeypatch.setenv("MINARI_DATASETS_PATH", str(tmp_path))
    arguments = {"control": control, "episode_s": 1.0}
    env = gym.make("jawenv/Jaw-v3", **arguments)
    env.action_space.seed(0)
    collector = minari.DataCollector(env, record_infos=True, data_format=format_)
    for seed in (4, 5):
        collector.reset(seed=seed)
        ended = False
        while not ended:
            *_, terminated, truncated, _ = collector.step(env.action_space.sample())
            ended = terminated or truncated
    collector.create_dataset("jaw/random-v0", eval_env=gym.make("jawenv/Jaw-v3", **arguments), **ABOUT)
    loaded = minari.load_dataset("jaw/random-v0")
    again = loaded.recover_environment()
    assert again.spec.kwargs == env.spec.kwargs
    for seed, episode in zip((4, 5), loaded.iterate_episodes(), strict=True):
        observation, info = again.reset(seed=seed)
        assert (episode.observations[0] == observation).all()
        assert (episode.infos["belief_cov"][0] == info["belief_cov"]).all()
        for k, action in enumerate(episode.actions):
            observation, reward, _, truncated, info = again.step(action)
            assert (episode.observations[k + 1] == observation).all()
            assert (episode.rewards[k], episode.truncations[k]) == (reward, truncated)
            assert (episode.infos["belief_cov"][k + 1] == info["belief_cov"]).all()
