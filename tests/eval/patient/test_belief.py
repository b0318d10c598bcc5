"""What one treatment hands to the next, against the joint normal posterior."""

import copy

import gymnasium as gym
import numpy as np
import pytest

import jawenv
from eval.patient.belief import KnownPatient, PatientBelief
from jawenv.anatomy import Prior
from jawenv.recordings.several.together import combined


def normal_update(mean, cov, design, data):
    """Posterior of x after data = design x + unit noise."""
    precision = np.linalg.inv(cov) + design.T @ design
    after = np.linalg.inv(precision)
    return after @ (np.linalg.solve(cov, mean) + design.T @ data), after


@pytest.mark.parametrize("working_sd", [0.2, 1.0, 5.0])
def test_a_normal_likelihood_is_handed_on_exactly_whatever_the_working_prior(rng, working_sd):
    size = 6
    root = rng.normal(size=(size, size))
    before = PatientBelief(rng.normal(size=size), root @ root.T + 0.1 * np.eye(size))
    working = Prior(rng.normal(size=size), np.full(size, working_sd))
    designs = [rng.normal(size=(count, size)) for count in (1, 3, 9)]
    data = [rng.normal(size=len(design)) for design in designs]
    filtered = [normal_update(working.mean, np.diag(working.sd**2), *each) for each in zip(designs, data, strict=True)]
    mean, cov = combined((before.mean, before.cov), working, *(np.array(part) for part in zip(*filtered, strict=True)))
    for i, each in enumerate(zip(designs, data, strict=True)):
        expected = normal_update(before.mean, before.cov, *each)
        np.testing.assert_allclose(mean[i], expected[0], rtol=1e-7, atol=1e-9)
        np.testing.assert_allclose(cov[i], expected[1], rtol=1e-7, atol=1e-9)


def test_a_drift_adds_its_variance_and_no_correlation():
    before = PatientBelief(np.zeros(2), np.array([[0.04, 0.03], [0.03, 0.09]]))
    after = before.widened(0.1)
    np.testing.assert_allclose(after.cov, [[0.05, 0.03], [0.03, 0.10]])
    np.testing.assert_array_equal(after.mean, before.mean)


def test_the_filter_starts_at_the_belief_and_as_unsure_as_for_the_cohort():
    population = jawenv.COHORTS["trismus"].prior
    belief = PatientBelief(population.mean + 0.3, np.diag(np.full(12, 0.05**2)))
    working = belief.working_prior(population)
    np.testing.assert_array_equal(working.mean, belief.mean)
    np.testing.assert_array_equal(working.sd, population.sd)
    np.testing.assert_allclose(belief.widened(2.0).working_prior(population).sd, np.hypot(2.0, 0.05))


def test_an_environment_and_its_copies_take_the_prior():
    population = jawenv.COHORTS["one_sided"]
    known = KnownPatient.of(population, Prior(np.linspace(0.0, 1.0, 12), np.full(12, 0.2)))
    np.testing.assert_array_equal(copy.deepcopy(known).prior.mean, known.believed.mean)
    np.testing.assert_array_equal(known.mean, population.mean)
    env = gym.make_vec("jawenv/Jaw-v3", num_envs=1, cohort=known, episode_s=1.0, control="force")
    _, info = env.reset(seed=5000)
    np.testing.assert_allclose(info["belief_mean"][0], known.believed.mean, atol=0.2)
    assert (info["belief_sd"] <= 0.2 + 1e-9).all()
    env.close()
