"""Several recordings of one patient: the algebra, one belief of two mountings, and whether they agree."""

import json
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import jawenv
from agents import load_agent
from jawenv.anatomy import Prior
from jawenv.base.errors import InputError
from jawenv.commands.app import main
from jawenv.recordings.files import save_record
from jawenv.recordings.several.together import _Several, agreement, together
from jawenv.recordings.untold.blocks import blocks_of

SECONDS = 6.0


@cache
def played(patient, maneuver="opening_with_swings_and_fore_aft"):
    drawn = jawenv.cohort("trismus").draw(np.random.default_rng(660_000 + patient))
    known = drawn.model_copy(update={"anatomy_seed": patient})
    world = {"record": True, "episode_s": SECONDS, "knowledge": "bench", "track_bound": False}
    return jawenv.play(load_agent(maneuver), patients=[known], seed=661_000 + patient, env_kwargs=world).records[0]


def both():
    return [played(0), played(0, "refined")]


def test_blocks_beside_each_other_share_muscles_and_anatomy_alone():
    parts = [blocks_of(record, record.truth) for record in both()]
    whole = _Several.of(parts)
    session = (~parts[0].own).sum()
    assert whole.score.shape[1] == parts[0].score.shape[1] + session and len(whole.score) == 24
    total = sum(part.information.sum(axis=0)[:30, :30] for part in parts)
    np.testing.assert_allclose(whole.information.sum(axis=0)[:30, :30], total)
    for part, place in zip(whole.parts, whole.places, strict=True):
        np.testing.assert_array_equal(whole.sds(np.ones((2, 6)))[:, place[30:] - 30], part.sds(np.ones((2, 6))))
    first, second = (set(place) for place in whole.places)
    assert len(first & second) == 30 + parts[0].own.sum()


def test_two_recordings_tell_more_than_each_and_are_right():
    records = both()
    mean, cov = together(records, records[0].truth)
    alone = [np.sqrt(np.diagonal(together([one, one.until(0.5)], one.truth)[1])) for one in records]
    assert np.all(np.sqrt(np.diagonal(cov)) < 1.02 * np.minimum(*alone))
    error = mean - records[0].truth
    assert error @ np.linalg.solve(cov, error) < 40.0


def test_beliefs_of_one_patient_agree_as_often_as_they_should_and_of_two_they_do_not(rng):
    size, prior = 4, Prior(np.zeros(4), np.full(4, 0.5))
    p0, designs = np.diag(prior.sd**2), rng.normal(size=(2, 6, 4))
    designs[:, :, 3] = 0.0  # of which nothing is told
    covs = np.array([np.linalg.inv(np.linalg.inv(p0) + 9.0 * one.T @ one) for one in designs])
    squares, ps = [], []
    for _ in range(400):
        theta = 0.5 * rng.standard_normal(size)
        data = [one @ theta + rng.standard_normal(6) / 3.0 for one in designs]
        means = np.array([cov @ (9.0 * one.T @ read) for cov, one, read in zip(covs, designs, data, strict=True)])
        found = agreement(prior, means, covs)
        squares.append(found.squares)
        ps.append(found.p)
    assert found.degrees == 3 and np.mean(squares) == pytest.approx(3.0, abs=0.5)
    assert np.mean(np.array(ps) < 0.1) == pytest.approx(0.1, abs=0.05)
    means[1] += [0.0, 3.0, 0.0, 0.0]
    assert not agreement(prior, means, covs).one_patient and agreement(prior, means, covs).parameter == 1


def test_recordings_that_were_read_otherwise_are_refused():
    records = both()
    with pytest.raises(InputError, match="differ in their knowledge") as error:
        together([records[0], replace(records[1], knowledge=jawenv.Knowledge())], records[0].truth)
    assert "\n" not in str(error.value)
    with pytest.raises(InputError, match="differ in their prior"):
        together([records[0], replace(records[1], prior=jawenv.cohort("severe").prior)], records[0].truth)
    with pytest.raises(InputError, match="9 recordings; allowed: 2 to 8"):
        together(9 * records[:1], records[0].truth)


def saved(record, path):
    save_record(replace(record, truth=None, states=None, wrenches=None), path)
    return str(path)


def test_the_command_answers_with_one_belief(tmp_path, capsys):
    paths = [saved(record, tmp_path / f"{i}.csv") for i, record in enumerate(both())]
    answer = tmp_path / "both.json"
    assert main(["identify", *paths, "--json", str(answer)]) == 0
    said = capsys.readouterr().out
    assert "agree:   yes, all can be of one patient (chi-squared" in said and said.count("F_o/") == 6
    found = json.loads(answer.read_text(encoding="utf-8"))
    assert found["believed"] and found["agreement"]["one_patient"] and found["seconds"] == 2 * SECONDS
    assert [each["path"] for each in found["recordings"]] == paths
    alone = [np.diagonal(each["log_cov"]) for each in found["recordings"]]
    assert np.diagonal(found["log_cov"]).sum() < min(one.sum() for one in alone)


def test_the_same_readings_twice_are_refused(tmp_path, capsys):
    paths = [saved(played(0), tmp_path / f"{i}.csv") for i in range(2)]
    assert main(["identify", *paths]) == 2
    assert capsys.readouterr().err.endswith("0.csv; allowed: each recording once\n")


def test_too_many_recordings_are_refused_before_one_is_read(tmp_path, capsys):
    missing = [str(tmp_path / f"{i}.csv") for i in range(9)]
    assert main(["identify", *missing]) == 2
    assert capsys.readouterr().err == "error: 9 recordings; allowed: 1 to 8\n"


def test_two_patients_are_named_in_one_sentence(tmp_path, capsys):
    paths = [saved(played(i), tmp_path / f"{i}.csv") for i in range(2)]
    assert main(["identify", *paths]) == 3
    said = capsys.readouterr().out
    assert "0.csv and " in said and said.count("are not of one patient in one state: ") == 1 and "F_o left" not in said
    assert main(["identify", *paths, "--before", paths[0]]) == 2
    assert "before is given with recordings of six coordinates" in capsys.readouterr().err
