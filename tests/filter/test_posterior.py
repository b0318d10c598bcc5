"""The belief about the parameters against dense algebra in NumPy and against posteriors integrated on a grid."""

import newton_euler as twin
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from test_tension_basis import lagrange

import jawenv
from jawenv.anatomy import known_muscle_sets
from jawenv.filter.belief.posterior import (
    NEGLIGIBLE,
    posterior_dtype,
    set_bent,
    set_omega,
    set_precision,
    update_belief,
)
from jawenv.filter.belief.state import begin_belief, belief_dtype, filter_settings_dtype
from jawenv.filter.model.basis import N_NODES, build_basis, expand_coefficients
from jawenv.kernels.cholesky import invert_positive
from jawenv.mechanics import build_jaw


class Problem:
    """A prior over the muscles of a set, its basis, and what a record says about the coefficients."""

    def __init__(self, name, prior_sd=None):
        muscles = known_muscle_sets()[name]
        self.prior = jawenv.cohort("trismus", muscles).prior
        self.mean = self.prior.mean.copy()
        self.sd = self.prior.sd.copy() if prior_sd is None else np.full(len(self.mean), prior_sd)
        self.basis = build_basis(build_jaw(muscles), self.prior)[0]
        self.muscles, self.nodes = self.basis["nodes"].shape
        self.size = self.muscles * self.nodes
        self.scratch = np.zeros(1, dtype=posterior_dtype(self.muscles))[0]
        self.belief = np.zeros(1, dtype=belief_dtype(self.muscles, 10))[0]
        self.settings = np.zeros(1, dtype=filter_settings_dtype(self.muscles, 10))[0]
        self.settings["prior_mean"], self.settings["prior_sd"] = self.mean, self.sd
        begin_belief(self.basis, self.belief, self.mean, self.sd)
        self.nominal = self.coefficients(self.mean).real.copy()
        self.information, self.score = np.zeros((self.size + 1, self.size + 1)), np.zeros(self.size + 1)

    def coefficients(self, theta):
        return lagrange(self.basis, theta)

    def slope(self, theta):
        """(mK, p) derivative of the coefficients."""
        return twin.derivative(lambda v: self.coefficients(v).ravel(), theta)

    def believe(self, gain_variance=0.0, steps=200):
        """Mean, covariance and whether the last of so many steps, which begin at the prior, has moved nothing."""
        belief, known = self.belief, self.size + 1
        self.settings["gain_variance"] = gain_variance
        begin_belief(self.basis, belief, self.mean, self.sd)
        belief["nominal"] = self.nominal
        belief["information"][:known, :known], belief["score"][:known] = self.information, self.score
        for _ in range(steps):
            last = belief["mean"].copy()
            assert update_belief(belief, self.settings, self.scratch)
        mean, covariance = belief["mean"].copy(), belief["cov"].copy()
        return mean, covariance, (np.abs(mean - last) < 1e-3 * np.sqrt(np.diag(covariance))).all()


def definite(rng, size):
    factor = rng.normal(size=(size, size + 5))
    return factor @ factor.T


def test_where_c_is_a_straight_line_it_is_the_normal_equations(rng):
    """Prior sds of 1e-5, and information of that order: parameters and the load cell's gain error together."""
    for _ in range(5):
        problem = Problem("whole", prior_sd=1e-5)
        J = problem.slope(problem.mean)
        scale = 1e5 / np.append(np.abs(J).max(axis=1), 1e5 * 100.0)
        problem.information[:] = definite(rng, problem.size + 1) * np.outer(scale, scale) / problem.size
        problem.score[:] = np.linalg.cholesky(problem.information) @ rng.normal(size=problem.size + 1)
        gain_sd, of_all = 0.01, np.zeros((problem.size + 1, 13))
        of_all[:-1, :12], of_all[-1, 12] = J, 1.0
        precision = of_all.T @ problem.information @ of_all
        precision += np.diag(np.append(problem.sd, gain_sd) ** -2.0)
        P = np.linalg.inv(precision)
        expected = (P @ of_all.T @ problem.score)[:12]
        mean, covariance, converged = problem.believe(gain_sd**2)
        sd = np.sqrt(np.diag(P))[:12]
        assert converged
        assert np.abs((mean - problem.mean - expected) / sd).max() < 1e-3
        assert np.abs((covariance - P[:12, :12]) / np.outer(sd, sd)).max() < 1e-3
        assert (sd / problem.sd).min() < 0.7 and np.abs(expected / sd).max() > 0.1, "the record teaches something"


def second_derivatives(twice):
    """(mK, p, p) from those of each muscle's coefficients (m, K, 3)."""
    muscles, nodes, _ = twice.shape
    H = np.zeros((muscles * nodes, 2 * muscles, 2 * muscles))
    for i in range(muscles):
        for k in range(nodes):
            f, g, h = twice[i, k]
            H[i * nodes + k, 2 * i : 2 * i + 2, 2 * i : 2 * i + 2] = [[f, g], [g, h]]
    return H


def first_derivatives(twice):
    """(mK, p): c is proportional to F_o, so that these are among the second ones."""
    muscles, nodes, _ = twice.shape
    J = np.zeros((muscles * nodes, 2 * muscles))
    for i in range(muscles):
        J[nodes * i : nodes * (i + 1), 2 * i : 2 * i + 2] = twice[i, :, :2]
    return J


def half_trace(twice, covariance):
    """Omega (mK, mK) by its definition."""
    H = second_derivatives(twice)
    return 0.5 * np.einsum("aij,jk,bkl,li->ab", H, covariance, H, covariance, optimize=True)


class Linearised(Problem):
    """One linearisation: any Lambda = B B^T, any second derivatives, any covariance; what the kernels make of them."""

    def __init__(self, rng, rank, size_of_information=1.0, size_of_bend=1.0):
        super().__init__("whole")
        root = rng.normal(size=(self.size, rank)) * np.exp(rng.normal(size=rank))
        self.root = root * np.sqrt(size_of_information / np.sum(root**2))
        self.twice = size_of_bend * rng.normal(size=(self.muscles, self.nodes, 3))
        parameters = len(self.mean)
        self.covariance = definite(rng, parameters) / parameters
        self.score[:-1] = self.root @ rng.normal(size=rank)
        self.at = self.mean + 0.3 * rng.normal(size=parameters)

    def by_kernels(self):
        """Precision and gradient; None where rounding leaves no answer."""
        scratch = self.scratch
        scratch["marginal"], scratch["unexplained"] = self.root @ self.root.T, self.score[:-1]
        scratch["coefficients"], scratch["by_log_twice"] = self.nominal, self.twice
        set_bent(self.nominal, scratch)
        set_omega(self.covariance, scratch["omega"])
        if not set_precision(self.at, self.mean, self.sd, scratch):
            return None
        return scratch["precision"].copy(), scratch["right"].copy()

    @property
    def lost(self):
        return np.trace(self.root.T @ half_trace(self.twice, self.covariance) @ self.root)

    def directly(self):
        """J^T (Lambda^-1 + Omega)^-1 J by the matrix inversion lemma: Lambda need not have an inverse."""
        B, J, Omega = self.root, first_derivatives(self.twice), half_trace(self.twice, self.covariance)
        rest = np.linalg.inv(np.eye(B.shape[1]) + B.T @ Omega @ B)
        gradient = J.T @ (self.score[:-1] - B @ (rest @ (B.T @ (Omega @ self.score[:-1]))))
        return (J.T @ B @ rest @ B.T @ J + np.diag(self.sd**-2.0), gradient + (self.mean - self.at) / self.sd**2)


def agree(actual, expected, tolerance):
    (precision, right), (P, gradient) = actual, expected
    sizes = np.sqrt(np.diag(P))
    assert np.abs((precision - P) / np.outer(sizes, sizes)).max() < tolerance
    assert np.abs((right - gradient) / sizes).max() < tolerance * (1.0 + np.abs(gradient / sizes).max())


def test_the_precision_is_that_of_the_direct_formula(rng):
    """(Lambda^-1 + Omega)^-1 with Lambda definite, by dense inverses of its own size."""
    for bend in (0.1, 1.0, 10.0):
        drawn = Linearised(rng, 50, size_of_information=24.0, size_of_bend=bend)
        Lambda, J = drawn.root @ drawn.root.T, first_derivatives(drawn.twice)
        less = np.linalg.inv(np.linalg.inv(Lambda) + half_trace(drawn.twice, drawn.covariance))
        gradient = J.T @ less @ np.linalg.solve(Lambda, drawn.score[:-1]) + (drawn.mean - drawn.at) / drawn.sd**2
        expected = J.T @ less @ J + np.diag(drawn.sd**-2.0), gradient
        assert drawn.lost > NEGLIGIBLE
        agree(drawn.directly(), expected, 1e-8)
        agree(drawn.by_kernels(), expected, 1e-8)


@pytest.mark.parametrize("rank", [1, 2, 5, 11, 17, 23])
def test_information_about_a_few_sums_has_no_inverse_and_needs_none(rng, rank):
    for information in (1.0, 1e3):
        drawn = Linearised(rng, rank, size_of_information=information)
        assert drawn.lost > NEGLIGIBLE
        agree(drawn.by_kernels(), drawn.directly(), 1e-6)


def test_a_negligible_omega_is_left_out(rng):
    drawn = Linearised(rng, 30, size_of_information=24.0, size_of_bend=1.0)
    drawn.covariance *= np.sqrt(0.5 * NEGLIGIBLE / drawn.lost)
    assert drawn.lost < NEGLIGIBLE
    J = first_derivatives(drawn.twice)
    expected = J.T @ drawn.root @ drawn.root.T @ J + np.diag(drawn.sd**-2.0)
    precision, _ = drawn.by_kernels()
    np.testing.assert_allclose(precision, expected, rtol=1e-10, atol=1e-10 * np.abs(expected).max())
    agree((precision, drawn.directly()[1]), drawn.directly(), NEGLIGIBLE)


@settings(max_examples=150, deadline=None, derandomize=True, database=None)
@given(
    seed=st.integers(0, 10_000),
    rank=st.integers(1, 30),
    information=st.floats(-6.0, 14.0),
    bend=st.floats(-3.0, 4.0),
    narrow=st.floats(-8.0, 0.0),
)
def test_the_precision_stays_positive_definite(seed, rank, information, bend, narrow):
    """Whatever the sizes of Lambda and Omega: what the data add to the prior is never negative."""
    rng = np.random.default_rng(seed)
    drawn = Linearised(rng, rank, 10.0**information, 10.0**bend)
    squeeze = np.sqrt(10.0 ** (narrow * rng.random(len(drawn.mean))))
    drawn.covariance *= np.outer(squeeze, squeeze)
    precise = drawn.by_kernels()
    assert precise is not None
    precision, right = precise
    assert np.isfinite(precision).all() and np.isfinite(right).all()
    data = precision * np.outer(drawn.sd, drawn.sd) - np.eye(len(drawn.sd))
    sizes = np.sqrt(1.0 + np.diag(data))
    assert np.linalg.eigvalsh(data / np.outer(sizes, sizes))[0] > -1e-12
    covariance = np.empty_like(precision)
    assert invert_positive(precision, covariance)
    believed = np.linalg.eigvalsh(covariance / np.outer(drawn.sd, drawn.sd))
    assert believed[0] > 0.0 and believed[-1] < 1.0 + 1e-6


def test_what_it_converges_to_is_its_own_linearisation(rng):
    """Posterior linearisation's fixed point, by dense inverses: information (Lambda^-1 + Omega)^-1."""
    problem = Problem("whole")
    J = problem.slope(problem.mean)
    scale = 6.0 / np.abs(J).max(axis=1)
    problem.information[:-1, :-1] = definite(rng, problem.size) * np.outer(scale, scale) / problem.size
    problem.score[:-1] = np.linalg.cholesky(problem.information[:-1, :-1]) @ rng.normal(size=problem.size)
    mean, covariance, converged = problem.believe()
    assert converged
    c, twice = np.empty((6, N_NODES)), np.empty((6, N_NODES, 3))
    expand_coefficients(problem.basis, mean, covariance, c, twice)
    J, Omega, Lambda = first_derivatives(twice), half_trace(twice, covariance), problem.information[:-1, :-1]
    assert np.trace(Lambda @ Omega) > 0.1, "the error of the linearisation counts here"
    less = np.linalg.inv(np.linalg.inv(Lambda) + Omega)
    precision = J.T @ less @ J + np.diag(problem.sd**-2.0)
    residual = np.linalg.solve(Lambda, problem.score[:-1]) - (c - problem.nominal).ravel()
    gradient = J.T @ less @ residual - (mean - problem.mean) / problem.sd**2
    sd = np.sqrt(np.diag(covariance))
    assert np.abs((np.linalg.inv(precision) - covariance) / np.outer(sd, sd)).max() < 1e-5
    assert np.abs(covariance @ gradient / sd).max() < 1e-5


class Ridge(Problem):
    """One muscle whose tension was measured at one strain, with an error of 1 %: F_o exp(b e) is known, no more."""

    strain, error = 0.08, 0.01

    def __init__(self, share):
        super().__init__("closers")
        self.whole = float(self.basis["centre"][0]) + self.strain
        usual = np.exp(self.mean[0] + np.exp(self.mean[1]) * self.whole)
        self.tension, self.noise = share * usual, self.error * share * usual
        line = np.exp(self.basis["nodes"][0] * self.strain)
        self.information[:-1, :-1] = np.outer(line, line) / self.noise**2
        self.score[:-1] = line * (self.tension - usual) / self.noise**2

    def by_grid(self):
        """Mean and covariance of the posterior of the law itself, integrated over (log b, log tension)."""
        log_b = self.mean[1] + self.sd[1] * np.linspace(-6.0, 6.0, 4001)[:, None]
        log_tension = np.log(self.tension) + self.error * np.linspace(-8.0, 8.0, 801)[None, :]
        log_F = log_tension - np.exp(log_b) * self.whole
        density = -0.5 * ((np.exp(log_tension) - self.tension) / self.noise) ** 2
        density = density - 0.5 * ((log_F - self.mean[0]) / self.sd[0]) ** 2
        density = density - 0.5 * ((log_b - self.mean[1]) / self.sd[1]) ** 2
        weight = np.exp(density - density.max())
        weight /= weight.sum()
        both = np.stack([log_F, np.broadcast_to(log_b, log_F.shape)])
        mean = np.sum(weight * both, axis=(1, 2))
        away = both - mean[:, None, None]
        return mean, np.einsum("ikl,jkl,kl->ij", away, away, weight, optimize=True)

    def laplace(self):
        """Covariance from the curvature at the mode, found by Newton's method along the gradient of the law."""
        theta = self.mean.copy()
        for _ in range(200):
            tension = np.exp(theta[0] + np.exp(theta[1]) * self.whole)
            by_theta = tension * np.array([1.0, np.exp(theta[1]) * self.whole])
            precision = np.outer(by_theta, by_theta) / self.noise**2 + np.diag(self.sd**-2.0)
            gradient = by_theta * (self.tension - tension) / self.noise**2 - (theta - self.mean) / self.sd**2
            step = np.linalg.solve(precision, gradient)
            theta += step / max(1.0, np.abs(step / self.sd).max())
        assert np.abs(step / self.sd).max() < 1e-6
        return theta, np.linalg.inv(precision)


@pytest.mark.parametrize("share", [0.6, 1.0, 1.7])
def test_along_a_curved_ridge(share):
    """Measured: means within 0.08 sd, sds within 8 %; across the ridge the tangent plane's variance is a fifteenth."""
    ridge = Ridge(share)
    exact_mean, exact = ridge.by_grid()
    mean, covariance, converged = ridge.believe()
    mode, tangent = ridge.laplace()
    sd = np.sqrt(np.diag(exact))
    across = np.array([1.0, np.exp(mode[1]) * ridge.whole])
    width, believed, flat = (across @ P @ across for P in (exact, covariance, tangent))
    assert converged
    assert np.abs((mean - exact_mean) / sd).max() < 0.15
    np.testing.assert_allclose(np.sqrt(np.diag(covariance)), sd, rtol=0.15)
    honest = np.linalg.solve(covariance, exact).trace()
    assert 1.4 < honest < 2.8, "2 where the covariance is right"
    assert 0.7 < believed / width < 1.8
    assert flat < 0.15 * width, "the tangent plane leaves the ridge"
    assert np.linalg.solve(tangent, exact).trace() > 5.0 * honest


@pytest.mark.parametrize("bad", [-1e6, np.nan, np.inf])
def test_without_an_answer_the_last_belief_stays(rng, bad):
    """Information that is negative or no number: to the bit what was believed before, the score's effect included."""
    problem = Problem("whole")
    J = problem.slope(problem.mean)
    scale = 6.0 / np.abs(J).max(axis=1)
    problem.information[:-1, :-1] = definite(rng, problem.size) * np.outer(scale, scale) / problem.size
    mean, covariance, _ = problem.believe(steps=3)
    problem.belief["information"][: problem.size, : problem.size] = np.diag(np.full(problem.size, bad))
    assert not update_belief(problem.belief, problem.settings, problem.scratch)
    np.testing.assert_array_equal(problem.belief["mean"], mean)
    np.testing.assert_array_equal(problem.belief["cov"], covariance)
    assert (np.diag(covariance) < 0.99 * problem.sd**2).any(), "and that was not the prior"


def test_a_step_is_newtons_and_ends_at_the_trust_region(rng):
    """The error falls with its square where the belief is narrow; from far off no step is longer than a prior sd."""
    problem = Problem("whole", prior_sd=0.05)
    J = problem.slope(problem.mean)
    scale = 2e4 / np.abs(J).max(axis=1)
    problem.information[:-1, :-1] = definite(rng, problem.size) * np.outer(scale, scale) / problem.size
    shift = problem.coefficients(problem.mean + 0.04).real - problem.nominal
    problem.score[:-1] = problem.information[:-1, :-1] @ shift.ravel()
    end, covariance, converged = problem.believe()
    assert converged
    sd, distances = np.sqrt(np.diag(covariance)), []
    for steps in (1, 2, 3):
        distances.append(np.abs((problem.believe(steps=steps)[0] - end) / sd).max())
    assert distances[0] < np.abs((problem.mean - end) / sd).max() and distances[2] < 0.1 * distances[1]
    problem.score *= 1e3
    once, _, _ = problem.believe(steps=1)
    assert np.abs((once - problem.mean) / problem.sd).max() == pytest.approx(1.0)
