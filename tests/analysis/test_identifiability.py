"""What a record tells: information from the data, least-known directions, collinearity; by made-up matrices."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import jawenv
from agents import load_agent
from jawenv.analysis.bound import bound_along
from jawenv.analysis.identifiability import (
    Identifiability,
    collinearity,
    data_information,
    identifiability,
)
from jawenv.anatomy import PARAMETER_NAMES, Prior
from jawenv.base.errors import InputError


@cache
def record_of(maneuver, env_id="jawenv/Jaw-v3"):
    agent = load_agent(maneuver, env_id=env_id, control="force")
    settings = {"record": True, "episode_s": 6.0}
    return jawenv.play(agent, patients=1, seed=5_000, env_kwargs=settings, env_id=env_id).records[0]


@cache
def report(maneuver, env_id="jawenv/Jaw-v3"):
    return identifiability(record_of(maneuver, env_id))


def made_up(covariance, prior_sd=0.5):
    """A report with this covariance of the 12 parameters."""
    sd = np.full(12, prior_sd)
    return Identifiability(PARAMETER_NAMES, 1.0, covariance, sd, data_information(covariance, sd))


def test_information_of_the_data_is_what_was_put_in(rng):
    sensitivities, sd = rng.normal(size=(40, 12)) * np.logspace(0, 2, 12), rng.uniform(0.2, 0.6, 12)
    information = sensitivities.T @ sensitivities
    found = data_information(np.linalg.inv(information + np.diag(1.0 / sd**2)), sd)
    np.testing.assert_allclose(found, information, rtol=1e-8, atol=1e-8 * information.max())
    np.testing.assert_array_equal(found, found.T)


def test_information_of_the_data_does_not_depend_on_the_prior():
    """The prior of the parameters; with a known gain the problem is linear, and the prior adds to the data."""
    record = replace(record_of("opening_with_swings_and_fore_aft"), gain_sd=0.0)
    found = []
    for factor in (0.2, 1.0, 5.0):
        prior = Prior(mean=record.prior.mean, sd=factor * record.prior.sd)
        bound = bound_along(replace(record, prior=prior), every=600)
        found.append(data_information(bound.cov[-1], bound.prior_sd))
    for other in (found[0], found[2]):
        scale = np.sqrt(np.diag(found[1]))
        assert np.abs((other - found[1]) / np.outer(scale, scale)).max() < 1e-6


def test_the_least_known_combinations_are_those_that_were_left_unknown():
    left, right = PARAMETER_NAMES.index("log_F_o/temporalis_left"), PARAMETER_NAMES.index("log_F_o/temporalis_right")
    against = np.zeros(12)
    against[[left, right]] = 1.0, -1.0
    strength = np.eye(12)[PARAMETER_NAMES.index("log_b/masseter_right")]
    covariance = (
        0.01**2 * np.eye(12) + 0.5 * 0.3**2 * np.outer(against, against) + 0.1**2 * np.outer(strength, strength)
    )
    first, second = made_up(covariance).least_known(2)
    assert (first.words, second.words) == ("F_o: temporalis, left against right", "b: masseter, right")
    assert first.sd == pytest.approx(np.hypot(0.3, 0.01)) and second.sd == pytest.approx(np.hypot(0.1, 0.01))
    assert first.prior_sd == pytest.approx(0.5) and np.linalg.norm(first.direction) == pytest.approx(1.0)
    with pytest.raises(InputError):
        made_up(covariance).least_known(13)


def test_collinearity_is_brun_s_index_of_the_sensitivities(rng):
    """1 over the shortest vector that a combination of length 1 of normalised sensitivities can make."""
    sensitivities = rng.normal(size=(30, 5)) @ rng.normal(size=(5, 5))
    information, subset = sensitivities.T @ sensitivities, [4, 1, 2]
    unit = sensitivities[:, subset] / np.linalg.norm(sensitivities[:, subset], axis=0)
    assert collinearity(information, [subset])[0] == pytest.approx(
        1.0 / np.linalg.svd(unit, compute_uv=False)[-1], rel=1e-8
    )


def test_what_the_data_do_not_see_is_infinitely_collinear():
    assert collinearity(np.diag([1.0, 0.0]), [[0, 1]]) == np.inf
    assert collinearity(np.ones((2, 2)), [[0, 1]]) == np.inf
    assert collinearity(np.diag([1.0, 0.0]), [[0]]) == 1.0


def test_what_slow_opening_leaves_is_the_medial_pterygoid_and_the_fore_aft_force_helps():
    """Its strength against its exponent, on both sides; the masseter's line is near its own."""
    slow = report("slow_opening").least_known()[0]
    assert slow.words == "F_o against b: medial pterygoid, both sides"
    assert report("opening_with_swings_and_fore_aft").least_known()[0].sd < 0.78 * slow.sd


@pytest.mark.parametrize("env_id", ["jawenv/Jaw-v3", "jawenv/JawHinge-v3"])
def test_it_can_be_told_in_words(env_id):
    found = report("opening_with_swings_and_fore_aft", env_id)
    text = found.describe()
    bound = bound_along(record_of("opening_with_swings_and_fore_aft", env_id))
    assert f"6 s, {len(found.sd)} parameters: {bound.information[-1]:.1f} nats at most" in text
    assert f"  {found.least_known()[0].words}: sd " in text
