"""The bound against what it bounds: the scatter of the most probable parameters over many draws of the noise.

Of one patient, at the prior's mean, the estimate is the truth plus an error whose sampling covariance is, to first
order, B J B. B is the posterior bound and J = B^-1 - B_0^-1 what the record alone tells: the prior B_0 holds the
estimate to its mean, which is here the truth, and so adds no scatter. If that is right, the sample covariance
S of n draws has Wishart's distribution with n - 1 degrees of freedom and that mean.

First order holds where errors are small beside the curvature of F_o exp(b e), in which log b stands in the exponent of
an exponent. So the scene of the full model is one whose bound is below a tenth for every parameter, at the noise that
the device usually has: six seconds, against a prior sd of 0.44 and 0.26. Its muscles are soft and it moves between the
teeth and the ends of the slide, so that the model takes every step whole: where steps are divided, the motion that the
model makes depends on the parameters by jumps, which no derivative knows. Both were settled before any scatter was
looked at, and are asserted.
"""

from dataclasses import replace

import numpy as np
from scipy.stats import chi2

import jawenv
from jawenv.analysis.bound import bound_along
from jawenv.anatomy import Patient, Prior, cohort
from jawenv.ladder import model_named
from jawenv.references import smoother
from jawenv.references.smoother import IteratedSmoother

DRAWS = 80
SURE = [0.0005, 0.9995]  # quantiles of what chance alone does
GENTLE = {"full_scale_N": 6.0, "slew_N_s": 12.0, "brake_N_s_m": 30.0, "cell_gain": 0.0}


class OpenAndSwing:
    """Holds the jaw open and a little forward, and swings each motor in a sine of its own; sees nothing."""

    control = "force"
    frequencies = np.array([0.9, 0.6, 1.1, 0.7])  # Hz
    swings = np.array([0.15, 0.15, 0.1, 0.1])

    def reset(self, num_envs, seed):
        self.time = 0.0

    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        self.time += 0.05
        action = 0.1 * min(1.0, self.time) + self.swings * np.sin(2.0 * np.pi * self.frequencies * self.time)
        return np.tile(action, (len(observation), 1)).astype(np.float32), state


class Push:
    """Opens and closes the jaw once, whatever is observed, without pressing the teeth together."""

    control = "force"

    def reset(self, num_envs, seed):
        self.time = 0.0

    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        self.time += 0.05
        action = np.zeros((len(observation), 4), dtype=np.float32)
        action[:, 0] = 0.4 * np.sin(np.pi * self.time) ** 2
        return action, state


def drawn(name, agent, force_N, seconds, draws):
    """Records of one patient and many draws of the noise, and the most probable path of each.

    Every F_o is ``force_N``, every b the usual one; the prior's mean is moved to them, its sds are the usual ones.
    """
    model = model_named(name)
    usual = cohort("healthy", model.muscles).prior
    truth = usual.mean.copy()
    truth[::2] = np.log(force_N)
    patient = Patient.from_log_parameters(truth, muscles=model.muscles.names)
    # The gain error is known to be none: what is only considered adds scatter of its own.
    settings = {"record": True, "track_bound": False, "episode_s": seconds, "device": GENTLE}
    played = jawenv.play(agent, patients=[patient] * draws, seed=100, env_id=model.env_id, env_kwargs=settings)
    assert not played.terminated.any()
    records = [replace(record, prior=Prior(truth, usual.sd)) for record in played.records]
    # A hundredth of an sd is nothing beside the scatter.
    found = [IteratedSmoother(tolerance=1e-2).find_path(record) for record in records]
    assert all(result.converged for result in found)
    return records, found


def scatter(records, found):
    """(n, p) errors, and the mean of B J B over the draws, whose motions the noise makes a little different."""
    errors = np.array([result.path.parameters for result in found]) - records[0].truth
    before = np.diag(1.0 / records[0].prior.sd ** 2)
    bounds = [bound_along(record, every=10_000).cov[-1] for record in records]
    return errors, np.mean([bound - bound @ before @ bound for bound in bounds], axis=0), np.mean(bounds, axis=0)


def assert_size(whitened, draws):
    """Trace: (n - 1) tr(S / expected) is chi-squared with (n - 1) p degrees of freedom; 99.9 % of it."""
    freedom = (draws - 1) * len(whitened)
    low, high = chi2.ppf(SURE, freedom) / freedom
    assert low < np.trace(whitened) / len(whitened) < high


def assert_volume(whitened, draws):
    """Determinant: (n - 1)^p det(S / expected) is a product of chi-squared with n - 1, ..., n - p; 99.9 % of it."""
    p = len(whitened)
    product = np.prod([np.random.default_rng(i).chisquare(draws - 1 - i, 200_000) for i in range(p)], axis=0)
    low, high = np.quantile(product / (draws - 1.0) ** p, SURE)
    assert low < np.linalg.det(whitened) < high


def assert_inverse(errors, expected):
    """Diagonal of the inverse: that of the expected inverse is Wishart's, chi-squared with n - p degrees; 99.9 % each.

    For S of Wishart with mean C, (n - 1) (C^-1)_ii / (S^-1)_ii is chi-squared with n - 1 - p + 1 degrees of freedom.
    """
    draws, p = errors.shape
    ratio = np.diag(np.linalg.inv(expected)) / np.diag(np.linalg.inv(np.cov(errors.T)))
    low, high = chi2.ppf(SURE, draws - p) / (draws - 1)
    assert (low < ratio).all() and (ratio < high).all()


def assert_inside(errors, expected):
    """All of it, and that the estimates are hardly off to one side.

    The exponential of b bends the problem: a bias of the second order is left, up to 0.14 sd in these draws.
    """
    factor = np.linalg.cholesky(expected)
    whitened = np.linalg.solve(factor, np.linalg.solve(factor, np.cov(errors.T)).T)
    assert_size(whitened, len(errors))
    assert_volume(whitened, len(errors))
    assert_inverse(errors, expected)
    # The most probable path leans by a third of an sd where muscles are soft: b of a medial pterygoid.
    assert (np.abs(errors.mean(axis=0)) < 0.4 * np.sqrt(np.diag(expected))).all()


def test_twelve_parameters_scatter_as_the_bound_of_the_full_model_says():
    records, found = drawn("jaw", OpenAndSwing(), 0.3, 7.0, DRAWS)
    errors, expected, bound = scatter(records, found)
    assert errors.shape == (DRAWS, 12)
    assert (np.sqrt(np.diag(bound)) < 0.1).all()
    for record, result in zip(records, found, strict=True):
        assert not smoother._Problem(record).divide(result.path), "every step is taken whole"
    assert_inside(errors, expected)


def test_one_muscle_scatters_as_the_bound_of_the_hinge_says():
    """A patient of the cohort, who rests on the teeth: there steps are divided, in fewer draws."""
    errors, expected, _ = scatter(*drawn("hinge", Push(), 7.2, 1.0, 120))
    assert_inside(errors, expected)
