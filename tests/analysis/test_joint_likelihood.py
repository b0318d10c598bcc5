"""What an episode has told of muscles and anatomy together, against the filter that integrates the anatomy out."""

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.vector import AutoresetMode

from jawenv.analysis.joint_likelihood import JointLikelihood, joint_likelihood
from jawenv.base.errors import InputError
from jawenv.playing.maneuvers import Player

WORLDS = 4


@pytest.fixture(scope="module")
def played():
    """Simulation and info after 6 s of ``refined``."""
    envs = gym.make_vec("jawenv/Jaw-v3", WORLDS, knowledge="imaged", autoreset_mode=AutoresetMode.DISABLED)
    observations, info = envs.reset(seed=991_000)
    player = Player("refined", control="targets")
    player.reset(WORLDS, 0)
    for _ in range(30):
        actions, _ = player.predict(observations)
        observations, _, _, _, info = envs.step(actions)
    return envs.unwrapped.simulation, info


def of_prior(simulation, size):
    prior = simulation.cohort.prior
    more = size - len(prior.mean)
    mean = np.concatenate([prior.mean, np.zeros(more)])
    return mean, np.diag(np.concatenate([prior.sd**2, np.ones(more)]))


def test_with_both_priors_it_is_the_filters_belief(played):
    simulation, info = played
    for i in range(WORLDS):
        told = joint_likelihood(simulation, i)
        mean, cov = told.posterior(*of_prior(simulation, len(told.vector)))
        sd = info["belief_sd"][i]
        np.testing.assert_allclose((mean[:12] - info["belief_mean"][i]) / sd, 0.0, atol=0.06)
        np.testing.assert_allclose(np.sqrt(np.diagonal(cov))[:12], sd, rtol=0.03)
        correlations = [
            each / np.sqrt(np.outer(np.diagonal(each), np.diagonal(each)))
            for each in (cov[:12, :12], info["belief_cov"][i])
        ]
        np.testing.assert_allclose(*correlations, atol=0.03)


def test_the_anatomy_is_learned_as_the_filters_nuisances_say(played):
    """Means of the patient's own values are those that the filter believes, in the directions that it has."""
    from jawenv.filter.nuisances.unknowns import own_values

    simulation, _ = played
    own = np.array([own_values(values) for values in simulation.nuisance_sds])
    patients = own.any(axis=1)
    assert 0 < patients.sum() < len(own)
    for i in range(WORLDS):
        told = joint_likelihood(simulation, i)
        mean, cov = told.posterior(*of_prior(simulation, len(told.vector)))
        belief = simulation.worlds["known"]["belief"][i]
        first = belief["nominal"].size + 1  # behind coefficients and gain error
        believed = (belief["nuisances"] + belief["steps"][first : first + len(own)])[patients]
        np.testing.assert_allclose(own[patients] @ mean[12:], believed, atol=0.1)
        assert np.sqrt(np.diagonal(cov)[12:].min()) < 0.6, "something of it is learned"


def test_an_anatomy_that_is_known_exactly_has_no_part_in_it():
    env = gym.make("jawenv/Jaw-v3").unwrapped
    env.reset(seed=1)
    with pytest.raises(InputError):
        joint_likelihood(env.simulation, 0)


def test_a_posterior_is_that_of_a_regression(rng):
    design, data = rng.normal(size=(9, 4)), rng.normal(size=9)
    root = rng.normal(size=(4, 4))
    before, cov = rng.normal(size=4), root @ root.T + np.eye(4)
    mean, after = JointLikelihood(design.T @ design, design.T @ data).posterior(before, cov)
    precision = np.linalg.inv(cov) + design.T @ design
    np.testing.assert_allclose(after, np.linalg.inv(precision), rtol=1e-9)
    np.testing.assert_allclose(mean, np.linalg.solve(precision, np.linalg.solve(cov, before) + design.T @ data))
