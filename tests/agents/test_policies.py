"""Trained policies: what is loaded acts as what was saved, and what is no policy is named."""

import io
import os
import shutil
import zipfile
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
import torch
from gymnasium import spaces
from sb3_contrib import TQC, RecurrentPPO
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


def write_config(folder: Path, algorithm: str = "ppo", activation: str = "tanh") -> None:
    (folder / "config.yaml").write_text(
        f"algorithm: {algorithm}\n{algorithm}: {{network: {{activation: {activation}}}}}\n"
    )


def model(algorithm: type[BaseAlgorithm], **kwargs: object) -> BaseAlgorithm:
    return algorithm("MlpPolicy", Blank(), seed=1, device="cpu", policy_kwargs={"net_arch": [8, 8]}, **kwargs)


@pytest.fixture(scope="module")
def run_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("runs") / "first"
    folder.mkdir()
    model(PPO).save(folder / "final_model.zip")
    write_config(folder)
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
    agent = load_policy(tmp_path / "step_100.zip", observation_size=SIZE, trust=True)
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
    write_config(folder)
    agent = load_policy(folder)
    assert agent.path.name == "best_model.zip" and agent.name == "second"


def refusal(path: Path, **kwargs: Any) -> str:
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


@pytest.mark.parametrize("place", ["vecnormalize.pkl", "Jaw-v2/vecnormalize.pkl", "model_vecnormalize_100_steps.pkl"])
def test_a_policy_that_saw_normalised_observations_is_refused(place: str, run_folder: Path, tmp_path: Path) -> None:
    """It would play on what it has never seen, and nobody would notice."""
    folder = tmp_path / "zoo"
    shutil.copytree(run_folder, folder)
    (folder / place).parent.mkdir(exist_ok=True)
    (folder / place).touch()
    assert f"normalised (by {place})" in refusal(folder, trust=True)


def test_policy_of_another_environment_is_refused(run_folder: Path, tmp_path: Path) -> None:
    assert f"observations of {SIZE} values" in refusal(run_folder / "final_model.zip", observation_size=SIZE + 1)
    PPO("MlpPolicy", Blank(actions=2), device="cpu").save(tmp_path / "two.zip")
    write_config(tmp_path)
    assert "(2,)" in refusal(tmp_path / "two.zip")


def test_wrong_observation_at_play_is_refused(run_folder: Path) -> None:
    with pytest.raises(InputError):
        load_policy(run_folder).predict(np.zeros((2, 4), dtype=np.float32))


def test_a_policy_has_the_control_of_its_run(run_folder: Path, tmp_path: Path) -> None:
    assert load_policy(run_folder).control is None
    shutil.copy(run_folder / "final_model.zip", tmp_path / "final_model.zip")
    write_config(tmp_path)
    with (tmp_path / "config.yaml").open("a") as file:
        file.write("env: {kwargs: {control: force}}\n")
    assert load_policy(tmp_path).control == "force"


KINDS: list[tuple[str, type[BaseAlgorithm], dict, dict, str]] = [
    ("ppo", PPO, {}, {"net_arch": {"pi": [8, 6], "vf": [5]}, "activation_fn": torch.nn.ELU}, "elu"),
    ("ppo", PPO, {"use_sde": True}, {"net_arch": [8]}, "tanh"),
    ("ppo", PPO, {}, {"net_arch": []}, "relu"),
    ("recurrent_ppo", RecurrentPPO, {}, {"net_arch": [8], "lstm_hidden_size": 7}, "tanh"),
    ("sac", SAC, {"buffer_size": 1}, {"net_arch": [8, 6], "activation_fn": torch.nn.Tanh}, "tanh"),
    ("tqc", TQC, {"buffer_size": 1}, {"net_arch": [8], "n_critics": 3, "n_quantiles": 9}, "relu"),
]


@pytest.mark.parametrize(("name", "algorithm", "more", "network", "activation"), KINDS)
def test_weights_and_configuration_alone_give_the_same_policy(
    name: str,
    algorithm: type[BaseAlgorithm],
    more: dict,
    network: dict,
    activation: str,
    tmp_path: Path,
    observations: np.ndarray,
) -> None:
    kind = "MlpLstmPolicy" if name == "recurrent_ppo" else "MlpPolicy"
    original = algorithm(kind, Blank(), seed=1, device="cpu", policy_kwargs=network, **more)
    original.save(tmp_path / "best_model.zip")
    write_config(tmp_path, name, activation)
    without_pickles(tmp_path / "best_model.zip")
    agent, state, wanted_state = load_policy(tmp_path), None, None
    for _ in range(3):
        wanted, wanted_state = original.predict(observations, wanted_state, deterministic=True)
        action, state = agent.predict(observations, state)
        np.testing.assert_array_equal(action, wanted)


def rewritten(path: Path, **members: bytes) -> None:
    """Replace members of a checkpoint."""
    with zipfile.ZipFile(path) as archive:
        content = {name: archive.read(name) for name in archive.namelist()}
    with zipfile.ZipFile(path, "w") as archive:
        for name, data in (content | {key.replace("_", "."): value for key, value in members.items()}).items():
            archive.writestr(name, data)


def without_pickles(path: Path) -> None:
    rewritten(path, data=b'{"num_timesteps": 1, "_n_updates": 1}')


class Touch:
    """Makes a file when it is unpickled."""

    def __init__(self, file: Path) -> None:
        self.file = file

    def __reduce__(self) -> tuple[Any, ...]:
        return os.mknod, (str(self.file),)


def with_code(path: Path, file: Path) -> None:
    """Let a checkpoint make a file when it is unpickled."""
    import base64
    import json
    import pickle

    with zipfile.ZipFile(path) as archive:
        data = json.loads(archive.read("data"))
    data["policy_class"][":serialized:"] = base64.b64encode(pickle.dumps(Touch(file))).decode()
    rewritten(path, data=json.dumps(data).encode())


@pytest.mark.parametrize("trust", [False, True])
def test_a_strangers_run_runs_no_code(tmp_path: Path, trust: bool, observations: np.ndarray) -> None:
    model(PPO).save(tmp_path / "best_model.zip")
    write_config(tmp_path)
    with_code(tmp_path / "best_model.zip", tmp_path / "ran")
    assert load_policy(tmp_path, trust=trust).predict(observations)[0].shape == (6, 4)
    assert not (tmp_path / "ran").exists()


@pytest.mark.parametrize("config", [None, "", "algorithm: other", "residual: {maneuver: chirp}"])
def test_a_checkpoint_without_its_configuration_is_unpickled_only_on_trust(tmp_path: Path, config: str | None) -> None:
    model(PPO).save(tmp_path / "got.zip")
    with_code(tmp_path / "got.zip", tmp_path / "ran")
    if config is not None:
        (tmp_path / "config.yaml").write_text(config or "{}")
    assert "would be unpickled: that can run code; allowed if you trust its origin: --trust" in refusal(
        tmp_path / "got.zip"
    )
    assert not (tmp_path / "ran").exists()
    refusal(tmp_path / "got.zip", trust=True)
    assert (tmp_path / "ran").exists()


def test_weights_that_are_no_tensors_run_no_code(tmp_path: Path) -> None:
    model(PPO).save(tmp_path / "best_model.zip")
    write_config(tmp_path)
    buffer = io.BytesIO()
    torch.save({"log_std": Touch(tmp_path / "ran")}, buffer)
    rewritten(tmp_path / "best_model.zip", policy_pth=buffer.getvalue())
    assert "no weights of ppo: Weights only load failed" in refusal(tmp_path / "best_model.zip")
    assert not (tmp_path / "ran").exists()


def test_weights_that_state_more_numbers_than_they_hold_are_refused(tmp_path: Path) -> None:
    model(PPO).save(tmp_path / "best_model.zip")
    write_config(tmp_path)
    weights = model(PPO).policy.state_dict()
    weights["mlp_extractor.policy_net.0.weight"] = torch.zeros(1).expand(10**6, 10**6)
    buffer = io.BytesIO()
    torch.save(weights, buffer)
    rewritten(tmp_path / "best_model.zip", policy_pth=buffer.getvalue())
    assert "policy.pth states more numbers than it holds" in refusal(tmp_path / "best_model.zip")


def test_the_configuration_must_fit_the_weights(run_folder: Path, tmp_path: Path) -> None:
    model(PPO).save(tmp_path / "best_model.zip")
    write_config(tmp_path, "sac")
    assert "damaged stable-baselines3 checkpoint: no weights of sac" in refusal(tmp_path / "best_model.zip")
    write_config(tmp_path, activation="sine")
    with pytest.raises(InputError):
        load_policy(tmp_path)


def test_pipes_and_devices_are_no_checkpoints(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "best_model.zip")
    assert "is a pipe; allowed: a regular file" in refusal(tmp_path / "best_model.zip")
    (tmp_path / "zero.zip").symlink_to("/dev/zero")
    assert "is a device; allowed: a regular file" in refusal(tmp_path / "zero.zip")
    model(PPO).save(tmp_path / "final_model.zip")
    os.mkfifo(tmp_path / "config.yaml")
    with pytest.raises(InputError):
        load_policy(tmp_path / "final_model.zip")
