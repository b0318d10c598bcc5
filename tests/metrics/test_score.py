from dataclasses import replace

import numpy as np
import pytest

from jawenv.base.errors import InputError
from jawenv.metrics import BLOCKED_B, STIFF_F_O_N, nees_band, score
from jawenv.metrics.score import Summary
from tests.metrics.linear_gaussian import linear_gaussian


@pytest.fixture(scope="module")
def exact():
    return score(linear_gaussian(patients=400))


def test_an_exact_posterior_is_calibrated(exact):
    low, high = nees_band(400, 12)
    summary = exact.summary()
    assert low < summary["nees"] < high
    assert low < summary["nees_prior"] < high
    for sigmas, share in ((1, 0.6827), (2, 0.9545), (3, 0.9973)):
        assert summary[f"inside_{sigmas}_sigma"] == pytest.approx(share, abs=0.02)
    assert summary["honesty_gap"] == pytest.approx(0.0, abs=0.5)


def test_an_exact_posterior_reaches_the_bound(exact):
    assert exact.summary()["rmse_over_bound_mean"] == pytest.approx(1.0, abs=0.05)
    np.testing.assert_allclose(exact.worst_sd, exact.worst_bound_sd)
    np.testing.assert_allclose(exact.information_claimed, exact.information_bound)


def test_overconfidence_shows(exact):
    boastful = score(linear_gaussian(patients=400, shrink=0.25))
    np.testing.assert_allclose(boastful.nees, 4.0 * exact.nees)
    np.testing.assert_allclose(boastful.worst_sd, 0.5 * exact.worst_sd)
    assert boastful.honesty_gap.mean() == pytest.approx(18.0, abs=1.5)  # (48 - 12) / 2
    assert boastful.information_true.mean() < exact.information_true.mean()
    assert boastful.identified.mean() / 12 < (boastful.sd <= 0.1).mean()


def test_comfort_by_hand():
    recording = linear_gaussian(patients=2, steps=4)
    cost, comfort, violation = recording.cost.copy(), recording.comfort.copy(), recording.violation.copy()
    cost[0] = [9.0, 1.0, 0.0, 2.0, 0.0]  # the cost at the reset is not part of a step
    comfort[1, 2, 3] = 1.4
    violation[1, 2] = True
    judged = score(replace(recording, cost=cost, comfort=comfort, violation=violation))
    assert judged.discomfort_s.tolist() == [1.5, 0.0]
    assert judged.largest_fraction.tolist() == [0.5, 1.4]
    assert judged.violated.tolist() == [False, True]
    np.testing.assert_allclose(judged.governor, 0.25)


def test_the_alarm_is_that_of_the_last_valid_time_and_is_put_into_words():
    recording = linear_gaussian(patients=4, steps=4)
    assert score(recording).alarm == "" and score(recording).summary()["ringing_share"] == 0.0
    misfit, valid = recording.misfit.copy(), recording.valid.copy()
    misfit[0, 2:], misfit[1, 4], misfit[2] = 1.5, 7.0, np.nan
    valid[1, 4:] = False
    judged = score(replace(recording, misfit=misfit, valid=valid))
    assert judged.rings.tolist() == [True, False, True, False] and judged.misfit[0] == 1.5
    assert judged.alarm == "the readings of 50 % of the patients do not fit the model"
    assert judged.summary()["ringing_share"] == 0.5


def test_an_episode_that_ended_early_is_judged_where_it_ended():
    recording = linear_gaussian(patients=2, steps=10)
    valid = recording.valid.copy()
    valid[0, 4:] = False
    judged = score(replace(recording, valid=valid, cost=np.ones_like(recording.cost)))
    np.testing.assert_allclose(judged.sd[0], recording.belief_sd[0, 3])
    assert judged.duration_s.tolist() == [1.5, 5.0]
    assert judged.discomfort_s.tolist() == [1.5, 5.0]
    np.testing.assert_allclose(judged.governor, 0.25)


def test_median_time_counts_those_who_never_arrive():
    easy, hard = linear_gaussian(patients=3, noise=0.05), linear_gaussian(patients=3, noise=50.0)
    assert np.isfinite(score(easy).summary()["time_to_0.1_median_s"])
    assert score(hard).summary()["time_to_0.1_median_s"] == np.inf
    assert score(hard).summary()["share_to_0.1"] == 0.0


def test_diagnosis_uses_its_own_parameters(exact):
    recording = linear_gaussian(patients=400)
    np.testing.assert_array_equal(exact.stiff.raised, recording.truth[:, ::2] > np.log(STIFF_F_O_N))
    np.testing.assert_array_equal(exact.blocked.raised, recording.truth[:, 1::2] > np.log(BLOCKED_B))
    assert exact.stiff.wrong < 0.05


@pytest.mark.parametrize(
    "change",
    [
        lambda r: {"cost": r.cost[:, :-1]},
        lambda r: {"truth": np.full_like(r.truth, np.nan)},
        lambda r: {"valid": ~r.valid},
        lambda r: {"time": r.time[::-1].copy()},
        lambda r: {"truth": r.truth[0]},
    ],
)
def test_a_malformed_recording_is_refused(change):
    recording = linear_gaussian(patients=2, steps=4)
    with pytest.raises(InputError):
        replace(recording, **change(recording))


def test_a_summary_is_a_table():
    summary = Summary(
        {"patients": 3.0, "worst_sd_median": 0.0251, "nees": float("nan"), "time_to_0.05_median_s": np.inf}
    )
    lines = [line.split("  ") for line in str(summary).splitlines()]
    assert [(line[0], line[-1].strip()) for line in lines] == [
        ("patients", "3"),
        ("worst sd, median", "2.5%"),
        ("all within 5 % after, s, median", "never"),
        ("NEES", "–"),
    ]
    assert summary._repr_html_().count("<tr>") == 4 and summary["nees"] is not None
