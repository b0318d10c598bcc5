"""The search for settings."""

from pathlib import Path

import optuna
import pytest
from optuna.trial import FixedTrial, TrialState

from training.cli import main
from training.run.config import TrainingConfig, config_file
from training.run.tune import suggest

PPO = {"learning_rate": 1e-3, "gamma": 0.98, "n_epochs": 4, "initial_log_std": -1.5, "scale": 0.3}
SAC = {"learning_rate": 1e-3, "gamma": 0.98, "gradient_steps": 5, "units": 64, "scale": 0.3}


@pytest.mark.parametrize(("name", "values"), [("ppo", PPO), ("recurrent_ppo", PPO), ("sac", SAC), ("tqc", SAC)])
def test_what_is_suggested_reaches_the_configuration(name: str, values: dict[str, float]) -> None:
    config = TrainingConfig.load(config_file(name))
    trial = suggest(FixedTrial(values, number=3), config)
    arguments: dict = trial.arguments
    assert arguments["gamma"] == 0.98 and arguments["learning_rate"]["initial"] == 1e-3 and trial.seed == 3
    assert arguments.keys() == config.arguments.keys()
    assert trial.residual is not None and trial.residual.scale == 0.3
    assert trial.env == config.env and trial.evaluation == config.evaluation
    if name in ("sac", "tqc"):
        assert arguments["gradient_steps"] == 5 and trial.network.policy == trial.network.value == (64, 64)


def test_study_goes_on_to_the_trials_wanted(
    tiny_config: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    storage = f"sqlite:///{tmp_path}/tune.db"
    command = ["tune", str(tiny_config), "--steps", "256", "--storage", storage, "--output", str(tmp_path / "t")]
    assert main([*command, "--trials", "1"]) == 0
    assert main([*command, "--trials", "2"]) == 0
    assert "best of 2 trials" in capsys.readouterr().out
    trials = optuna.load_study(study_name="tiny", storage=storage).trials
    assert [trial.state for trial in trials] == [TrialState.COMPLETE] * 2
    assert trials[0].params != trials[1].params and trials[0].value == pytest.approx(
        trials[0].intermediate_values[256], rel=1e-4
    )
    assert sorted(path.name for path in (tmp_path / "t").iterdir()) == ["trial-0000", "trial-0001"]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--trials", "0"], "trials is 0; allowed: 1 or more"),
        (["--storage", "postgresql://me:secret@localhost:1/x"], "storage postgresql://localhost:1/x: cannot be used"),
        (["--storage", "nonsense"], "storage nonsense: cannot be used"),
    ],
)
def test_unusable_arguments_get_one_line(
    tiny_config: Path, capsys: pytest.CaptureFixture[str], arguments: list[str], message: str
) -> None:
    assert main(["tune", str(tiny_config), *arguments]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1 and message in error and "secret" not in error
