"""Policies: weights and a card are played in NumPy, checkpoints on trust alone, and what does not fit is refused."""

import base64
import json
import os
import pickle
import zipfile
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium import spaces
from safetensors.numpy import save
from sb3_contrib import TQC, RecurrentPPO
from stable_baselines3 import PPO, SAC
from stable_baselines3.common.base_class import BaseAlgorithm

import agents
import jawenv
from agents.policies import load_policy
from jawenv.base.errors import InputError
from jawenv.envs.observation import Parts
from jawenv.playing.agents import Agent
from jawenv.playing.maneuvers import Maneuver, Player
from jawenv.playing.policies.controller import ControlledAgent
from jawenv.playing.policies.plain import PlainPolicy
from jawenv.playing.policies.residual import N_FEATURES, ResidualPolicy
from tests.plain_policies import random_weights, write_corrector, write_policy
from tests.processes import python


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return write_policy(tmp_path / "shared")


def observations(worlds: int = 6) -> np.ndarray:
    return np.random.default_rng(0).normal(size=(worlds, Parts().size)).astype(np.float32)


def refused(path: Path, **kwargs: Any) -> str:
    with pytest.raises(InputError) as caught:
        load_policy(path, **kwargs)
    message = str(caught.value)
    assert "\n" not in message and path.name in message
    return message


def test_it_computes_the_layers_of_the_card(folder: Path) -> None:
    agent, weights = agents.load_agent(folder, control="trajectory"), random_weights()
    assert isinstance(agent, PlainPolicy) and isinstance(agent, Agent) and agent.name == "shared"
    hidden = np.tanh(observations() @ weights["layers.0.weight"].T + weights["layers.0.bias"])
    expected = np.clip(hidden @ weights["layers.1.weight"].T + weights["layers.1.bias"], -1.0, 1.0)
    agent.reset(6, seed=0)
    action, state = agent.predict(observations())
    assert action.dtype == np.float32 and state is None
    np.testing.assert_allclose(action, expected, atol=1e-5)
    assert 0 < (np.abs(action) == 1.0).sum() < action.size  # clipped, but not everywhere
    np.testing.assert_array_equal(agent.predict(observations()[2])[0], action[2])
    assert agents.load_agent(str(folder / "card.json"), control="trajectory").name == "shared"


def test_neither_torch_nor_pickle_is_needed(folder: Path) -> None:
    code = (
        "import agents, numpy, pickle, sys\n"
        "del pickle.loads, pickle.load, pickle.Unpickler\n"
        f"agent = agents.load_agent({str(folder)!r}, control='trajectory')\n"
        f"assert agent.predict(numpy.zeros({Parts().size}, dtype='f4'))[0].shape == (4,)\n"
        "assert not {'torch', 'stable_baselines3', 'matplotlib'} & set(sys.modules)\n"
    )
    python("-c", code, cwd=Path(agents.__file__).parents[1])


@pytest.mark.parametrize(
    ("changed", "told"),
    [
        ({"layers.0.bias": np.zeros(6, np.float32)}, "layers.0.bias"),
        ({"layers.0.bias": np.zeros(5)}, "float32"),
        ({"layers.2.bias": np.zeros(4, np.float32)}, "layers.2.bias"),
        ({"layers.1.bias": np.full(4, np.nan, np.float32)}, "layers.1.bias"),
    ],
)
def test_weights_that_do_not_fit_the_card_are_refused(tmp_path: Path, changed: dict, told: str) -> None:
    path = write_policy(tmp_path / "odd", random_weights() | changed)
    assert told in refused(path)


def test_other_weights_or_none_are_refused(folder: Path) -> None:
    (folder / "policy.safetensors").write_bytes(save(random_weights() | {"layers.1.bias": np.ones(4, np.float32)}))
    assert "sha256" in refused(folder)
    (folder / "policy.safetensors").unlink()
    with pytest.raises(InputError):
        load_policy(folder)


def test_a_policy_of_another_environment_is_refused(folder: Path, tmp_path: Path) -> None:
    assert "jawenv/JawPortions-v3" in refused(folder, env_id="portions")
    layers = (9, 5, 4)
    architecture = {"layers": layers, "activation": "relu", "squash": "tanh"}
    small = write_policy(tmp_path / "small", random_weights(layers), observation_size=9, architecture=architecture)
    assert "9 values" in refused(small)


def test_a_policy_of_the_motors_keeps_the_control_of_its_card(folder: Path) -> None:
    agent = agents.load_agent(folder, control="trajectory")
    assert agent.control == "trajectory"  # type: ignore[attr-defined]
    with pytest.raises(InputError):
        agents.load_agent(folder)
    with pytest.raises(InputError):
        jawenv.play(agent, patients=1, seed=0, env_kwargs={"control": "force"})


def test_a_policy_on_a_maneuver_corrects_it_in_every_control(tmp_path: Path) -> None:
    still = load_policy(write_corrector(tmp_path / "still", "chirp", gain=0.0, control_hz=10.0))
    player = Player("chirp", control="targets", control_hz=10.0)
    for _ in range(20):
        np.testing.assert_allclose(still.predict(observations())[0], player.predict(observations())[0], atol=1e-6)
    with pytest.raises(InputError):
        still.predict(np.zeros((2, 4), dtype=np.float32))
    folder = write_corrector(tmp_path / "run", "slow_opening")
    loaded = agents.load_agent(folder, control="targets")
    assert isinstance(loaded, ResidualPolicy) and loaded.base.maneuver == Maneuver.named("slow_opening")
    followed = agents.load_agent(folder, control="force")
    assert isinstance(followed, ControlledAgent) and isinstance(followed.agent, ResidualPolicy)
    with pytest.raises(InputError):
        agents.load_agent(folder, control="force", control_hz=12.0)


class Blank(gym.Env):
    """Has the spaces that a policy is built for; nobody steps it."""

    def __init__(self, actions: int = 4, seen: int = Parts().size) -> None:
        self.observation_space = spaces.Box(-np.inf, np.inf, (seen,), np.float32)
        self.action_space = spaces.Box(-1.0, 1.0, (actions,), np.float32)


def saved(
    path: Path, algorithm: type[BaseAlgorithm] = PPO, env: Blank | None = None, **kwargs: object
) -> BaseAlgorithm:
    policy = "MlpLstmPolicy" if algorithm is RecurrentPPO else "MlpPolicy"
    net = {"net_arch": [8, 8]}
    model = algorithm(policy, env or Blank(), seed=1, device="cpu", policy_kwargs=net, **kwargs)
    path.parent.mkdir(exist_ok=True, parents=True)
    model.save(path)
    return model


@pytest.mark.parametrize(
    ("algorithm", "kwargs"),
    [(PPO, {"use_sde": True}), (SAC, {"buffer_size": 1}), (TQC, {"buffer_size": 1}), (RecurrentPPO, {})],
)
def test_a_trusted_checkpoint_acts_as_the_model(algorithm: type[BaseAlgorithm], kwargs: dict, tmp_path: Path) -> None:
    original = saved(tmp_path / "zoo" / "step_100.zip", algorithm, **kwargs)
    agent = agents.load_agent(tmp_path / "zoo" / "step_100.zip", trust=True)
    assert isinstance(agent, Agent) and agent.name == "zoo/step_100"
    state = wanted_state = None
    for _ in range(2):
        wanted, wanted_state = original.predict(observations(), wanted_state, deterministic=True)
        action, state = agent.predict(observations(), state)
        np.testing.assert_array_equal(action, wanted)


def test_a_checkpoint_in_a_runs_folder_corrects_the_runs_maneuver(tmp_path: Path) -> None:
    run = write_corrector(tmp_path / "run", "slow_opening")
    saved(run / "checkpoints" / "step_1.zip", env=Blank(seen=Parts().size + N_FEATURES))
    agent = agents.load_agent(run / "checkpoints" / "step_1.zip", trust=True)
    assert isinstance(agent, ResidualPolicy) and agent.base.maneuver.name == "slow_opening"
    assert agents.registry.world_of(run / "checkpoints" / "step_1.zip") == agents.registry.world_of(run)


def test_drawn_actions_follow_the_seed(tmp_path: Path) -> None:
    saved(tmp_path / "got.zip")
    agent = load_policy(tmp_path / "got.zip", trust=True)
    draws = []
    for seed in (1, 1, 2):
        agent.reset(6, seed)
        draws.append(agent.predict(observations(), deterministic=False)[0])
    np.testing.assert_array_equal(draws[0], draws[1])
    assert not np.array_equal(draws[0], draws[2])


def test_what_is_no_policy_is_refused(tmp_path: Path) -> None:
    for name in ("missing.zip", "."):
        with pytest.raises(InputError):
            load_policy(tmp_path / name, trust=True)
    (tmp_path / "notes.zip").write_text("not a zip")
    saved(tmp_path / "whole.zip")
    whole = (tmp_path / "whole.zip").read_bytes()
    (tmp_path / "cut.zip").write_bytes(whole[: len(whole) // 2])
    np.savez(tmp_path / "arrays.npz", a=np.zeros(3))
    os.mkfifo(tmp_path / "pipe.zip")
    (tmp_path / "zero.zip").symlink_to("/dev/zero")
    for name in ("notes.zip", "cut.zip", "arrays.npz", "pipe.zip", "zero.zip"):
        refused(tmp_path / name, trust=True)


def test_a_checkpoint_of_other_spaces_is_refused(tmp_path: Path) -> None:
    saved(tmp_path / "two.zip", env=Blank(actions=2))
    assert "(2,)" in refused(tmp_path / "two.zip", trust=True)
    saved(tmp_path / "small.zip", env=Blank(seen=5))
    for env_id in ("jawenv/Jaw-v3", "jawenv/JawHinge-v3"):
        assert "5 values" in refused(tmp_path / "small.zip", env_id=env_id, trust=True)


@pytest.mark.parametrize("place", ["vecnormalize.pkl", "Jaw-v3/vecnormalize.pkl", "model_vecnormalize_100_steps.pkl"])
def test_a_policy_that_saw_normalised_observations_is_refused(place: str, tmp_path: Path) -> None:
    """It would play on what it has never seen, and nobody would notice."""
    saved(tmp_path / "zoo.zip")
    (tmp_path / place).parent.mkdir(exist_ok=True)
    (tmp_path / place).touch()
    assert place in refused(tmp_path / "zoo.zip", trust=True)


class Touch:
    """Makes a file when it is unpickled."""

    def __init__(self, file: Path) -> None:
        self.file = file

    def __reduce__(self) -> tuple[Any, ...]:
        return os.mknod, (str(self.file),)


def with_code(path: Path, file: Path) -> None:
    """Let a checkpoint make a file when it is unpickled."""
    with zipfile.ZipFile(path) as archive:
        content = {name: archive.read(name) for name in archive.namelist()}
    data = json.loads(content["data"])
    data["policy_class"][":serialized:"] = base64.b64encode(pickle.dumps(Touch(file))).decode()
    with zipfile.ZipFile(path, "w") as archive:
        for name, held in (content | {"data": json.dumps(data).encode()}).items():
            archive.writestr(name, held)


def test_a_checkpoint_is_unpickled_only_on_trust(tmp_path: Path) -> None:
    run = write_corrector(tmp_path / "run", "slow_opening")
    for path in (tmp_path / "got.zip", run / "checkpoints" / "step_1.zip"):
        saved(path)
        with_code(path, tmp_path / "ran")
        assert "--trust" in refused(path) and not (tmp_path / "ran").exists()
    load_policy(run, trust=True)
    assert not (tmp_path / "ran").exists(), "a run's policy is no pickle"
    refused(tmp_path / "got.zip", trust=True)
    assert (tmp_path / "ran").exists()
