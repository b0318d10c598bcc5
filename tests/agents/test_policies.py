"""Trained policies: what is loaded acts as what was saved, and what is no policy is named."""

import shutil
from pathlib import Path

import gymnasium as gym
import numpy as np
import pytest
from gymnasium import spaces
from stable_baselines3 import PPO, SAC
from stable_baselines3.common.base_class import BaseAlgorithm

from agents.policies import load_policy
from jawenv.errors import InputError
from jawenv.playing.protocol import Agent

SIZE = 9


class Blank(gym.Env):
    """Has the spaces that a policy is built for; nobody steps it."""

    def __init__(self, actions: int = 4) -> None:
        self.observation_space = spaces.Box(-1.0, 1.0, (SIZE,), np.float32)
        self.action_space = spaces.Box(-1.0, 1.0, (actions,), np.float32)


def model(algorithm: type[BaseAlgorithm], **kwargs: object) -> BaseAlgorithm:
    return algorithm("MlpPolicy", Blank(), seed=1, device="cpu", policy_kwargs={"net_arch": [8, 8]}, **kwargs)


@pytest.fixture(scope="module")
def run_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("runs") / "first"
    folder.mkdir()
    model(PPO).save(folder / "final_model.zip")
    return folder


@pytest.fixture
def observations() -> np.ndarray:
    return np.random.default_rng(0).uniform(-1, 1, (6, SIZE)).astype(np.float32)


@pytest.mark.parametrize(("algorithm", "kwargs"), [(PPO, {}), (PPO, {"use_sde": True}), (SAC, {"buffer_size": 1})])
def test_loaded_policy_acts_as_the_model(
    algorithm: type[BaseAlgorithm], kwargs: dict, tmp_path: Path, observations: np.ndarray
) -> None:
    original = model(algorithm, **kwargs)
    original.save(tmp_path / "step_100.zip")
    agent = load_policy(tmp_path / "step_100.zip", observation_size=SIZE)
    assert isinstance(agent, Agent) and agent.name == f"{tmp_path.name}/step_100"
    agent.reset(len(observations), seed=0)
    action, state = agent.predict(observations)
    np.testing.assert_array_equal(action, original.predict(observations, deterministic=True)[0])
    assert state is None
    np.testing.assert_allclose(agent.predict(observations[2])[0], action[2], rtol=1e-5)


def test_stochastic_actions_follow_the_seed(run_folder: Path, observations: np.ndarray) -> None:
    agent = load_policy(run_folder)
    draws = []
    for seed in (1, 1, 2):
        agent.reset(len(observations), seed)
        draws.append(agent.predict(observations, deterministic=False)[0])
    np.testing.assert_array_equal(draws[0], draws[1])
    assert not np.array_equal(draws[0], draws[2])


def test_a_run_gives_its_best_model_before_its_final_one(run_folder: Path, tmp_path: Path) -> None:
    assert load_policy(run_folder).path.name == "final_model.zip"
    folder = tmp_path / "second"
    folder.mkdir()
    for name in ("best_model.zip", "final_model.zip"):
        model(PPO).save(folder / name)
    agent = load_policy(folder)
    assert agent.path.name == "best_model.zip" and agent.name == "second"


def refusal(path: Path, **kwargs: int) -> str:
    with pytest.raises(InputError) as caught:
        load_policy(path, **kwargs)
    message = str(caught.value)
    assert "\n" not in message and str(path.name) in message
    return message


def test_what_is_no_checkpoint_is_named(tmp_path: Path, run_folder: Path) -> None:
    assert "no such file" in refusal(tmp_path / "missing.zip")
    assert "not a training run" in refusal(tmp_path)
    (tmp_path / "notes.zip").write_text("not a zip")
    assert "not a stable-baselines3 checkpoint" in refusal(tmp_path / "notes.zip")
    np.savez(tmp_path / "arrays.npz", a=np.zeros(3))
    assert "not a stable-baselines3 checkpoint" in refusal(tmp_path / "arrays.npz")
    whole = (run_folder / "final_model.zip").read_bytes()
    (tmp_path / "cut.zip").write_bytes(whole[: len(whole) // 2])
    assert "not a stable-baselines3 checkpoint" in refusal(tmp_path / "cut.zip")


def test_damaged_content_is_named(tmp_path: Path) -> None:
    import zipfile

    with zipfile.ZipFile(tmp_path / "odd.zip", "w") as archive:
        archive.writestr("data", "{}")
        archive.writestr("policy.pth", b"nothing")
    assert "damaged" in refusal(tmp_path / "odd.zip")


def test_policy_of_another_environment_is_refused(run_folder: Path, tmp_path: Path) -> None:
    assert f"observations of {SIZE} values" in refusal(run_folder / "final_model.zip", observation_size=SIZE + 1)
    PPO("MlpPolicy", Blank(actions=2), device="cpu").save(tmp_path / "two.zip")
    assert "(2,)" in refusal(tmp_path / "two.zip")


def test_wrong_observation_at_play_is_refused(run_folder: Path) -> None:
    with pytest.raises(InputError, match=f"observations of {SIZE} values, got 4"):
        load_policy(run_folder).predict(np.zeros((2, 4), dtype=np.float32))


def test_a_policy_has_the_control_of_its_run(run_folder: Path, tmp_path: Path) -> None:
    assert load_policy(run_folder).control is None
    shutil.copy(run_folder / "final_model.zip", tmp_path / "final_model.zip")
    (tmp_path / "config.yaml").write_text("env: {kwargs: {control: force}}\n")
    assert load_policy(tmp_path).control == "force"
