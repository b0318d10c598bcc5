"""Parts of one's own in a run: features, an objective, and where a policy with them plays."""

import re
from pathlib import Path

import pytest

import agents
import jawenv
from agents.evaluations import read_evaluations
from jawenv.base.errors import InputError
from jawenv.playing.policies.residual import ResidualPolicy
from training.cli import main
from training.run.folder import RunFolder

MODULE = """
from agents.twin.objective import log_worst

def shown(rows):
    return rows[:, :30].tanh()

def doubled(worlds):
    return 2.0 * log_worst(worlds)

def summed(worlds):
    return log_worst(worlds).sum()

def broken(worlds):
    return 1 / 0
"""
CONFIG = """
algorithm: APG
steps: 40
n_envs: 4
env: {kwargs: {control: targets, reward: worst, episode_s: 2.0}}
residual: {maneuver: refined_one_sided, scale: 0.5}
arguments: {n_steps: 10, objective: "MODULE:doubled"}
network: {policy: [8], value: [], features: "MODULE:shown"}
evaluation: {every_steps: 1000, patients: 2}
"""


@pytest.fixture
def module(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """A module of the user's in the current folder."""
    name = f"parts_of_{tmp_path.name}"
    (tmp_path / f"{name}.py").write_text(MODULE)
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(tmp_path))
    return name


def test_a_policy_sees_its_features_wherever_it_plays_and_is_not_exported(
    module: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run = RunFolder(tmp_path / "run")
    (tmp_path / "own.yaml").write_text(CONFIG.replace("MODULE", module))
    assert main(["train", "own.yaml", "--output", str(run.path)]) == 0
    said = capsys.readouterr().out
    assert "no card describes this network: the best policy is kept as best_model.zip" in said
    assert "evaluating the movement that it begins with on 2 patients" in said
    assert main(["train", "--resume", str(run.path), "--steps", "80"]) == 0
    checkpoint = run.latest_checkpoint()
    assert checkpoint is not None and not (run.path / "card.json").exists() and run.best_model.exists()
    with pytest.raises(InputError, match="--trust"):
        agents.load_agent(checkpoint)
    final = agents.load_agent(checkpoint, control="targets", trust=True)
    assert isinstance(final, ResidualPolicy) and final.agent.policy.features_extractor.features_dim == 30  # type: ignore[attr-defined]
    kwargs = {"control": "targets", "reward": "worst", "episode_s": 2.0}
    played = jawenv.play(final, patients=2, seed=run.open().evaluation.seed, env_kwargs=kwargs)
    last = read_evaluations(run.path)[-1]
    assert last["information_claimed"] == pytest.approx(played.information_claimed[:, -1].mean(), abs=1e-3)
    capsys.readouterr()
    assert main(["export", str(run.path), "--output", str(tmp_path / "shared")]) == 2
    error = capsys.readouterr().err
    assert "a card describes no such environment or network" in error and error.count("\n") == 1
    assert not (tmp_path / "shared").exists()


@pytest.mark.parametrize(
    ("objective", "told"),
    [
        ("math:pi", "arguments.objective 'math:pi' is a float; allowed: a function of worlds"),
        ("MODULE:summed", r"gives tensor\(.*allowed: a tensor \(4,\)"),
        ("MODULE:broken", "ZeroDivisionError"),
        ("MODULE:nothing", "has no 'nothing'"),
    ],
)
def test_unusable_objectives_get_one_line(
    module: str, tmp_path: Path, capsys: pytest.CaptureFixture[str], objective: str, told: str
) -> None:
    text = CONFIG.replace("MODULE:doubled", objective).replace("MODULE", module)
    (tmp_path / "own.yaml").write_text(text)
    assert main(["train", "own.yaml", "--output", str(tmp_path / "run")]) == 2
    error = capsys.readouterr().err
    assert re.search(told, error) and error.count("\n") == 1
