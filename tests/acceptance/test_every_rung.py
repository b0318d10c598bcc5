"""The two commands on the smallest and on the largest environment: train an agent, compare it with a maneuver."""

from pathlib import Path

import pandas as pd
import pytest

from eval.commands.app import main as evaluate
from eval.comparison import results
from jawenv.ladder import model_of_env
from training.cli import main as train

CONFIG = """
n_envs: 2
env: {kwargs: {episode_s: 0.5}}
arguments: {n_steps: 16, batch_size: 32, n_epochs: 1}
network: {policy: [8], value: [8]}
evaluation: {every_steps: 1000, patients: 2}
"""


@pytest.mark.parametrize("env", ["JawHinge", "portions"])
def test_an_agent_is_trained_and_compared(env: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    model = model_of_env(env)
    monkeypatch.chdir(tmp_path)
    Path("tiny.yaml").write_text(CONFIG)
    assert train(["train", "tiny.yaml", "--env", env, "--steps", "64"]) == 0
    run = f"runs/tiny-{model.title}-seed0"
    study = ["compare", run, "opening_with_swings", "--patients", "2", "--episode-s", "0.5", "--output", "runs/study"]
    assert evaluate(study) == 0  # in the environment that the agent was trained in
    names = [f"sd/{name}" for name in model.muscles.parameter_names]
    table = pd.read_parquet("runs/study/patients.parquet")
    assert [column for column in table if column.startswith("sd/")] == names
    assert set(table["entry"]) == {Path(run).name, "opening_with_swings"}
    about = results.load(Path("runs/study")).about
    assert about["settings"]["env"] == model.env_id
    page = Path("runs/study/report.html").read_text()
    assert f"{len(names)} parameters" in page and model.env_id in page
    assert evaluate([*study, "--env", "JawSides"]) == 2  # a trained agent takes part in its own only
