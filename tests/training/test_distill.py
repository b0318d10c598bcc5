"""A planner distilled into a policy: what is learnt, in which states, and how it goes on after a stop."""

from pathlib import Path

import numpy as np
import pytest
from rich.console import Console

import agents
import jawenv
from agents.evaluations import read_evaluations
from jawenv.playing.policies.card import WEIGHTS, read_card
from tests.recorded import Actions
from training.cli import main
from training.run.config import TrainingConfig
from training.run.folder import RunFolder
from training.run.train import TrainingSession, base_targets
from training.run.worlds import world_seed
from training.search.distill import Distillation, Labels, error_on, fit, is_finished

CONFIG = """
algorithm: ppo
n_envs: 2
env: {kwargs: {control: targets, reward: worst, episode_s: 1.0}}
residual: {maneuver: opening_with_swings, scale: 2.0}
ppo: {n_steps: 5, batch_size: 10, network: {policy: [16], value: [16]}}
evaluation: {every_steps: 1000, patients: 2}
"""
SMALL = ["--planner", "myopic", "--patients", "5"]
STEPS = 5  # of an episode


@pytest.fixture
def config_file(tmp_path: Path) -> Path:
    path = tmp_path / "small.yaml"
    path.write_text(CONFIG)
    return path


def weights(run: RunFolder) -> list[np.ndarray]:
    """Those of its latest checkpoint."""
    policy = agents.load_agent(run.latest_checkpoint(), control="targets", trust=True).agent.policy
    return [value.numpy() for value in policy.state_dict().values()]


def test_a_policy_learns_what_it_is_told(config_file: Path) -> None:
    config = TrainingConfig.load(config_file)
    stream = np.random.default_rng(0)
    with TrainingSession(config, RunFolder(config_file), Console(quiet=True), 0, base_targets(config)) as session:
        seen = stream.normal(size=(5000, *session.model.observation_space.shape)).astype(np.float32)
        wanted = 0.4 * np.tanh(seen[:, :4]).astype(np.float32)
        told, others = Labels(seen[:4000], wanted[:4000]), Labels(seen[4000:], wanted[4000:])
        before = error_on(session.model, others)
        fit(session.model, [told], Distillation(), seed=0)
        assert error_on(session.model, others) < 0.6 * np.sqrt(np.mean(wanted**2)) < 0.9 * before


def test_a_planner_is_distilled_and_a_stopped_distillation_goes_on(config_file: Path, tmp_path: Path, capsys) -> None:
    whole, halves = RunFolder(tmp_path / "whole"), RunFolder(tmp_path / "halves")
    command = ["distill", str(config_file), *SMALL]
    assert main([*command, "--rounds", "2", "--output", str(whole.path)]) == 0
    assert main([*command, "--rounds", "1", "--output", str(halves.path)]) == 0
    # A finished one goes on where more rounds are asked for.
    assert main([*command, "--rounds", "2", "--output", str(halves.path)]) == 0
    for a, b in zip(weights(whole), weights(halves), strict=True):
        np.testing.assert_array_equal(a, b)
    rows = read_evaluations(whole.path)
    assert [row["steps"] for row in rows] == [5 * STEPS, 10 * STEPS]
    capsys.readouterr()
    assert main([*command, "--rounds", "2", "--output", str(whole.path)]) == 0
    assert "nothing to do" in capsys.readouterr().err
    assert main([*command, "--rounds", "2", "--seed", "1", "--output", str(whole.path)]) == 2
    assert "other settings (seed)" in capsys.readouterr().err
    # The planner plays the first round itself: those labels are what it did.
    first = Labels.load(whole.path / "labels" / "round_00.npz")
    env = {"control": "targets", "reward": "worst", "episode_s": 1.0}
    planner, arguments = Actions(), {**env, "track_bound": False}
    myopic = agents.load_agent("myopic", control="targets")
    jawenv.play(myopic, patients=5, seed=world_seed(0, 0), env_kwargs=arguments, on_step=planner)
    base = agents.load_agent(whole.path, control="targets").base
    done = np.array([base.residuals(np.full(5, k), action) for k, action in enumerate(planner.actions)])
    within = np.abs(done).max(axis=(0, 2)) < 1.0  # what is out of a correction's reach is played otherwise
    assert within.any()
    np.testing.assert_allclose(first.residual.reshape(STEPS, 5, 4)[:, within], done[:, within], atol=1e-5)


def test_one_that_is_killed_after_its_labels_goes_on_to_the_same_run(
    config_file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What the labels of a round are there for, its evaluation and the best policy, is made up for."""
    killed, whole = RunFolder(tmp_path / "killed"), RunFolder(tmp_path / "whole")
    command = ["distill", str(config_file), *SMALL, "--rounds", "2", "--output"]

    class KilledError(Exception):
        pass

    def kill(*_: object) -> None:
        raise KilledError

    with monkeypatch.context() as patch, pytest.raises(KilledError):
        patch.setattr("training.search.distill._fit_anew", kill)
        main([*command, str(killed.path)])
    assert (killed.labels / "round_00.npz").exists() and not killed.has_policy()
    for run in (killed, whole):
        assert main([*command, str(run.path)]) == 0
    assert killed.evaluations.read_bytes() == whole.evaluations.read_bytes()
    assert (killed.path / WEIGHTS).read_bytes() == (whole.path / WEIGHTS).read_bytes()
    for a, b in zip(weights(killed), weights(whole), strict=True):
        np.testing.assert_array_equal(a, b)
    assert [path.name for path in killed.checkpoints.iterdir()] == [path.name for path in whole.checkpoints.iterdir()]
    assert is_finished(killed, 2)
    Labels.load(killed.labels / "round_00.npz").save(killed.labels / "round_02.npz")
    assert not is_finished(killed, 3), "the latest checkpoint has not learnt from the last labels"


def test_a_distilled_run_is_trained_on(config_file: Path, tmp_path: Path) -> None:
    run = RunFolder(tmp_path / "run")
    assert main(["distill", str(config_file), *SMALL, "--rounds", "1", "--output", str(run.path)]) == 0
    before = weights(run)
    assert read_card(run.path).algorithm == "distillation of myopic"
    assert main(["train", "--resume", str(run.path), "--steps", "45"]) == 0
    assert [row["steps"] for row in read_evaluations(run.path)] == [25, 45]
    best, rows = read_card(run.path), read_evaluations(run.path)
    assert best.steps == max(rows, key=lambda row: row["return"])["steps"]
    assert best.algorithm.endswith(", then ppo") == (best.steps == 45)
    after = weights(run)
    assert any((a != b).any() for a, b in zip(before, after, strict=True))
    assert all(np.abs(a - b).max() < 0.05 for a, b in zip(before, after, strict=True))  # it went on from there


@pytest.mark.parametrize(
    ("changes", "options", "message"),
    [
        ({}, ["--planner", "nobody"], "planner"),
        ({}, ["--patients", "0"], "patients"),
        ({}, ["--rounds", "0"], "rounds"),
        ({"control: targets": "control: force"}, [], "'force'"),
        ({"residual: {maneuver: opening_with_swings, scale: 2.0}": ""}, [], "--residual-on"),
        ({"algorithm: ppo": "algorithm: sac", "ppo: {": "sac: {}  # {"}, [], "allowed: ppo"),
    ],
)
def test_bad_input_is_one_line(config_file: Path, tmp_path: Path, capsys, changes, options, message) -> None:
    text = CONFIG
    for old, new in changes.items():
        text = text.replace(old, new)
    config_file.write_text(text)
    assert main(["distill", str(config_file), "--output", str(tmp_path / "run"), *options]) == 2
    error = capsys.readouterr().err
    assert error.startswith("error: ") and error.count("\n") == 1 and message in error
    assert not (tmp_path / "run").exists()
