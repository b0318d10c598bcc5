"""``python -m training export``: the folder acts as the run's best policy, and its card says what it is."""

import hashlib
import json
import sys
from datetime import UTC, datetime
from pathlib import Path

import gymnasium as gym
import numpy as np
import pytest
from gymnasium import spaces
from stable_baselines3 import PPO, SAC
from stable_baselines3.common.base_class import BaseAlgorithm

import agents
import jawenv
from agents.card import read_card
from agents.residual import N_FEATURES
from jawenv.envs.observation import OBSERVATION_SIZE
from jawenv.playing.maneuvers import Maneuver
from training.cli import main
from training.run.config import EnvConfig, TrainingConfig
from training.run.export import _environment, config_sha256

KWARGS = {"control": "trajectory", "episode_s": 5.0, "device": {"cell_force_N": 0.2}}


class Blank(gym.Env):
    """Has the spaces that a policy is built for; nobody steps it."""

    observation_space = spaces.Box(-np.inf, np.inf, (OBSERVATION_SIZE,), np.float32)
    action_space = spaces.Box(-1.0, 1.0, (4,), np.float32)


class BlankWithTargets(Blank):
    """The same for a policy that corrects a maneuver."""

    observation_space = spaces.Box(-np.inf, np.inf, (OBSERVATION_SIZE + N_FEATURES,), np.float32)


def write_run(
    folder: Path, algorithm: type[BaseAlgorithm] = PPO, env_id: str = "jawenv/Jaw-v2", **more: object
) -> Path:
    """The folder of a run whose policy has learned nothing for 1,234 steps."""
    model = algorithm("MlpPolicy", Blank(), seed=1, device="cpu", policy_kwargs={"net_arch": [8, 6]}, **more)
    model.num_timesteps = 1234
    folder.mkdir()
    model.save(folder / "best_model.zip")
    name = "sac" if algorithm is SAC else "ppo"
    TrainingConfig(algorithm=name, seed=7, env={"id": env_id, "kwargs": KWARGS}).save(folder / "config.yaml")
    sessions = [{"command": "python -m training train ppo"}, {"command": "python -m training train ppo --resume a"}]
    (folder / "repeat.json").write_text(json.dumps({"sessions": sessions}))
    return folder


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_run(tmp_path_factory.mktemp("runs") / "first")


def export(run: Path, output: Path, *more: object) -> int:
    return main(["export", str(run), "--output", str(output), *map(str, more)])


def refusal(capsys: pytest.CaptureFixture[str], run: Path, output: Path, *more: object) -> str:
    capsys.readouterr()
    assert export(run, output, *more) == 2
    error = capsys.readouterr().err
    assert error.startswith("error: ") and error.count("\n") == 1
    return error


@pytest.mark.parametrize(("algorithm", "more"), [(PPO, {}), (PPO, {"use_sde": True}), (SAC, {"buffer_size": 1})])
def test_it_acts_as_the_model(algorithm: type[BaseAlgorithm], more: dict, tmp_path: Path) -> None:
    run = write_run(tmp_path / "run", algorithm, **more)
    assert export(run, tmp_path / "shared") == 0
    observation = np.random.default_rng(0).normal(size=(50, OBSERVATION_SIZE)).astype(np.float32)
    wanted = algorithm.load(run / "best_model.zip").predict(observation, deterministic=True)[0]
    action = agents.load_agent(tmp_path / "shared", control="trajectory").predict(observation)[0]
    np.testing.assert_allclose(action, wanted, rtol=0.0, atol=1e-6)
    assert np.abs(wanted).max() > 0.01


def test_the_card_says_what_it_is(run: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "argv", ["training", "export", "a run"])
    assert export(run, tmp_path / "shared", "--licence", "CC-BY-4.0") == 0
    card = read_card(tmp_path / "shared")
    assert card.environment.kwargs() == KWARGS | {
        "control_hz": 20.0,
        "sensors": "pose",
        "reward": "uncertainty",
        "cohort": "trismus",
    }
    assert (card.environment.id, card.algorithm, card.seed, card.steps) == ("jawenv/Jaw-v2", "ppo", 7, 1234)
    assert card.architecture.layers == (OBSERVATION_SIZE, 8, 6, 4)
    assert (card.architecture.activation, card.architecture.squash) == ("tanh", "clip")
    weights = (tmp_path / "shared" / "policy.safetensors").read_bytes()
    assert card.weights_sha256 == hashlib.sha256(weights).hexdigest()
    assert card.config_sha256 == config_sha256(run / "config.yaml")
    assert card.licence == "CC-BY-4.0" and abs((card.date - datetime.now(UTC).date()).days) <= 1
    assert len(card.commands) == 3 and card.commands[-1] == "python -m training export 'a run'"
    assert card.residual is None and card.results == ()


def test_a_cohort_of_ones_own_goes_into_the_card(tmp_path: Path) -> None:
    mine = jawenv.cohort("trismus").to_dict() | {"name": "mine"}
    (tmp_path / "mine.json").write_text(json.dumps(mine))
    assert _environment(EnvConfig(kwargs={"cohort": str(tmp_path / "mine.json")})).cohort == mine


def test_the_hash_of_the_configuration_is_that_of_its_content(run: Path, tmp_path: Path) -> None:
    lines = (run / "config.yaml").read_text().splitlines()
    assert lines[0].startswith("algorithm") and lines[1].startswith("seed")
    (tmp_path / "moved.yaml").write_text("\n".join(["# the same", *lines[1:], lines[0]]))
    (tmp_path / "other.yaml").write_text("\n".join(lines).replace("seed: 7", "seed: 8"))
    assert config_sha256(tmp_path / "moved.yaml") == config_sha256(run / "config.yaml")
    assert config_sha256(tmp_path / "other.yaml") != config_sha256(run / "config.yaml")


def test_results_come_from_a_file(run: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    row = "cohort: trismus, patients: 64, seeds: [500, 563], metric: 'true information, nats', low: 44.4, high: 46.5"
    (tmp_path / "good.yaml").write_text(f"results:\n- {{{row}, mean: 45.5}}\n")
    (tmp_path / "bad.yaml").write_text(f"results:\n- {{{row}}}\n")
    assert export(run, tmp_path / "shared", "--results", tmp_path / "good.yaml") == 0
    (result,) = read_card(tmp_path / "shared").results
    assert (result.mean, result.low, result.seeds, result.level) == (45.5, 44.4, (500, 563), 0.95)
    message = refusal(capsys, run, tmp_path / "none", "--results", tmp_path / "bad.yaml")
    assert "bad.yaml: results.0: true information, nats: give either mean or median" in message
    assert not (tmp_path / "none").exists()


def test_a_maneuver_that_is_corrected_goes_into_the_card_whole(tmp_path: Path) -> None:
    """The exported policy acts as the run's, maneuver included."""
    run = tmp_path / "run"
    run.mkdir()
    model = PPO("MlpPolicy", BlankWithTargets(), seed=1, device="cpu", policy_kwargs={"net_arch": [8, 6]})
    model.save(run / "best_model.zip")
    kwargs = {"control": "targets", "episode_s": 5.0}
    residual = {"maneuver": "slow_opening", "scale": 0.3}
    TrainingConfig().changed(env={"id": "jawenv/Jaw-v2", "kwargs": kwargs}, residual=residual).save(run / "config.yaml")
    assert export(run, tmp_path / "shared") == 0
    card = read_card(tmp_path / "shared")
    assert card.residual is not None and card.residual.scale == 0.3
    assert card.residual.maneuver == Maneuver.named("slow_opening")
    trained, shared = (agents.load_agent(path, control="targets") for path in (run, tmp_path / "shared"))
    stream = np.random.default_rng(0)
    for _ in range(4):
        observation = stream.normal(size=(3, OBSERVATION_SIZE)).astype(np.float32)
        wanted = trained.predict(observation)[0]
        np.testing.assert_allclose(shared.predict(observation)[0], wanted, rtol=0.0, atol=1e-6)


def test_nothing_is_replaced_unasked(run: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    output = tmp_path / "shared"
    assert export(run, output) == 0
    assert "already holds an exported policy; replace it with --overwrite" in refusal(capsys, run, output)
    assert export(run, output, "--overwrite", "--licence", "CC0-1.0") == 0
    assert read_card(output).licence == "CC0-1.0"
    assert "something other than an exported policy" in refusal(capsys, run, run, "--overwrite")
    (tmp_path / "file").write_text("text")
    assert "is a file; name a folder" in refusal(capsys, run, tmp_path / "file")


def test_an_export_that_was_stopped_is_given_again(
    run: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    shared = tmp_path / "shared"
    assert export(run, shared) == 0
    files = {path.name for path in shared.iterdir()}
    (shared / "card.json").unlink()
    (shared / ".card.json.0123.unfinished").write_text("{")
    assert export(run, shared) == 0
    assert {path.name for path in shared.iterdir()} == files == {"card.json", "policy.safetensors", "README.md"}
    assert "already holds an exported policy" in refusal(capsys, run, shared)
