"""The belief about the parameters against dense algebra in NumPy and against posteriors integrated on a grid."""

import newton_euler as twin
import numpy as np
import pytest

import jawenv
from jawenv.anatomy import known_muscle_sets
from jawenv.estimation.posterior import believe, invert_positive, posterior_fields, set_omega, solve_general
from jawenv.estimation.tension_basis import build_basis, expand_coefficients
from jawenv.mechanics import build_jaw


class Problem:
    """A prior over the muscles of a set, its basis, and what a record says about the coefficients."""

    def __init__(self, name, prior_sd=None):
        muscles = known_muscle_sets()[name]
        self.prior = jawenv.cohort("trismus", muscles).prior
        self.mean = self.prior.mean.copy()
        self.sd = self.prior.sd.copy() if prior_sd is None else np.full(len(self.mean), prior_sd)
        self.basis = build_basis(build_jaw(muscles), self.prior, 4)[0]
        self.muscles, self.nodes = self.basis["nodes"].shape
        self.size = self.muscles * self.nodes
        self.scratch = np.zeros(1, dtype=np.dtype(posterior_fields(self.muscles, self.nodes), align=True))[0]
        self.nominal = self.coefficients(self.mean).real.copy()
        self.information, self.score = np.zeros((self.size + 1, self.size + 1)), np.zeros(self.size + 1)

    def coefficients(self, theta):
        """(m, K) by the definition, for complex arguments."""
        F_o, b, c = np.exp(theta[0::2]), np.exp(theta[1::2]), np.empty((self.muscles, self.nodes), dtype=complex)
        for i, nodes in enumerate(self.basis["nodes"]):
            for k, node in enumerate(nodes):
                others = np.delete(nodes, k)
                weight = np.prod((b[i] - others) / (node - others))
                c[i, k] = F_o[i] * np.exp(b[i] * self.basis["centre"][i]) * weight
        return c

    def slope(self, theta):
        """(mK, p) derivative of the coefficients."""
        return twin.derivative(lambda v: self.coefficients(v).ravel(), theta)

    def believe(self, gain_variance=0.0, calls=60):
        """Mean, covariance and whether it has converged after ``calls`` single rounds from the prior."""
        mean, covariance, converged = self.mean.copy(), np.diag(self.sd**2), False
        lower = np.tril(self.information) + np.triu(np.full_like(self.information, np.nan), 1)
        for _ in range(calls):
            converged = believe(
                self.basis, lower, self.score, self.nominal, gain_variance, self.mean, self.sd, mean, covariance,
                self.scratch, 1,
            )  # fmt: skip
        return mean, covariance, converged


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


def second_derivatives(problem):
    """(mK, p, p) from ``scratch.by_log_twice``."""
    twice = problem.scratch["by_log_twice"]
    H = np.zeros((problem.size, 2 * problem.muscles, 2 * problem.muscles))
    for i in range(problem.muscles):
        for k in range(problem.nodes):
            f, g, h = twice[i, k]
            H[i * problem.nodes + k, 2 * i : 2 * i + 2, 2 * i : 2 * i + 2] = [[f, g], [g, h]]
    return H


def test_omega_is_half_the_trace(rng):
    problem = Problem("whole")
    problem.scratch["by_log_twice"] = rng.normal(size=(6, 4, 3))
    P = definite(rng, 12)
    set_omega(P, problem.scratch)
    H = second_derivatives(problem)
    expected = 0.5 * np.einsum("aij,jk,bkl,li->ab", H, P, H, P, optimize=True)
    np.testing.assert_allclose(problem.scratch["omega"], expected, rtol=1e-10, atol=1e-10 * np.abs(expected).max())
    np.testing.assert_array_equal(problem.scratch["omega"], problem.scratch["omega"].T)


def test_what_it_converges_to_is_its_own_linearisation(rng):
    """Posterior linearisation's fixed point, by dense inverses: information (Lambda^-1 + Omega)^-1."""
    problem = Problem("whole")
    J = problem.slope(problem.mean)
    scale = 6.0 / np.abs(J).max(axis=1)
    problem.information[:-1, :-1] = definite(rng, problem.size) * np.outer(scale, scale) / problem.size
    problem.score[:-1] = np.linalg.cholesky(problem.information[:-1, :-1]) @ rng.normal(size=problem.size)
    mean, covariance, converged = problem.believe()
    assert converged
    c, once, twice = np.empty((6, 4)), np.empty((6, 4, 2)), np.empty((6, 4, 3))
    expand_coefficients(problem.basis, mean, covariance, c, once, twice)
    problem.scratch["by_log_twice"] = twice
    H, J = second_derivatives(problem), np.zeros((problem.size, 12))
    for i in range(6):
        J[4 * i : 4 * i + 4, 2 * i : 2 * i + 2] = once[i]
    Omega = 0.5 * np.einsum("aij,jk,bkl,li->ab", H, covariance, H, covariance, optimize=True)
    Lambda = problem.information[:-1, :-1]
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


def test_inverse_of_a_positive_definite_matrix(rng):
    for size in (1, 2, 12, 24):
        matrix = definite(rng, size)
        work, inverse = matrix.copy(), np.empty((size, size))
        assert invert_positive(work, inverse)
        np.testing.assert_allclose(inverse, np.linalg.inv(matrix), rtol=1e-9, atol=1e-12)
        np.testing.assert_array_equal(inverse, inverse.T)


@pytest.mark.parametrize("bad", [0.0, -1.0, np.nan])
def test_other_matrices_have_none(rng, bad):
    matrix = definite(rng, 6)
    values, vectors = np.linalg.eigh(matrix)
    values[0] = bad
    work = vectors @ np.diag(values) @ vectors.T if bad != 0.0 else np.diag([1.0, 0.0, 1.0, 1.0, 1.0, 1.0])
    assert not invert_positive(work, np.empty((6, 6)))


def test_linear_equations(rng):
    for size, columns in ((1, 1), (4, 3), (24, 13)):
        matrix, right = rng.normal(size=(size, size)), rng.normal(size=(size, columns))
        if size > 1:
            matrix[0, 0] = 0.0  # no pivot without a change of rows
        expected = np.linalg.solve(matrix, right)
        solve_general(matrix.copy(), right)
        np.testing.assert_allclose(right, expected, rtol=1e-8, atol=1e-10)


def test_information_that_is_none_leaves_no_belief():
    """A negative information makes no covariance: NaN on its diagonal, which ends the episode."""
    problem = Problem("whole")
    problem.information[:-1, :-1] = -1e6 * np.eye(problem.size)
    mean, covariance, converged = problem.believe(calls=1)
    assert not converged
    assert np.isnan(np.diag(covariance)).all()
    np.testing.assert_array_equal(mean, problem.mean)
