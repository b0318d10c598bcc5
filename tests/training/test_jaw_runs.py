"""A run on jawenv itself: a correction of a maneuver in a world of its own, with a limit on discomfort."""

import json
import shutil
import zipfile
from pathlib import Path

import numpy as np
import pytest

import agents
import jawenv
from agents.evaluations import read_evaluations
from eval.kept.entries import Settings, load_entries
from jawenv.playing.maneuvers import Maneuver, Player
from jawenv.playing.policies.card import read_card
from jawenv.playing.policies.residual import ResidualPolicy
from tests.recorded import BODY
from training.cli import main
from training.run.best_policy import config_sha256
from training.run.config import BASE_FILE
from training.run.folder import RunFolder

CONFIG = """
algorithm: SAC
steps: 60
n_envs: 2
env: {kwargs: {control: targets, reward: mixed, episode_s: 2.0, knowledge: BODY}}
residual: {maneuver: opening_with_swings, scale: 0.5}
comfort: {target_discomfort_s: 0.05, initial_multiplier: 20.0, rate: 0.1, episodes: 2}
arguments: {learning_starts: 20, batch_size: 16, gradient_steps: 1, ent_coef: auto_0.05}
network: {policy: [8], value: [8], activation: relu, initial_action_scale: 1.0e-6}
evaluation: {every_steps: 1000, patients: 2}
""".replace("BODY", json.dumps(BODY))
WORLD = {
    "comfort": {"force_N": 8.0},
    "anatomy": {"mandible": {"mass_kg": 0.25}},
    "force_sensor": "straps",
    "knowledge": BODY,
}
ENV = {"control": "targets", "episode_s": 2.0, "reward": "mixed", **WORLD}


@pytest.fixture(scope="module")
def trained(tmp_path_factory: pytest.TempPathFactory) -> RunFolder:
    """A run whose files of comfort and anatomy are gone."""
    folder = tmp_path_factory.mktemp("jaw")
    files = {"jaw.yaml": CONFIG, "strict.toml": "force_N = 8.0\n", "jaw.toml": "mandible = {mass_kg = 0.25}\n"}
    for name, text in files.items():
        (folder / name).write_text(text)
    given = {"comfort": folder / "strict.toml", "anatomy": folder / "jaw.toml", "force_sensor": "straps"}
    own = [word for name, value in given.items() for word in ("--set", f"{name}={value}")]
    asked = [folder / "jaw.yaml", "--output", folder / "run", "--residual-on", "refined", *own]
    assert main(["train", *map(str, asked)]) == 0
    for name in files:
        (folder / name).unlink()
    return RunFolder(folder / "run")


def price_of(run: RunFolder) -> float:
    """The price of discomfort in the latest checkpoint."""
    checkpoint = run.latest_checkpoint()
    assert checkpoint is not None
    with zipfile.ZipFile(checkpoint) as archive:
        return float(json.loads(archive.read("data"))["comfort_multiplier"])


def test_a_correction_begins_as_its_maneuver_and_is_played_as_it_was_trained(trained: RunFolder) -> None:
    rows, seed = read_evaluations(trained.path), trained.open().evaluation.seed

    def gained(agent: object) -> float:
        return float(jawenv.play(agent, patients=2, seed=seed, env_kwargs=ENV).information_claimed[:, -1].mean())

    assert rows[0]["information_claimed"] == pytest.approx(gained(Player("refined", control="targets")), abs=1e-2)
    best = agents.load_agent(trained.path, control="targets")
    assert isinstance(best, ResidualPolicy) and best.base.maneuver.name == "refined"
    (row,) = (row for row in rows if row["steps"] == read_card(trained.path).steps)
    assert row["information_claimed"] == pytest.approx(gained(best), abs=1e-3)
    assert rows[-1]["information_claimed"] != rows[0]["information_claimed"]
    assert rows[-1]["worst_sd"] == rows[-1]["worst_sd_10s"]  # the episode is shorter than 10 s
    final = agents.load_agent(trained.latest_checkpoint(), control="targets", trust=True)  # type: ignore[arg-type]
    assert rows[-1]["information_claimed"] == pytest.approx(gained(final), abs=1e-3)


def test_the_best_policy_has_a_card(trained: RunFolder) -> None:
    card, config = read_card(trained.path), trained.open()
    assert card.environment.kwargs().items() >= ENV.items() and card.environment.id == "jawenv/Jaw-v3"
    assert card.residual is not None and card.residual.scale == 0.5
    assert card.residual.maneuver == Maneuver.load(trained.path / BASE_FILE) == Maneuver.named("refined")
    assert (card.algorithm, card.seed, card.steps in (0, 60)) == ("SAC", config.seed, True)
    assert card.config_sha256 == config_sha256(trained.config_file)
    assert len(card.commands) == 1


def test_a_run_goes_on_with_its_price_and_its_world(trained: RunFolder, tmp_path: Path) -> None:
    """Its world is with the run, not in files beside it, and a comparison notes what is another."""
    run = RunFolder(tmp_path / "run")
    shutil.copytree(trained.path, run.path)
    price = price_of(run)
    # 3 batches of 2 episodes; no batch can raise the logarithm by more than 0.2 or lower it by more than 0.1.
    assert price != 20.0 and -0.31 < np.log(price / 20.0) < 0.61
    assert main(["train", "--resume", str(run.path), "--steps", "62"]) == 0
    assert price_of(run) == price and run.open().env.kwargs.items() >= WORLD.items()
    (same,) = load_entries([str(run.path)], Settings.of(**WORLD).world)
    (other,) = load_entries([str(run.path)], Settings().world)
    assert "another" not in same.note and "force_sensor" not in same.note
    for said in ("trained with another comfort", "trained with another anatomy", "trained with force_sensor straps"):
        assert said in other.note


def test_the_hash_of_a_configuration_is_that_of_its_content(tmp_path: Path) -> None:
    texts = {"a": "seed: 7\nsteps: 3\n", "b": "# the same\nsteps: 3\nseed: 7\n", "c": "seed: 8\nsteps: 3\n"}
    for name, text in texts.items():
        (tmp_path / f"{name}.yaml").write_text(text)
    a, b, c = (config_sha256(tmp_path / f"{name}.yaml") for name in texts)
    assert a == b != c
