"""Runs on jawenv itself: a correction of a maneuver that is loaded as an agent, and a limit on discomfort."""

import json
import zipfile
from pathlib import Path

import numpy as np
import pytest

import agents
import jawenv
from agents.residual import BASE_FILE, ResidualPolicy
from eval.entries import load_entries
from eval.settings import Settings
from jawenv.playing.maneuvers import Player
from training.cli import main
from training.run.evaluation_table import read_evaluations
from training.run.evaluations import Evaluations
from training.run.folder import RunFolder

CONFIG = """
algorithm: sac
steps: 60
n_envs: 2
env: {kwargs: {control: targets, reward: mixed, episode_s: 2.0}}
residual: {maneuver: opening_with_swings, scale: 0.5}
sac: {learning_starts: 20, batch_size: 16, gradient_steps: 1, network: {units: [8], initial_action_scale: 1.0e-6}}
evaluation: {every_steps: 1000, patients: 2}
"""
COMFORT = "comfort: {target_discomfort_s: 0.05, initial_multiplier: 20.0, rate: 0.1, episodes: 2}\n"
ENV = {"control": "targets", "episode_s": 2.0, "reward": "mixed"}


def train(tmp_path: Path, text: str, *arguments: str) -> RunFolder:
    (tmp_path / "jaw.yaml").write_text(text)
    run = RunFolder(tmp_path / "run")
    assert main(["train", str(tmp_path / "jaw.yaml"), "--output", str(run.path), *arguments]) == 0
    return run


def saved_multiplier(model: Path) -> float:
    with zipfile.ZipFile(model) as archive:
        return float(json.loads(archive.read("data"))["comfort_multiplier"])


def test_a_correction_begins_as_its_maneuver_and_is_played_as_it_was_trained(tmp_path: Path) -> None:
    run = train(tmp_path, CONFIG, "--residual-on", "slow_opening")
    assert (run.path / BASE_FILE).is_file()
    rows = read_evaluations(run)
    seed = run.open().evaluation.seed

    def gained(agent: object) -> float:
        return float(jawenv.play(agent, patients=2, seed=seed, env_kwargs=ENV).information_claimed[:, -1].mean())

    assert rows[0]["information_claimed"] == pytest.approx(gained(Player("slow_opening", control="targets")), abs=1e-3)
    final = agents.load_agent(run.final_model, control="targets")
    assert isinstance(final, ResidualPolicy) and final.base.maneuver.name == "slow_opening"
    assert rows[-1]["information_claimed"] == pytest.approx(gained(final), abs=1e-3)
    assert rows[-1]["information_claimed"] != rows[0]["information_claimed"]
    assert rows[-1]["worst_sd"] == rows[-1]["worst_sd_10s"]  # the episode is shorter than 10 s


def test_price_of_discomfort_is_learned_saved_and_resumed(tmp_path: Path) -> None:
    run = train(tmp_path, CONFIG + COMFORT)
    price = saved_multiplier(run.final_model)
    # 3 batches of 2 episodes; no batch can raise the logarithm by more than 0.2 or lower it by more than 0.1.
    assert price != 20.0 and -0.31 < np.log(price / 20.0) < 0.61
    assert main(["train", "--resume", str(run.path), "--steps", "62"]) == 0
    assert saved_multiplier(run.final_model) == price


def test_a_comfortable_policy_is_better_than_any_that_is_not(tmp_path: Path) -> None:
    evaluations = Evaluations(RunFolder(tmp_path), None, None, lambda: False, _Silent(), 0.05)  # type: ignore[arg-type]
    for steps, mean_return, discomfort, better in (
        (0, 50.0, 0.9, True),
        (1, 40.0, 0.5, True),
        (2, 60.0, 0.6, False),
        (3, 10.0, 0.05, True),
        (4, 70.0, 0.06, False),
        (5, 11.0, 0.01, True),
    ):
        row = {"steps": steps, "return": mean_return, "discomfort_s": discomfort}
        assert evaluations._compare(row) is better, row


def test_a_run_keeps_its_own_comfort_anatomy_and_force_sensor(tmp_path: Path) -> None:
    """With the run, not in files beside it: it goes on without them, and a comparison notes what is another."""
    (tmp_path / "strict.toml").write_text("force_N = 8.0\n")
    (tmp_path / "jaw.toml").write_text("mandible = {mass_kg = 0.25}\n")
    own = ["--comfort", str(tmp_path / "strict.toml"), "--anatomy", str(tmp_path / "jaw.toml")]
    run = train(tmp_path, CONFIG, *own, "--force-sensor", "straps")
    kept = {"comfort": {"force_N": 8.0}, "anatomy": {"mandible": {"mass_kg": 0.25}}, "force_sensor": "straps"}
    assert run.open().env.kwargs.items() >= kept.items()
    assert json.loads((run.path / "env.json").read_text())["kwargs"].items() >= kept.items()
    for name in ("strict.toml", "jaw.toml"):
        (tmp_path / name).unlink()
    assert main(["train", "--resume", str(run.path), "--steps", "62"]) == 0
    (same,) = load_entries([str(run.path)], Settings.of(**kept).world)
    (other,) = load_entries([str(run.path)], Settings().world)
    assert "another" not in same.note and "force_sensor" not in same.note
    for said in ("trained with another comfort", "trained with another anatomy", "trained with force_sensor straps"):
        assert said in other.note


class _Silent:
    def note(self, key: str, text: str) -> None: ...


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("maneuver: opening_with_swings", "maneuver: nowhere.yaml"), "nowhere.yaml: no such file"),
        (
            ("control: targets, ", "control: force, control_hz: 12.5, "),
            "control_hz 12.5: must be a multiple of the 5 decisions",
        ),
    ],
)
def test_unusable_residuals_get_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], change: tuple[str, str], message: str
) -> None:
    (tmp_path / "jaw.yaml").write_text(CONFIG.replace(*change))
    assert main(["train", str(tmp_path / "jaw.yaml"), "--output", str(tmp_path / "run")]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1 and message in error
    assert not (tmp_path / "run").exists()
