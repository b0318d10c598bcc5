"""Fresh patients: drawn by a key and the submission, and an agent that knows the public ones by heart is found."""

import json

import numpy as np
import pytest

from eval.benchmark import fresh
from eval.commands.app import main
from jawenv.base.files import read_model

KEY = bytes(32)


def test_seeds_depend_on_key_task_and_submission():
    seeds = fresh.seeds_of("jaw-exact", 3, KEY, "a")
    assert seeds == fresh.seeds_of("jaw-exact", 5, KEY, "a")[:3] and all(0 <= seed < 2**32 for seed in seeds)
    others = [("hinge-exact", KEY, "a"), ("jaw-exact", b"x", "a"), ("jaw-exact", KEY, "b")]
    assert all(not set(seeds) & set(fresh.seeds_of(task, 3, key, given)) for task, key, given in others)


def test_a_digest_is_of_names_and_contents(copied):
    first = fresh.digest_of(copied)
    (copied / "checked.json").write_text("{}")
    assert fresh.digest_of(copied) == first
    path = next(path for path in (copied / "agents").rglob("*") if path.is_file())
    path.rename(path.with_name("other.yaml"))
    assert fresh.digest_of(copied) != first


@pytest.mark.parametrize(("gain", "found"), [(0.0, False), (0.35, True)])
def test_who_is_better_on_public_patients_is_found(gain, found):
    random = np.random.default_rng(0)
    public, new = random.normal(-gain, 0.5, 100), random.normal(0.0, 0.5, 50)
    apart, chance = fresh.difference(public, new)
    assert apart.low < apart.value < apart.high and (chance < fresh.LEVEL) == found
    assert fresh.difference(new, public)[1] == pytest.approx(1.0 - chance)


def test_the_maneuver_beside_itself_is_nobody_to_suspect():
    apart, chance = fresh.difference(np.zeros(3), np.zeros(2))
    assert (apart.value, chance) == (0.0, 1.0)


def test_patients_of_equal_times_are_compared_in_silence():
    apart, chance = fresh.difference(np.full(3, 0.35), np.array([0.35, 0.4, 0.45]))
    assert apart.low < 0.05 < apart.high and 0.05 < chance < 0.5


def test_a_check_plays_fresh_patients_and_keeps_the_scores_that_count(copied, capsys):
    command = ["benchmark", "--check", str(copied), "--fresh-seeds", "3", "--key", KEY.hex(), "--workers", "1"]
    assert main(command) == 0
    said = capsys.readouterr().out
    assert f"3 of each task, drawn by --key {KEY.hex()}" in said
    assert said.count("hinge-exact, slow_opening: public ") == 1 and "difference" in said and "; refined " in said
    kept = read_model(copied / fresh.CHECKED, fresh.Checked)
    assert kept.submission == fresh.digest_of(copied) and kept.patients == 3
    assert [(score.task, score.agent) for score in kept.scores] == [
        ("hinge-exact", "slow_opening"),
        ("hinge-exact", "opening_with_circles"),
    ]
    given = [score["score_s"] for score in json.loads((copied / "submission.json").read_text())["scores"]]
    assert [score.public_s for score in kept.scores] == given
    assert [score.fresh_s for score in kept.scores] != given  # a mean of three patients may be that of the public ones
    assert main(command) == 0 and read_model(copied / fresh.CHECKED, fresh.Checked).scores == kept.scores


def test_an_agent_made_for_the_public_patients_ends_with_2_and_keeps_nothing(copied, capsys, monkeypatch):
    monkeypatch.setattr(fresh, "difference", lambda public, new: (fresh.Interval(1.0, 0.5, 1.5), 1e-6))
    (copied / fresh.CHECKED).write_text("{}")
    assert main(["benchmark", "--check", str(copied), "--workers", "1"]) == 0
    assert "which anybody can have written" in capsys.readouterr().out
    assert main(["benchmark", "--check", str(copied), "--fresh-seeds", "2", "--workers", "1"]) == 2
    error = capsys.readouterr().err
    assert "better on public patients than on fresh ones by more than chance: hinge-exact, slow_opening" in error
    assert not (copied / fresh.CHECKED).exists()
