"""Tensions as sums of fixed exponentials, against the exponential law itself and its exact derivatives."""

from math import factorial

import newton_euler as twin
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.polynomial.hermite_e import hermegauss

import jawenv
from jawenv.anatomy import known_muscle_sets
from jawenv.filter.belief.state import tension_columns
from jawenv.filter.model.basis import (
    MIDDLE_POSE,
    N_NODES,
    build_basis,
    expand_coefficients,
    set_coefficients,
    set_derivatives,
)
from jawenv.mechanics import build_jaw

PRIORS = {name: jawenv.cohort(name).prior for name in jawenv.COHORTS}
JAW = build_jaw()
STRAIN = 0.08  # from the middle pose, as maneuvers go


def basis_of(cohort):
    return build_basis(JAW, PRIORS[cohort])[0]


def coefficients(basis, theta):
    c = np.empty(basis["nodes"].shape)
    set_coefficients(basis, theta, c)
    return c


def lagrange(basis, theta):
    """(6, K) coefficients by the definition, for complex arguments: products over the other nodes."""
    F_o, b = np.exp(theta[0::2]), np.exp(theta[1::2])
    c = np.empty(basis["nodes"].shape, dtype=complex)
    for i, nodes in enumerate(basis["nodes"]):
        for k, node in enumerate(nodes):
            others = np.delete(nodes, k)
            c[i, k] = F_o[i] * np.exp(b[i] * basis["centre"][i]) * np.prod((b[i] - others) / (node - others))
    return c


@settings(max_examples=200, deadline=None, derandomize=True, database=None)
@given(
    cohort=st.sampled_from(sorted(PRIORS)),
    away=st.lists(st.floats(-2.0, 2.0), min_size=12, max_size=12),
    strain=st.floats(-STRAIN, STRAIN),
)
def test_the_sum_is_the_exponential_but_for_the_stated_remainder(cohort, away, strain):
    """(b - b_1)...(b - b_K) e^K / K! times an exponential with an exponent between the smallest and largest of them."""
    prior, basis = PRIORS[cohort], basis_of(cohort)
    theta = prior.mean + prior.sd * np.array(away)
    F_o, b, K = np.exp(theta[0::2]), np.exp(theta[1::2]), basis["nodes"].shape[1]
    tension = F_o * np.exp(b * (basis["centre"] + strain))
    summed = np.sum(coefficients(basis, theta) * np.exp(basis["nodes"] * strain), axis=1)
    gaps = np.prod(np.abs(b[:, None] - basis["nodes"]), axis=1)
    steepest = np.maximum(b, basis["nodes"].max(axis=1)) if strain > 0 else np.minimum(b, basis["nodes"].min(axis=1))
    remainder = gaps * np.abs(strain) ** K / factorial(K) * np.exp((steepest - b) * strain)
    assert (np.abs(summed / tension - 1.0) <= 1.001 * remainder + 1e-11).all()


def expand(basis, theta, covariance):
    n, K = basis["nodes"].shape
    c, twice = np.empty((n, K)), np.empty((n, K, 3))
    expand_coefficients(basis, theta, covariance, c, twice)
    return c, twice


def test_the_derivatives_at_a_point(rng):
    """With covariance 0 against complex steps of the definition; the second ones by differences of these.

    c is proportional to F_o: the first ones are those that have log F_o among the two.
    """
    basis = basis_of("trismus")

    def gradient(at):
        by_all = twin.derivative(lambda v: lagrange(basis, v).ravel(), at).reshape(*basis["nodes"].shape, 12)
        return np.array([by_all[i][:, 2 * i : 2 * i + 2] for i in range(6)])

    theta, h = jawenv.cohort("trismus").draw_log_parameters(rng), 1e-5
    c, twice = expand(basis, theta, np.zeros((12, 12)))
    once = twice[:, :, :2]
    scale = np.abs(once).max()
    np.testing.assert_allclose(c, lagrange(basis, theta).real, rtol=0, atol=1e-9 * scale)
    np.testing.assert_allclose(once, gradient(theta), rtol=0, atol=1e-9 * scale)
    by_F, by_b = (
        (gradient(theta + h * shift) - gradient(theta - h * shift)) / (2 * h)
        for shift in (np.tile([1.0, 0.0], 6), np.tile([0.0, 1.0], 6))
    )
    expected = np.stack([by_F[:, :, 0], by_F[:, :, 1], by_b[:, :, 1]], axis=2)
    np.testing.assert_allclose(by_b[:, :, 0], by_F[:, :, 1], rtol=0, atol=1e-6 * scale)
    np.testing.assert_allclose(twice, expected, rtol=0, atol=1e-7 * np.abs(expected).max())


def normal_mean(function, mean, covariance, nodes=40):
    """Expectation of ``function`` (2,) -> array over a normal density of two numbers, by Gauss and Hermite."""
    points, weights = hermegauss(nodes)
    weights = weights / weights.sum()
    factor, total = np.linalg.cholesky(covariance), 0.0
    for x, wx in zip(points, weights, strict=True):
        for y, wy in zip(points, weights, strict=True):
            total = total + wx * wy * function(mean + factor @ [x, y])
    return total


@pytest.mark.parametrize(("sd_b", "tolerance"), [(0.05, 0.002), (0.15, 0.035)])
@pytest.mark.parametrize("correlation", [-0.95, 0.0, 0.6])
def test_the_means_over_a_belief(sd_b, tolerance, correlation):
    """Exact in log F_o; of second order in log b: what is left of the mean tension and its derivatives by log F_o."""
    basis, prior = basis_of("trismus"), PRIORS["trismus"]
    sd = np.array([0.3, sd_b])
    block = np.outer(sd, sd) * np.array([[1.0, correlation], [correlation, 1.0]])
    theta, covariance = prior.mean.copy(), np.kron(np.eye(6), block)
    c, twice = expand(basis, theta, covariance)

    def at(two):
        moved = theta.copy()
        moved[:2] = two
        return lagrange(basis, moved)[0].real

    expected = normal_mean(at, theta[:2], block)
    scale = np.abs(expected).max()
    assert np.abs(c[0] - expected).max() < tolerance * scale
    # c is proportional to F_o: its derivatives by log F_o are itself, here without the second order in log b.
    np.testing.assert_allclose(c[0], twice[0, :, 0] + 0.5 * block[1, 1] * twice[0, :, 2], rtol=1e-9)


def test_a_belief_in_F_o_alone_has_its_means_exactly():
    """Log-normal: the mean of F_o is exp(mean + variance / 2)."""
    basis, theta = basis_of("trismus"), PRIORS["trismus"].mean
    c, twice = expand(basis, theta, np.diag(np.tile([0.5**2, 0.0], 6)))
    np.testing.assert_allclose(c, np.exp(0.125) * coefficients(basis, theta), rtol=1e-11)
    np.testing.assert_allclose(twice[:, :, 0], c, rtol=1e-12)


def test_the_derivatives_by_the_parameters(rng):
    """Every column of the filter: against the complex step of the definition, and zeros where there is no c."""
    basis, theta = basis_of("trismus"), jawenv.cohort("trismus").draw_log_parameters(rng)
    by_log = np.full((tension_columns(6), 12), np.nan)
    set_derivatives(basis, theta, by_log)
    expected = twin.derivative(lambda v: lagrange(basis, v).ravel(), theta)
    np.testing.assert_allclose(by_log[: 6 * N_NODES], expected, rtol=0, atol=1e-9 * np.abs(expected).max())
    np.testing.assert_array_equal(by_log[6 * N_NODES :], 0.0)


def test_strains_are_counted_from_the_middle_pose():
    expected = (twin.muscle_lengths(JAW, np.array(MIDDLE_POSE)) - JAW["l_o"]) / JAW["l_o"]
    np.testing.assert_allclose(basis_of("trismus")["centre"], expected, rtol=1e-10)


@pytest.mark.parametrize("name", sorted(known_muscle_sets()))
def test_every_set_of_muscles_has_a_basis_that_sums_to_one(name):
    """At strain 0 the law is F_o exp(b e_0): Lagrange's polynomials sum to 1, and each is 1 at its own node."""
    muscles = known_muscle_sets()[name]
    jaw, prior = build_jaw(muscles), jawenv.cohort("trismus", muscles).prior
    basis = build_basis(jaw, prior)[0]
    for i, nodes in enumerate(basis["nodes"]):
        for k, node in enumerate(nodes):
            theta = prior.mean.copy()
            theta[2 * i : 2 * i + 2] = [0.0, np.log(node)]
            c = coefficients(basis, theta)[i] * np.exp(-node * basis["centre"][i])
            np.testing.assert_allclose(c, np.eye(N_NODES)[k], atol=1e-8)
