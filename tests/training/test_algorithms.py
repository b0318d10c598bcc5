"""Each algorithm: what a section makes of it, its policy as plain weights, and that its runs go on after a stop."""

from pathlib import Path

import gymnasium as gym
import numpy as np
import pytest
import torch
from gymnasium import spaces
from point_env import PointVectorEnv
from rich.console import Console
from safetensors.numpy import save
from stable_baselines3 import SAC, TD3
from stable_baselines3.common.vec_env import DummyVecEnv

from agents.evaluations import read_evaluations
from jawenv.base.files import validate
from jawenv.base.progress import Progress
from jawenv.envs.observation import Parts
from jawenv.playing.policies.card import ModelCard
from jawenv.playing.policies.plain import PlainPolicy
from jawenv.sb3 import NativeVecEnv
from tests.plain_policies import fields
from training.cli import main
from training.run.algorithms import ALGORITHMS, make_model, plain_policy
from training.run.callbacks import Interrupt, Upkeep
from training.run.config import TrainingConfig
from training.run.folder import RunFolder

COMMON = """
steps: 320
n_envs: 8
env: {id: "point_env:Point-v0"}
evaluation: {every_steps: 160, patients: 4}
checkpoints: {every_steps: 160, keep: 2}
"""
ROLLOUT = "n_steps: 20, batch_size: 80"
OFF_POLICY = "learning_starts: 80, batch_size: 32, gradient_steps: 2, gamma: 0.9"
ARGUMENTS = {
    "PPO": ROLLOUT,
    "RecurrentPPO": f"{ROLLOUT}, n_epochs: 1, policy_kwargs: {{lstm_hidden_size: 8}}",
    "A2C": "n_steps: 20",
    "SAC": f"{OFF_POLICY}, ent_coef: auto_0.05",
    "TQC": f"{OFF_POLICY}, policy_kwargs: {{n_quantiles: 5}}",
    "TD3": OFF_POLICY,
}
CARDED = [name for name in ARGUMENTS if name != "RecurrentPPO"]
"""Algorithms whose networks a card describes."""


@pytest.fixture(params=ARGUMENTS)
def config(request: pytest.FixtureRequest, tmp_path: Path) -> Path:
    path = tmp_path / "config.yaml"
    path.write_text(
        f"algorithm: {request.param}\n{COMMON}arguments: {{{ARGUMENTS[request.param]}}}\n"
        "network: {policy: [16], value: [16]}\n"
    )
    return path


def test_a_run_is_trained_evaluated_and_resumed(config: Path, tmp_path: Path) -> None:
    run = RunFolder(tmp_path / "run")
    algorithm = ALGORITHMS[TrainingConfig.load(config).algorithm]
    assert main(["train", str(config), "--output", str(run.path)]) == 0
    checkpoint = run.latest_checkpoint()
    assert checkpoint is not None
    first = algorithm.load(checkpoint, device="cpu")
    assert first.num_timesteps == 320 and first._n_updates > 0
    if algorithm is SAC:  # its coefficient of entropy was learned, and goes on where it was
        assert first.log_ent_coef is not None and first.log_ent_coef.item() != pytest.approx(np.log(0.05), abs=1e-6)
        # So many random actions first that nothing is learned: what is saved again is what was read.
        run.open().changed(arguments={"learning_starts": 1000}).save(run.config_file)
    assert main(["train", "--resume", str(run.path), "--steps", "480"]) == 0
    checkpoint = run.latest_checkpoint()
    assert checkpoint is not None
    second = algorithm.load(checkpoint, device="cpu")
    assert second.num_timesteps == 480
    if algorithm is SAC:
        assert torch.equal(first.log_ent_coef, second.log_ent_coef)
    else:
        assert second._n_updates > first._n_updates
    rows = read_evaluations(run.path)
    steps = [row["steps"] for row in rows]
    assert steps[0] == 0 and {320, 480} <= set(steps) and 4 <= len(steps) <= 8
    assert all((row["return"] != row["return_sampled"]) is (algorithm is not TD3) for row in rows)


class Blank(gym.Env):
    """Has the spaces of the jaw; nobody steps it."""

    observation_space = spaces.Box(-np.inf, np.inf, (Parts().size,), np.float32)
    action_space = spaces.Box(-1.0, 1.0, (4,), np.float32)


@pytest.mark.parametrize("hidden", [(8, 6), ()])
@pytest.mark.parametrize(("algorithm", "activation"), [*((name, "relu") for name in CARDED), ("PPO", "elu")])
def test_plain_weights_act_as_the_model(algorithm: str, activation: str, hidden: tuple[int, ...]) -> None:
    network = {"policy": hidden, "activation": activation}
    wanted = TrainingConfig(algorithm=algorithm, network=network, arguments={"gamma": 0.7})
    model = make_model(wanted, DummyVecEnv([Blank]))
    assert type(model) is ALGORITHMS[algorithm] and model.gamma == 0.7  # type: ignore[attr-defined]
    plain_weights = plain_policy(model, wanted)
    assert plain_weights is not None
    architecture, weights = plain_weights
    assert architecture.layers == (Parts().size, *hidden, 4)
    card = validate(ModelCard, fields(save(weights), architecture=architecture), "card")
    plain = PlainPolicy("plain", card, weights)
    seen = np.random.default_rng(0).normal(size=(20, Parts().size)).astype(np.float32)
    action, _ = model.predict(seen, deterministic=True)
    np.testing.assert_allclose(plain.predict(seen)[0], action, rtol=1e-4, atol=1e-6)
    assert np.abs(action).max() > 1e-4


@pytest.mark.parametrize("algorithm", ["PPO", "SAC", "TD3"])
def test_small_first_actions(algorithm: str) -> None:
    seen = np.random.default_rng(0).uniform(-1, 1, (50, 3)).astype(np.float32)
    sizes = []
    for scale in (1.0, 0.1):
        wanted = TrainingConfig(algorithm=algorithm, network={"initial_action_scale": scale})
        model = make_model(wanted, NativeVecEnv(PointVectorEnv(8, "same_step")))
        sizes.append(np.abs(model.predict(seen, deterministic=True)[0]).max())
    assert 0.0 < sizes[1] < 0.2 * sizes[0]


def test_noise_falls_linearly_and_is_not_learned(tmp_path: Path) -> None:
    network = {"policy": [8], "value": [8], "initial_log_std": -1.0, "final_log_std": -2.0}
    config = TrainingConfig(steps=640, n_envs=8, arguments={"n_steps": 20, "batch_size": 80}, network=network)
    model = make_model(config, NativeVecEnv(PointVectorEnv(8, "same_step")))
    progress = Progress(640, "steps", Console(quiet=True))
    model.learn(320, Upkeep(config, RunFolder(tmp_path), Interrupt(), progress))
    log_std = model.policy.log_std
    assert log_std.tolist() == pytest.approx([-1.25] * 2)  # as set at the last rollout's start, 160 of 640 steps
    assert not log_std.requires_grad


def test_networks_that_no_card_describes() -> None:
    for values in (
        {"algorithm": "CrossQ"},
        {"algorithm": "SAC", "arguments": {"use_sde": True}},
        {"algorithm": "RecurrentPPO"},
        {"network": {"features": "torch:tanh"}},
        {"algorithm": "TD3", "network": {"features": "torch:tanh"}},
    ):
        wanted = TrainingConfig(**values)  # type: ignore[arg-type]
        assert plain_policy(make_model(wanted, NativeVecEnv(PointVectorEnv(8, "same_step"))), wanted) is None
