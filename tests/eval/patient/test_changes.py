"""The change between two treatments where the anatomy is not known exactly: against algebra, and on patients."""

import gymnasium as gym
import numpy as np
import pytest

import jawenv
from eval.kept.entries import Settings, load_entries
from eval.patient.belief import KnownPatient, at_start
from eval.patient.changes import change, change_in_words
from eval.patient.treatments import first_treatment, next_treatment, population_of
from jawenv.analysis.joint_likelihood import JointLikelihood
from jawenv.anatomy import Prior

PAIRS, FIRST_SEED, DRIFT = 24, 990_000, 0.1  # seeds of no other use


def entry_of(episode_s):
    settings = Settings.of(1, FIRST_SEED, episode_s=episode_s, knowledge="imaged")
    return load_entries(["refined"], settings.world)[0]


def normal_data(rng, x, count):
    """The likelihood of ``count`` linear measurements of x with unit noise."""
    design = rng.normal(size=(count, len(x)))
    return JointLikelihood(design.T @ design, design.T @ (design @ x + rng.normal(size=count)))


def test_the_change_is_that_of_the_whole_normal_posterior(rng):
    """Two sets of data about (two muscles' numbers, three of the anatomy), against one regression for all seven."""
    prior, anatomy = Prior(np.array([0.3, -0.2]), np.array([0.5, 0.8])), rng.normal(size=3)
    then, now = rng.normal(size=2), rng.normal(size=2)
    first, later = (normal_data(rng, np.concatenate([muscles, anatomy]), 6) for muscles in (then, now))
    precision, right = np.diag(np.concatenate([1.0 / prior.sd**2, 1.0 / prior.sd**2, np.ones(3)])), np.zeros(7)
    right[:4] = np.tile(prior.mean / prior.sd**2, 2)
    for muscles, each in (([0, 1], first), ([2, 3], later)):
        places = [*muscles, 4, 5, 6]
        precision[np.ix_(places, places)] += each.information
        right[places] += each.vector
    whole, cov = np.linalg.solve(precision, right), np.linalg.inv(precision)
    by = np.array([[-1, 0, 1, 0, 0, 0, 0], [0, -1, 0, 1, 0, 0, 0]], dtype=float)
    mean, changed = change(first, later, prior)
    np.testing.assert_allclose(mean, by @ whole, rtol=1e-8)
    np.testing.assert_allclose(changed, by @ cov @ by.T, rtol=1e-8)


@pytest.fixture(scope="module")
def pairs():
    """First and second treatment of each patient, 8 s each."""
    entry = entry_of(8.0)
    played = []
    for seed in range(FIRST_SEED, FIRST_SEED + PAIRS):
        first = first_treatment(entry, seed)
        played.append((first, next_treatment(entry, first, 2, DRIFT, seed)))
    return population_of(entry).prior, played


def test_intervals_of_the_change_cover_it_and_are_narrower_than_of_two_independent_treatments(pairs):
    prior, played = pairs
    covered, narrower = [], []
    for first, second in played:
        mean, cov = change(first.likelihood, second.likelihood, prior)
        sd = np.sqrt(np.diagonal(cov))
        covered.append(np.abs(mean - (second.truth - first.truth)) < 1.96 * sd)
        start = at_start(prior, len(first.vector))
        alone = [np.diagonal(each.likelihood.posterior(*start)[1])[:12] for each in (first, second)]
        narrower.append(sd / np.sqrt(np.sum(alone, axis=0)))
    assert 0.88 < np.mean(covered)
    assert np.max(narrower) < 1.0 and np.median(narrower) < 0.9


def test_what_is_known_after_the_second_is_honest_and_surer(pairs):
    _, played = pairs
    sds = np.array([[np.sqrt(np.diagonal(each.cov[-1])) for each in pair] for pair in played])
    assert np.median(sds[:, 1] / sds[:, 0]) < 0.95
    nees = np.array([[each.nees for each in pair] for pair in played]).mean(axis=0) / 12
    assert (nees > 0.65).all() and (nees < 1.4).all(), nees


@pytest.mark.parametrize(
    ("factor", "text"),
    [((0.8, 0.73, 0.88), "softer by 20 % (12 … 27)"), ((1.02, 0.99, 1.05), "stiffer by 2 % (−1 … 5)")],
)
def test_a_change_is_written_for_people(factor, text):
    assert change_in_words(*factor) == text


def test_what_is_believed_does_not_change_how_many_numbers_are_integrated_out():
    """Otherwise each patient's second treatment has a filter of its own size, and is compiled for it."""
    population = jawenv.anatomy.cohort("trismus")
    believed = Prior(population.prior.mean + 0.5, 0.1 * population.prior.sd)
    known = KnownPatient.of(population, believed)
    np.testing.assert_array_equal(known.typical, population.prior.mean)
    np.testing.assert_array_equal(known.prior.mean, believed.mean)
    sizes = []
    for each in (population, known):
        env = gym.make("jawenv/Jaw-v3", cohort=each, knowledge="imaged")
        sizes.append(len(env.unwrapped.simulation.nuisance_sds))
    assert sizes[0] == sizes[1]
