"""The search by the twin's gradient: what it finds, the file that it writes, and what a stop leaves."""

import gymnasium as gym
import pytest
import torch

from agents.twin.constants import Patients, Twin
from agents.twin.search import cost_of
from agents.twin.worlds import Worlds
from jawenv.base.locks import alone
from jawenv.playing.maneuvers import Maneuver
from training.cli import main
from training.search import gradient

OPTIONS = ["--refine", "opening_with_swings", "--horizon-s", "2", "--patients", "2", "--updates", "2"]
COMMAND = ["refine", *OPTIONS, "--output"]


def test_what_is_found_is_better_than_the_beginning():
    found = gradient.search("refined", "trismus", 6, 8, 2.0)
    env = gym.make_vec("jawenv/Jaw-v3", 8, cohort="trismus", episode_s=2.0, autoreset_mode="disabled")
    env.reset(seed=6000)
    twin, patients = Twin(env.unwrapped.simulation), Patients.of_worlds(env.unwrapped.simulation.worlds)
    beginning = Maneuver.named("refined").targets(0.2 * torch.arange(1.0, 11.0).numpy()).value
    with torch.no_grad():
        worst = [
            cost_of(Worlds(twin, patients), torch.tensor(each).expand(8, -1, -1), 0.0).mean()
            for each in (found, beginning)
        ]
    assert worst[0] < worst[1] - 0.01


def test_the_command_writes_a_file_that_plays(tmp_path, capsys):
    output = tmp_path / "finer.yaml"
    assert main([*COMMAND, str(output)]) == 0
    text, maneuver = output.read_text(), Maneuver.load(output)
    assert maneuver.name == "finer" and maneuver.description.startswith("'opening_with_swings'")
    assert "--refine opening_with_swings" in text and "--horizon-s 2" in text
    assert main([*COMMAND, str(output)]) == 2 and "--overwrite" in capsys.readouterr().err
    assert main([*COMMAND, str(output), "--overwrite"]) == 0


def test_one_search_writes_a_file_at_a_time(tmp_path, capsys):
    output = tmp_path / "mine.yaml"
    with alone(output):
        assert main([*COMMAND, str(output)]) == 2
    assert "in use by another process" in capsys.readouterr().err


@pytest.mark.parametrize("name", ["no/x.yaml", "My File.yaml", "x.toml"])
def test_what_cannot_be_written_is_refused_first(tmp_path, capsys, name):
    assert main([*COMMAND, str(tmp_path / name)]) == 2
    assert "--output" in capsys.readouterr().err


def test_a_search_that_was_stopped_leaves_nothing(tmp_path, capsys, monkeypatch):
    def interrupted(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr(gradient, "searched", interrupted)
    assert main([*COMMAND, str(tmp_path / "mine.yaml")]) == 130
    assert "begins anew" in capsys.readouterr().err and not list(tmp_path.iterdir())
