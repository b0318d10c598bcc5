"""Each algorithm: what a section makes of it, and that its runs go on after a stop."""

from pathlib import Path

import numpy as np
import pytest
import torch
from point_env import PointVectorEnv
from stable_baselines3 import SAC

from jawenv.errors import InputError
from training.cli import main
from training.run.algorithms import ALGORITHMS, make_model
from training.run.callbacks import FallingNoise
from training.run.config import TrainingConfig
from training.run.evaluation_table import read_evaluations
from training.run.folder import RunFolder
from training.run.vec_env import NativeVecEnv

COMMON = """
steps: 320
n_envs: 8
env: {id: "point_env:Point-v0"}
evaluation: {every_steps: 160, patients: 4}
checkpoints: {every_steps: 160, keep: 2}
"""
OFF_POLICY = (
    "{learning_starts: 80, batch_size: 32, gradient_steps: 2, gamma: 0.9, network: {units: [16], activation: tanh}}"
)
NETWORK = "network: {policy: [16], value: [16]"
SECTIONS = {
    "ppo": f"{{n_steps: 20, batch_size: 80, {NETWORK}}}}}",
    "recurrent_ppo": f"{{n_steps: 20, batch_size: 80, n_epochs: 1, {NETWORK}, lstm_units: 8}}}}",
    "sac": OFF_POLICY,
    "tqc": OFF_POLICY.replace("{learning", "{n_quantiles: 5, learning"),
}


@pytest.fixture(params=SECTIONS)
def config(request: pytest.FixtureRequest, tmp_path: Path) -> Path:
    path = tmp_path / "config.yaml"
    path.write_text(f"algorithm: {request.param}\n{COMMON}{request.param}: {SECTIONS[request.param]}\n")
    return path


def worlds() -> NativeVecEnv:
    return NativeVecEnv(PointVectorEnv(8, "same_step"))


def test_a_run_is_trained_evaluated_and_resumed(config: Path, tmp_path: Path) -> None:
    run = RunFolder(tmp_path / "run")
    assert main(["train", str(config), "--output", str(run.path)]) == 0
    algorithm = ALGORITHMS[TrainingConfig.load(config).algorithm]
    first = algorithm.load(run.final_model, device="cpu")
    assert first.num_timesteps == 320 and first._n_updates > 0
    assert main(["train", "--resume", str(run.path), "--steps", "640"]) == 0
    second = algorithm.load(run.final_model, device="cpu")
    assert second.num_timesteps == 640 and second._n_updates > first._n_updates
    rows = read_evaluations(run)
    assert [row["steps"] for row in rows] == [0, 160, 320, 480, 640]
    assert all(row["return"] != row["return_sampled"] for row in rows)


def test_sections_reach_the_model(config: Path) -> None:
    wanted = TrainingConfig.load(config)
    model = make_model(wanted, worlds())
    assert type(model) is ALGORITHMS[wanted.algorithm]
    assert model.gamma == wanted.section.gamma and model.batch_size == wanted.section.batch_size  # type: ignore[attr-defined]


def test_entropy_coefficient_goes_on_where_it_was(tmp_path: Path) -> None:
    path, run = tmp_path / "sac.yaml", RunFolder(tmp_path / "run")
    path.write_text(f"algorithm: sac\n{COMMON}sac: {OFF_POLICY}\n")
    assert main(["train", str(path), "--output", str(run.path)]) == 0
    before = SAC.load(run.final_model).log_ent_coef
    assert before is not None and before.item() != pytest.approx(np.log(0.05), abs=1e-6)
    # So many random actions first that nothing is learned: what is saved again is what was read.
    config = TrainingConfig.load(run.config_file)
    config.changed(sac=config.sac.model_dump() | {"learning_starts": 1000}).save(run.config_file)
    assert main(["train", "--resume", str(run.path), "--steps", "400"]) == 0
    after = SAC.load(run.final_model).log_ent_coef
    assert after is not None and torch.equal(before, after)


@pytest.mark.parametrize("algorithm", ["ppo", "sac"])
def test_small_first_actions(algorithm: str, tmp_path: Path) -> None:
    (tmp_path / "c.yaml").write_text(f"algorithm: {algorithm}\n{COMMON}{algorithm}: {{batch_size: 64}}\n")
    config = TrainingConfig.load(tmp_path / "c.yaml")
    seen = np.random.default_rng(0).uniform(-1, 1, (50, 3)).astype(np.float32)
    sizes = []
    for scale in (1.0, 0.1):
        section = {"batch_size": 64, "network": {"initial_action_scale": scale}}
        model = make_model(config.changed(**{algorithm: section}), worlds())
        sizes.append(np.abs(model.predict(seen, deterministic=True)[0]).max())
    assert 0.0 < sizes[1] < 0.2 * sizes[0]


def test_noise_falls_linearly_and_is_not_learned(tmp_path: Path) -> None:
    network = "network: {policy: [8], value: [8], initial_log_std: -1.0, final_log_std: -2.0}"
    (tmp_path / "c.yaml").write_text(f"{COMMON}ppo: {{n_steps: 20, batch_size: 80, {network}}}\n")
    config = TrainingConfig.load(tmp_path / "c.yaml")
    model = make_model(config, worlds())
    model.learn(320, FallingNoise(config.ppo.network, 640))
    log_std = model.policy.log_std
    assert log_std.tolist() == pytest.approx([-1.25] * 2)  # as set at the last rollout's start, 160 of 640 steps
    assert not log_std.requires_grad


def test_unknown_device_is_named() -> None:
    with pytest.raises(InputError):
        make_model(TrainingConfig(device="abacus"), worlds())
