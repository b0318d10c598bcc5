"""Maneuvers designed second by second: one plan for all patients, written as a file that plays it."""

import numpy as np
import pytest

import jawenv
from jawenv.device.channels import HIGHEST, LOWEST
from jawenv.errors import InputError
from jawenv.playing.maneuvers import Maneuver, Player
from tests.recorded import Actions
from training.cli import main
from training.search.sequential import SequentialDesign, _Designer, design_maneuver, read_plans, write_plans

QUICK = SequentialDesign(horizon_s=2.0, patients=3, look_ahead_s=1.0, candidates=8, rounds=2)
ABOUT = {"name": "designed", "title": "Designed", "description": "For a test.", "source": "this test"}


def played(agent, on_step=None):
    return jawenv.play(agent, patients=QUICK.patients, seed=5000, env_kwargs=QUICK.env_kwargs, on_step=on_step)


def test_all_patients_are_moved_alike(tmp_path):
    watched = Actions()
    played(_Designer(QUICK, "designed", tmp_path / "log.npz"), watched)
    actions = np.array(watched.actions)
    assert actions.shape == (10, 3, 4)
    np.testing.assert_array_equal(actions, np.broadcast_to(actions[:, :1], actions.shape))
    assert np.ptp(actions, axis=0).max() > 0.1


def test_the_file_moves_the_jaw_as_the_design_did(tmp_path):
    designed = played(_Designer(QUICK, "designed", tmp_path / "log.npz"))
    steps = []
    maneuver, made = design_maneuver(QUICK, ABOUT, tmp_path / "log_too.npz", lambda *step: steps.append(step))
    assert made == 2 and steps == [(k, True) for k in range(1, 11)]
    np.testing.assert_allclose(played(Player(maneuver, control="targets")).belief_sd, designed.belief_sd, rtol=2e-3)
    targets = maneuver.targets(np.linspace(0.0, 2.0, 50)).value
    assert (targets >= np.array(LOWEST) - 1e-9).all() and (targets <= HIGHEST + 1e-9).all()


def test_the_seed_of_the_search_is_not_that_of_the_patients(tmp_path):
    designs = [SequentialDesign(**{**QUICK.about(), "seed": k}) for k in (0, 1)]
    first, second = (design_maneuver(d, ABOUT, tmp_path / f"{d.seed}.npz", lambda *_: None)[0] for d in designs)
    assert first.channels != second.channels


def test_the_tail_is_of_those_who_are_known_least(tmp_path):
    agent = _Designer(SequentialDesign(**{**QUICK.about(), "over": "tail"}), "tail", tmp_path / "log.npz")
    played(agent)
    potential = -np.log(agent._env.simulation.worlds["known"]["belief"]["cov"].diagonal(axis1=1, axis2=2).max(axis=1))
    assert agent._least_known(np.ones(3, dtype=bool)).tolist() == [int(np.argmin(potential))]
    assert agent._least_known(np.arange(3) != np.argmin(potential)).tolist() != [int(np.argmin(potential))]


def test_a_stopped_design_plans_the_rest_as_if_it_had_not_been_stopped(tmp_path):
    whole, _ = design_maneuver(QUICK, ABOUT, tmp_path / "whole.npz", lambda *_: None)
    log, steps = tmp_path / "log.npz", []
    plans = read_plans(tmp_path / "whole.npz", QUICK, (5, 4))
    write_plans(log, QUICK, plans[:1])  # stopped before the second plan was there
    resumed, made = design_maneuver(QUICK, ABOUT, log, lambda *step: steps.append(step))
    assert made == 1 and steps == [(k, k > 5) for k in range(1, 11)]
    assert resumed == whole
    again, made = design_maneuver(QUICK, ABOUT, log, lambda *_: None)
    assert made == 0 and again == whole
    np.testing.assert_array_equal(read_plans(log, QUICK, (5, 4)), plans)
    with pytest.raises(InputError):
        read_plans(log, SequentialDesign(**{**QUICK.about(), "seed": 1}), (5, 4))
    with pytest.raises(InputError):
        read_plans(log, QUICK, (6, 4))


@pytest.mark.parametrize(
    ("command", "options"),
    [
        ("design", ["--horizon-s", "1", "--patients", "1", "--candidates", "8", "--rounds", "1"]),
        (
            "optimise",
            ["--refine", "chirp", "--horizon-s", "1", "--patients", "1", "--population", "4", "--generations", "1"],
        ),
    ],
)
def test_a_file_that_exists_is_replaced_when_that_is_asked_for(tmp_path, capsys, command, options):
    path = tmp_path / "mine.yaml"
    path.write_text("by hand")
    asked = [command, "--output", str(path), "--horizon-s", "1", "--patients", "1", *options]
    assert main(asked) == 2 and path.read_text() == "by hand"
    assert f"--output: {path} exists already; replace it with --overwrite" in capsys.readouterr().err
    assert main([*asked, "--overwrite"]) == 0
    assert Maneuver.load(path).name == "mine"
    path.write_text("by hand")
    capsys.readouterr()
    assert main(asked) == 0 and path.read_text() == "by hand"
    assert f"{path} is there already" in capsys.readouterr().err
    path.unlink()
    assert main(asked) == 0 and Maneuver.load(path).name == "mine"


def test_the_command_writes_a_file_that_names_itself(tmp_path, capsys):
    path = tmp_path / "quick.yaml"
    options = ["--horizon-s", "1", "--patients", "1", "--candidates", "8", "--rounds", "1", "--look-ahead-s", "0.4"]
    assert main(["design", "--output", str(path), *options]) == 0
    text = path.read_text()
    assert "# python -m training design --output quick.yaml --horizon-s 1.0 --patients 1 --look-ahead-s 0.4" in text
    assert Maneuver.load(path).name == "quick"
    assert "quick.yaml: " in capsys.readouterr().err
