"""Maneuvers designed second by second: one plan for all patients, written as a file that plays it."""

import numpy as np
import pytest

import jawenv
from jawenv.device.channels import HIGHEST, LOWEST
from jawenv.errors import InputError
from jawenv.maneuvers import Maneuver, Player
from training.cli import main
from training.sequential import SequentialDesign, _Reporting, design_maneuver

QUICK = SequentialDesign(horizon_s=2.0, patients=3, look_ahead_s=1.0, candidates=8, rounds=2)
ABOUT = {"name": "designed", "title": "Designed", "description": "For a test.", "source": "this test"}


def played(agent):
    return jawenv.play(agent, patients=QUICK.patients, seed=5000, env_kwargs=QUICK.env_kwargs)


def test_all_patients_are_moved_alike():
    steps = []
    agent = _Reporting(QUICK.plan("designed"), 0, steps.append)
    played(agent)
    actions = np.array(agent.actions)
    assert actions.shape == (10, 3, 4) and steps == list(range(1, 11))
    np.testing.assert_array_equal(actions, np.broadcast_to(actions[:, :1], actions.shape))
    assert np.ptp(actions, axis=0).max() > 0.1


def test_the_file_moves_the_jaw_as_the_design_did():
    agent = _Reporting(QUICK.plan("designed"), QUICK.seed, lambda _: None)
    designed = played(agent)
    maneuver = design_maneuver(QUICK, ABOUT, lambda _: None)
    np.testing.assert_allclose(played(Player(maneuver, control="targets")).belief_sd, designed.belief_sd, rtol=2e-3)
    targets = maneuver.targets(np.linspace(0.0, 2.0, 50)).value
    assert (targets >= np.array(LOWEST) - 1e-9).all() and (targets <= HIGHEST + 1e-9).all()


def test_the_seed_of_the_search_is_not_that_of_the_patients():
    first, second = (design_maneuver(SequentialDesign(**{**QUICK.about(), "seed": k}), ABOUT, id) for k in (0, 1))
    assert first.channels != second.channels


def test_the_tail_is_of_those_who_are_known_least():
    agent = _Reporting(SequentialDesign(**{**QUICK.about(), "over": "tail"}).plan("tail"), 0, lambda _: None)
    played(agent)
    potential = -np.log(agent._env.simulation.worlds["belief"]["cov"].diagonal(axis1=1, axis2=2).max(axis=1))
    assert agent._least_known(np.ones(3, dtype=bool)).tolist() == [int(np.argmin(potential))]
    assert agent._least_known(np.arange(3) != np.argmin(potential)).tolist() != [int(np.argmin(potential))]


def test_the_command_writes_a_file_that_names_itself(tmp_path, capsys):
    path = tmp_path / "quick.yaml"
    options = ["--horizon-s", "1", "--patients", "1", "--candidates", "8", "--rounds", "1", "--look-ahead-s", "0.4"]
    assert main(["design", "--output", str(path), *options]) == 0
    text = path.read_text()
    assert "# python -m training design --output quick.yaml --horizon-s 1.0 --patients 1 --look-ahead-s 0.4" in text
    assert Maneuver.load(path).name == "quick"
    assert "quick.yaml: " in capsys.readouterr().err


@pytest.mark.parametrize(
    ("field", "value", "message"),
    [
        ("goal", "most", "^goal is 'most'; allowed: mixed, worst, uncertainty$"),
        ("over", "nominal", "^over is 'nominal'; allowed: mean, tail$"),
        ("patients", 0, "^patients is 0; allowed: 1 or more$"),
        ("candidates", 3, "^candidates is 3; allowed: 6 or more$"),
        ("look_ahead_s", float("nan"), "^look_ahead_s is nan; allowed: 0.2 to 30$"),
        ("comfort_weight", float("nan"), "^comfort_weight is nan; allowed: 0 or more, finite$"),
        ("comfort_weight", float("inf"), "^comfort_weight is inf; allowed: 0 or more, finite$"),
        ("cohort", "nobody", "nobody"),
    ],
)
def test_what_is_not_allowed_is_named(field, value, message):
    with pytest.raises(InputError, match=message):
        SequentialDesign(**{field: value})


def test_a_folder_that_may_not_be_written_is_named_at_once(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr("os.access", lambda *_: False)
    assert main(["design", "--output", str(tmp_path / "mine.yaml")]) == 2
    assert f"{tmp_path} may not be written" in capsys.readouterr().err
