"""The nodes of the tension basis narrow as the posterior of the exponents does.

Interpolation in b between nodes that span the prior is accurate for the strains of common maneuvers. At a strain of
0.25 the remainder of five nodes is a hundredth of a tension that has grown tenfold: more than all noise. By then the
posterior of b is narrower, and nodes that span only the posterior leave a remainder smaller by the fifth power.

Information in the old basis is transformed by the same interpolation: the old coefficients are c = L c', with L_kj =
L_k(b'_j) of the old nodes. Information, score and ``by_tension`` are multiplied by L.
"""

from __future__ import annotations

from math import exp, log, sqrt

from jawenv.filter.belief.state import Belief, begin_block
from jawenv.filter.model.basis import ABSCISSAE, Basis, interpolate, polynomial_value, set_coefficients
from jawenv.kernels.compiled import njit

NARROWEST = 0.1  # least sd of log b that the nodes span: below, the basis functions are collinear to rounding
SHRINKS = 0.7  # posterior over spanned sd at which the nodes are narrowed
STRAYS = 1.0  # distance of the mean from the middle, in spanned sds, at which the nodes are moved


@njit
def refocus(belief: Belief, scratch):
    """Move and narrow the nodes of each muscle where the posterior of its exponent has become narrower or moved."""
    basis, mean, covariance = belief.basis, belief.mean, belief.cov
    moved = False
    for i in range(basis.nodes.shape[0]):
        e = 2 * i + 1
        sd = max(sqrt(covariance[e, e]), NARROWEST)
        strayed = abs(mean[e] - log(basis.middle[i]))
        if sd < SHRINKS * basis.width[i] or strayed > STRAYS * basis.width[i]:
            moved = True
            _place_nodes(basis, i, mean[e], min(sd, basis.width[i]), scratch.carried)
            _carry_over(belief, i, scratch)
    if moved:
        begin_block(belief.block)
        set_coefficients(basis, mean, belief.nominal)


@njit
def _place_nodes(basis: Basis, i, middle, width, carried):
    """New nodes for muscle i about exp(``middle``); into ``carried`` (K, K) the matrix L."""
    nodes = basis.nodes.shape[1]
    basis.middle[i], basis.width[i] = exp(middle), width
    for j in range(nodes):
        node = exp(middle + width * ABSCISSAE[j])
        for k in range(nodes):
            carried[k, j], _, _ = polynomial_value(basis.polynomials[i, k], node)
        basis.nodes[i, j] = node
    interpolate(basis.nodes[i], basis.polynomials[i])


@njit
def _carry_over(belief: Belief, i, scratch):
    """Information, score and ``by_tension`` about muscle i's old coefficients become those about its new ones."""
    carried, row = scratch.carried, scratch.row
    first = i * carried.shape[0]
    by_tension, information, score = belief.by_tension, belief.information, belief.score
    for state in range(by_tension.shape[0]):
        _turn_row(by_tension[state], first, carried, row)
    _turn_row(score, first, carried, row)
    size = information.shape[0]
    for a in range(size):
        _turn_row(information[a], first, carried, row)
    for column in range(size):
        _turn_row(information[:, column], first, carried, row)


@njit
def _turn_row(values, first, carried, row):
    """``values`` from ``first`` on, K of them, times L."""
    nodes = carried.shape[0]
    for j in range(nodes):
        row[j] = 0.0
        for k in range(nodes):
            row[j] += values[first + k] * carried[k, j]
    for j in range(nodes):
        values[first + j] = row[j]
