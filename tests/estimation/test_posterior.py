"""The belief about the parameters against dense algebra in NumPy and against posteriors integrated on a grid."""

import newton_euler as twin
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import jawenv
from jawenv.anatomy import known_muscle_sets
from jawenv.estimation.online.basis import build_basis, expand_coefficients
from jawenv.estimation.online.posterior import (
    NEGLIGIBLE,
    believe,
    invert_positive,
    posterior_fields,
    set_bent,
    set_omega,
    set_precision,
    set_root,
)
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


def spread_out(twice):
    """T (mK, 3 m) with the muscles' second derivatives in blocks."""
    muscles, nodes, _ = twice.shape
    T = np.zeros((muscles * nodes, 3 * muscles))
    for i in range(muscles):
        T[nodes * i : nodes * (i + 1), 3 * i : 3 * i + 3] = twice[i]
    return T


def test_omega_is_half_the_trace(rng):
    problem = Problem("whole")
    twice, P, G = rng.normal(size=(6, 4, 3)), definite(rng, 12), np.empty((18, 18))
    set_omega(P, G)
    T, expected = spread_out(twice), half_trace(twice, P)
    np.testing.assert_allclose(T @ G @ T.T, expected, rtol=1e-10, atol=1e-10 * np.abs(expected).max())
    np.testing.assert_array_equal(G, G.T)
    assert np.linalg.eigvalsh(G)[0] > -1e-12 * np.linalg.eigvalsh(G)[-1]
    assert problem.scratch["omega"].shape == G.shape


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
        scratch["known"], scratch["unexplained"] = self.root @ self.root.T, self.score[:-1]
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
        return (
            J.T @ B @ rest @ B.T @ J + np.diag(self.sd**-2.0),
            gradient + (self.mean - self.at) / self.sd**2,
        )


def agree(actual, expected, tolerance):
    (precision, right), (P, gradient) = actual, expected
    sizes = np.sqrt(np.diag(P))
    assert np.abs((precision - P) / np.outer(sizes, sizes)).max() < tolerance
    assert np.abs((right - gradient) / sizes).max() < tolerance * (1.0 + np.abs(gradient / sizes).max())


def test_the_precision_is_that_of_the_direct_formula(rng):
    """(Lambda^-1 + Omega)^-1 with Lambda definite, by dense inverses of its own size."""
    for bend in (0.1, 1.0, 10.0):
        one = Linearised(rng, 40, size_of_information=24.0, size_of_bend=bend)
        Lambda, J = one.root @ one.root.T, first_derivatives(one.twice)
        less = np.linalg.inv(np.linalg.inv(Lambda) + half_trace(one.twice, one.covariance))
        gradient = J.T @ less @ np.linalg.solve(Lambda, one.score[:-1]) + (one.mean - one.at) / one.sd**2
        expected = J.T @ less @ J + np.diag(one.sd**-2.0), gradient
        assert one.lost > NEGLIGIBLE
        agree(one.directly(), expected, 1e-8)
        agree(one.by_kernels(), expected, 1e-8)


@pytest.mark.parametrize("rank", [1, 2, 5, 11, 17, 23])
def test_information_about_a_few_sums_has_no_inverse_and_needs_none(rng, rank):
    for information in (1.0, 1e3):
        one = Linearised(rng, rank, size_of_information=information)
        assert one.lost > NEGLIGIBLE
        agree(one.by_kernels(), one.directly(), 1e-6)


def test_a_negligible_omega_is_left_out(rng):
    one = Linearised(rng, 30, size_of_information=24.0, size_of_bend=1.0)
    one.covariance *= np.sqrt(0.5 * NEGLIGIBLE / one.lost)
    assert one.lost < NEGLIGIBLE
    J = first_derivatives(one.twice)
    expected = J.T @ one.root @ one.root.T @ J + np.diag(one.sd**-2.0)
    precision, _ = one.by_kernels()
    np.testing.assert_allclose(precision, expected, rtol=1e-10, atol=1e-10 * np.abs(expected).max())
    agree((precision, one.directly()[1]), one.directly(), NEGLIGIBLE)


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
    one = Linearised(rng, rank, 10.0**information, 10.0**bend)
    squeeze = np.sqrt(10.0 ** (narrow * rng.random(len(one.mean))))
    one.covariance *= np.outer(squeeze, squeeze)
    found = one.by_kernels()
    assert found is not None
    precision, right = found
    assert np.isfinite(precision).all() and np.isfinite(right).all()
    data = precision * np.outer(one.sd, one.sd) - np.eye(len(one.sd))
    sizes = np.sqrt(1.0 + np.diag(data))
    assert np.linalg.eigvalsh(data / np.outer(sizes, sizes))[0] > -1e-12
    covariance = np.empty_like(precision)
    assert invert_positive(precision, covariance)
    believed = np.linalg.eigvalsh(covariance / np.outer(one.sd, one.sd))
    assert believed[0] > 0.0 and believed[-1] < 1.0 + 1e-6


def test_root_of_a_semidefinite_matrix(rng):
    for rank in (1, 4, 9):
        factor = rng.normal(size=(9, rank))
        matrix, root = factor @ factor.T, np.full((9, 9), np.nan)
        set_root(matrix, root)
        np.testing.assert_allclose(root @ root.T, matrix, rtol=0, atol=1e-6 * matrix.max())
        np.testing.assert_array_equal(root, np.tril(root))


def test_what_it_converges_to_is_its_own_linearisation(rng):
    """Posterior linearisation's fixed point, by dense inverses: information (Lambda^-1 + Omega)^-1."""
    problem = Problem("whole")
    J = problem.slope(problem.mean)
    scale = 6.0 / np.abs(J).max(axis=1)
    problem.information[:-1, :-1] = definite(rng, problem.size) * np.outer(scale, scale) / problem.size
    problem.score[:-1] = np.linalg.cholesky(problem.information[:-1, :-1]) @ rng.normal(size=problem.size)
    mean, covariance, converged = problem.believe()
    assert converged
    c, twice = np.empty((6, 4)), np.empty((6, 4, 3))
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


def test_information_that_is_none_leaves_no_belief():
    """A negative information makes no covariance: NaN on its diagonal, which ends the episode."""
    problem = Problem("whole")
    problem.information[:-1, :-1] = -1e6 * np.eye(problem.size)
    mean, covariance, converged = problem.believe(calls=1)
    assert not converged
    assert np.isnan(np.diag(covariance)).all()
    np.testing.assert_array_equal(mean, problem.mean)
