"""Analytic policy gradient: a run like any other, by the twin's gradient."""

from pathlib import Path

import pytest
import torch
from rich.console import Console

from eval.kept.entries import fits, load_entry
from jawenv.base.errors import InputError
from jawenv.envs.configuration import Configuration
from jawenv.envs.observation import OBSERVATION_LAYOUT
from training.cli import main
from training.run.config import TrainingConfig
from training.run.folder import RunFolder
from training.run.pathwise import APG, UNSEEN
from training.run.train import TrainingSession, base_targets

CONFIG = """
algorithm: APG
steps: 40
n_envs: 4
env: {kwargs: {control: targets, reward: worst, comfort_weight: 0.0, episode_s: 2.0}}
residual: {maneuver: refined_one_sided, scale: 0.5}
comfort: {target_discomfort_s: 0.1, episodes: 4}
arguments: {n_steps: 10}
network: {policy: [8], value: [], initial_action_scale: 0.1}
evaluation: {every_steps: 1000, patients: 2}
"""


@pytest.fixture
def config(tmp_path: Path) -> Path:
    path = tmp_path / "apg.yaml"
    path.write_text(CONFIG)
    return path


def test_a_policy_that_is_told_what_is_asked(config: Path, tmp_path: Path) -> None:
    config.write_text(CONFIG.replace("episode_s: 2.0", "episode_s: 2.0, asked: random, comfort_limit_s: 0.01"))
    run = tmp_path / "run"
    assert main(["train", str(config), "--output", str(run)]) == 0
    assert main(["train", "--resume", str(run), "--steps", "80"]) == 0
    world = Configuration(asked="random", episode_s=2.0)
    recording = load_entry(str(run), world).play(2, 5000)
    assert (recording.asked.sum(axis=1) == 2).all()
    with pytest.raises(InputError, match="was trained in jawenv/Jaw-v3 with asked"):
        load_entry(str(run), Configuration())
    assert not fits(Configuration(), world) and fits(Configuration(asked="left"), world)


def test_the_policy_learns_by_the_derivative_of_what_it_reaches(config: Path, tmp_path: Path) -> None:
    training = TrainingConfig.load(config)
    run = RunFolder(tmp_path / "run")
    with TrainingSession(training, run, Console(quiet=True), 0, base_targets(training)) as session:
        model = session.model
        assert isinstance(model, APG)
        bias = model.policy.action_net.bias

        def reached() -> torch.Tensor:
            return model.play(10, seed=0)[0].mean()

        session._worlds.reset()
        (gradient,) = torch.autograd.grad(reached(), bias)
        step = 1e-2 * gradient / gradient.norm()
        with torch.no_grad():
            bias += step
            above = reached()
            bias -= 2.0 * step
            change = above - reached()
        assert change.item() == pytest.approx(2e-2 * gradient.norm().item(), rel=0.3)
        first = model.policy.mlp_extractor.policy_net[0].weight
        assert not any(first[:, OBSERVATION_LAYOUT[name]].any() for name in UNSEEN)
