"""The bound against what it bounds: the scatter of the most probable parameters over many draws of the noise.

Of one patient, at the prior's mean, the estimate is the truth plus an error whose sampling covariance is, to first
order, B J B. B is the posterior bound and J = B^-1 - B_0^-1 what the record alone tells: the prior B_0 holds the
estimate to its mean, which is here the truth, and so adds no scatter. If that is right, the sample covariance
S of n draws has
Wishart's distribution with n - 1 degrees of freedom and that mean.
"""

import numpy as np
import pytest
from scipy.stats import chi2

import jawenv
from jawenv.anatomy import Patient, cohort
from jawenv.estimation.bound import bound_along
from jawenv.estimation.smoother import IteratedSmoother
from jawenv.ladder import model_named

DRAWS, SECONDS = 500, 1.0
MODEL = model_named("hinge")


class Push:
    """Opens and closes the jaw once, whatever is observed, without pressing the teeth together."""

    def reset(self, num_envs, seed):
        self.time = 0.0

    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        self.time += 0.05
        action = np.zeros((len(observation), 4), dtype=np.float32)
        action[:, 0] = 0.4 * np.sin(np.pi * self.time / SECONDS) ** 2
        return action, state


@pytest.fixture(scope="module")
def drawn():
    """(n, p) errors, and the mean of B J B over the draws, whose motions the noise makes a little different."""
    prior = cohort("trismus", MODEL.muscles).prior
    patient = Patient.from_log_parameters(prior.mean, muscles=MODEL.muscles.names)
    # The gain error is known to be none: what is only considered adds scatter of its own.
    settings = {"record": True, "track_bound": False, "episode_s": SECONDS, "device": {"cell_gain": 0.0}}
    played = jawenv.play(Push(), patients=[patient] * DRAWS, seed=100, env_id=MODEL.env_id, env_kwargs=settings)
    assert not played.terminated.any()
    found = np.array([IteratedSmoother().smooth(record).path.parameters for record in played.records])
    bounds = np.array([bound_along(record, every=10_000).cov[-1] for record in played.records])
    before = np.diag(1.0 / prior.sd**2)
    return found - prior.mean, np.mean([bound - bound @ before @ bound for bound in bounds], axis=0)


def whitened(drawn):
    """(p, p) sample covariance in units of that expected, with 1 expected on its diagonal and 0 elsewhere."""
    error, expected = drawn
    factor = np.linalg.cholesky(expected)
    sample = np.cov(error.T)
    return np.linalg.solve(factor, np.linalg.solve(factor, sample).T)


def test_the_scatter_has_the_size_of_the_bound(drawn):
    """Trace: (n - 1) tr(S / expected) is chi-squared with (n - 1) p degrees of freedom; 99.9 % of it."""
    freedom = (DRAWS - 1) * len(drawn[1])
    low, high = chi2.ppf([0.0005, 0.9995], freedom) / freedom
    assert low < np.trace(whitened(drawn)) / len(drawn[1]) < high


def test_the_scatter_has_the_volume_of_the_bound(drawn):
    """Determinant: (n - 1)^p det(S / expected) is a product of chi-squared with n - 1, ..., n - p; 99.9 % of it."""
    p = len(drawn[1])
    product = np.prod([np.random.default_rng(i).chisquare(DRAWS - 1 - i, 200_000) for i in range(p)], axis=0)
    low, high = np.quantile(product / (DRAWS - 1.0) ** p, [0.0005, 0.9995])
    assert low < np.linalg.det(whitened(drawn)) < high


def test_the_inverse_scatter_is_the_information(drawn):
    """Diagonal of the inverse: that of the expected inverse is Wishart's, chi-squared with n - p degrees; 99.9 % each.

    For S of Wishart with mean C, (n - 1) (C^-1)_ii / (S^-1)_ii is chi-squared with n - 1 - p + 1 degrees of freedom.
    """
    error, expected = drawn
    p = len(expected)
    ratio = np.diag(np.linalg.inv(expected)) / np.diag(np.linalg.inv(np.cov(error.T)))
    low, high = chi2.ppf([0.0005, 0.9995], DRAWS - p) / (DRAWS - 1)
    assert (low < ratio).all() and (ratio < high).all()


def test_the_estimates_are_hardly_off_to_one_side(drawn):
    """The exponential of b bends the problem: a bias of the second order is left, 0.14 sd in these draws."""
    error, expected = drawn
    assert (np.abs(error.mean(axis=0)) < 0.3 * np.sqrt(np.diag(expected))).all()
