"""Muscle tensions as sums of fixed functions of the strain: what makes the filter's problem linear.

A tension F_o exp(b e) is far from linear in b, and a product in F_o and b; but as a function of the strain e it lies
close to the span of a few exponentials with fixed exponents b_k:

    F_o exp(b e) = sum_k c_k exp(b_k (e - e_0)) + remainder,    c_k = F_o exp(b e_0) L_k(b),

with L_k Lagrange's polynomials through the nodes b_k: interpolation of exp(b (e - e_0)) in b. Its remainder is (b -
b_1)...(b - b_K) (e - e_0)^K / K! times an exponential between. Forces are linear in c, so the information that a record
holds about c needs no linearisation in the parameters. The filter estimates deviations of c from those of the current
mean, whose tension it computes exactly: the remainder cancels as the estimate converges.
"""

from __future__ import annotations

from functools import cache
from math import exp
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from numpy.typing import NDArray

from jawenv.kernels.compiled import njit
from jawenv.kernels.records import Array, record_dtype, record_zeros
from jawenv.mechanics.kinematics import contact_point, rotation

if TYPE_CHECKING:
    from jawenv.anatomy import Prior

# Reference pose of the strains, mid-range: 4 mm of sliding, 8 degrees of opening.
MIDDLE_POSE = (4e-3, 0.0, 0.13, 0.0, 0.0)
# Nodes of Gauss and Hermite's quadrature, of log b in sds.
ABSCISSAE = (-2.8569700138728056, -1.3556261799742657, 0.0, 1.3556261799742657, 2.8569700138728056)
N_NODES = 5  # per muscle: the remainder is 5e-5 of a tension for exponents of 7 that are known within 30 %


class Basis:
    """The basis of each muscle's tension."""

    middle: Annotated[Array, "muscles"]  # exponent about which the nodes lie
    width: Annotated[Array, "muscles"]  # sd of log b that they span
    nodes: Annotated[Array, "muscles", N_NODES]
    centre: Annotated[Array, "muscles"]
    polynomials: Annotated[Array, "muscles", N_NODES, N_NODES]  # L_k's coefficients, lowest power of b first


@cache
def basis_dtype(n_muscles: int) -> np.dtype[np.void]:
    """Dtype of ``Basis``."""
    return record_dtype(Basis, muscles=n_muscles)


def build_basis(jaw: Any, prior: Prior) -> NDArray[np.void]:
    """Basis for the muscles of ``jaw`` and the exponents that ``prior`` holds possible, as an array of one record.

    The nodes interpolate best where the prior's weight is.
    """
    mean, sd = prior.mean.reshape(-1, 2)[:, 1], prior.sd.reshape(-1, 2)[:, 1]
    basis = record_zeros(1, basis_dtype(len(mean)))
    basis["middle"][0], basis["width"][0] = np.exp(mean), sd
    basis["nodes"][0] = np.exp(mean[:, None] + sd[:, None] * np.array(ABSCISSAE))
    basis["centre"][0] = _middle_strains(jaw)
    for muscle in range(len(mean)):
        interpolate(basis["nodes"][0, muscle], basis["polynomials"][0, muscle])
    return basis


def _middle_strains(jaw: Any) -> NDArray[np.float64]:
    """Mean strain of each muscle's lines at ``MIDDLE_POSE``."""
    turned = jaw["insertion"] @ np.array(rotation(MIDDLE_POSE)).T
    lines = jaw["origin"] - np.array(contact_point(jaw, MIDDLE_POSE)) - turned
    strain = np.linalg.norm(lines, axis=1) / jaw["l_o"] - 1.0
    means: NDArray[np.float64] = np.bincount(jaw["muscle"], weights=strain) / np.bincount(jaw["muscle"])
    return means


@njit
def interpolate(nodes, polynomials):
    """Lagrange's polynomials through ``nodes`` (K): row k of ``polynomials`` (K, K), lowest power first."""
    size = nodes.shape[0]
    for k in range(size):
        row = polynomials[k]
        for p in range(size):
            row[p] = 0.0
        row[0] = 1.0
        degree = 0
        for j in range(size):
            if j == k:
                continue
            gap = nodes[k] - nodes[j]
            degree += 1
            for p in range(degree, 0, -1):
                row[p] = (row[p - 1] - nodes[j] * row[p]) / gap
            row[0] *= -nodes[j] / gap


@njit
def polynomial_value(coefficients, b):
    """A polynomial and its first two derivatives at b."""
    value, slope, curvature = 0.0, 0.0, 0.0
    for p in range(coefficients.shape[0] - 1, -1, -1):
        curvature = curvature * b + 2.0 * slope
        slope = slope * b + value
        value = value * b + coefficients[p]
    return value, slope, curvature


@njit
def set_coefficients(basis: Basis, log_parameters, coefficients):
    """C of every muscle, (muscles, K), from the natural-log parameters (2 per muscle)."""
    for i in range(coefficients.shape[0]):
        b = exp(log_parameters[2 * i + 1])
        factor = exp(log_parameters[2 * i] + b * basis.centre[i])
        for k in range(coefficients.shape[1]):
            value, _, _ = polynomial_value(basis.polynomials[i, k], b)
            coefficients[i, k] = factor * value


@njit
def set_derivatives(basis: Basis, log_parameters, by_log):
    """Into ``by_log`` (columns, p) the derivative of c by the natural-log parameters; zero where there is no c."""
    nodes = basis.nodes.shape[1]
    by_log[:, :] = 0.0
    for i in range(basis.nodes.shape[0]):
        b, centre = exp(log_parameters[2 * i + 1]), basis.centre[i]
        factor = exp(log_parameters[2 * i] + b * centre)
        for k in range(nodes):
            value, slope, _ = polynomial_value(basis.polynomials[i, k], b)
            by_log[i * nodes + k, 2 * i] = factor * value
            by_log[i * nodes + k, 2 * i + 1] = factor * b * (centre * value + slope)


@njit
def expand_coefficients(basis: Basis, log_parameters, covariance, coefficients, by_log_twice):
    """Means of c and of its second derivatives by (log F_o, log b), over a normal belief.

    ``coefficients`` (muscles, K) and ``by_log_twice`` (muscles, K, 3; by log F_o twice, by both, by log b twice)
    receive them. As c is proportional to F_o, the first two are also its first derivatives, by log F_o and by log b;
    and weighting a normal density of covariance P by F_o = exp(log F_o) moves its mean by P's first column: exact in
    log F_o, and to second order in log b for the mean of c.
    """
    for i in range(coefficients.shape[0]):
        f, e = 2 * i, 2 * i + 1
        spread = covariance[e, e]
        b, centre = exp(log_parameters[e] + covariance[f, e]), basis.centre[i]
        factor = exp(log_parameters[f] + 0.5 * covariance[f, f] + b * centre)
        for k in range(coefficients.shape[1]):
            value, slope, curvature = polynomial_value(basis.polynomials[i, k], b)
            first = centre * value + slope
            second = centre * (first + slope) + curvature
            by_log_twice[i, k, 0], by_log_twice[i, k, 1] = factor * value, factor * b * first
            by_log_twice[i, k, 2] = factor * b * (first + b * second)
            coefficients[i, k] = factor * value + 0.5 * spread * by_log_twice[i, k, 2]
