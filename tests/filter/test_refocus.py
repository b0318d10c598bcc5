"""Drawing the basis of tensions together: the same likelihood in fewer exponents, and a smaller remainder."""

import numpy as np
import pytest
from recorded import recording
from running import Running

from jawenv.filter.belief.refocus import NARROWEST, SHRINKS, STRAYS, refocus
from jawenv.filter.model.basis import set_coefficients

TICKS = 60


def narrowed(share, off=0.0):
    """A filter after some ticks whose belief about log b is ``share`` as wide as the prior, and off by so many sds."""
    running = Running(recording().records[0]).run(TICKS)
    belief, sd = running.belief, running.record.prior.sd
    belief["cov"] = np.diag((share * sd) ** 2)
    belief["mean"][1::2] += off * sd[1::2]
    set_coefficients(belief["basis"], belief["mean"], belief["nominal"])
    return running


def likelihood(running, theta):
    """Log-likelihood of patients (k, 12) against the belief's mean, and the motion that each would have had (k, 10)."""
    belief, values, motions = running.belief, [], []
    for parameters in theta:
        c = np.empty(belief["nominal"].shape)
        set_coefficients(belief["basis"], parameters, c)
        away = np.append((c - belief["nominal"]).ravel(), [0.01, 0.01])
        values.append(running.score @ away - 0.5 * away @ running.information @ away)
        motions.append(running.by_tension @ away)
    return np.array(values), np.array(motions)


@pytest.mark.parametrize(("share", "off"), [(0.5, 0.0), (0.5, 1.5), (0.05, -1.0), (1.0, 1.3)])
def test_the_likelihood_is_that_of_before(share, off, rng):
    """To rounding, for patients anywhere in the prior: the old polynomials are interpolated without remainder."""
    running = narrowed(share, off)
    prior = running.record.prior
    theta = prior.mean + prior.sd * rng.uniform(-2, 2, (20, 12))
    before, nodes = likelihood(running, theta), running.belief["basis"]["nodes"].copy()
    refocus(running.belief, running.scratch["belief"])
    after = likelihood(running, theta)
    assert np.abs(running.belief["basis"]["nodes"] / nodes - 1.0).max() > 0.1
    for values, others in zip(before, after, strict=True):
        np.testing.assert_allclose(others, values, rtol=0, atol=1e-7 * np.abs(values).max())


def test_the_nodes_span_what_is_believed_and_not_less_than_the_narrowest():
    for share in (0.6, 0.5, 0.1):
        running = narrowed(share, off=0.4)
        refocus(running.belief, running.scratch["belief"])
        basis, mean = running.belief["basis"], running.belief["mean"][1::2]
        width = np.maximum(share * running.record.prior.sd[1::2], NARROWEST)
        np.testing.assert_allclose(basis["width"], width)
        np.testing.assert_allclose(np.log(basis["nodes"][:, 2]), mean)
        np.testing.assert_allclose(np.log(basis["nodes"][:, 4] / basis["nodes"][:, 0]) / width, 2 * 2.857, rtol=1e-3)


@pytest.mark.parametrize(("share", "off"), [(SHRINKS + 0.01, 0.0), (1.0, STRAYS - 0.01), (1.5, 0.0)])
def test_a_belief_that_changed_little_leaves_the_basis_alone(share, off):
    running = narrowed(share, off)
    before = running.belief.copy()
    refocus(running.belief, running.scratch["belief"])
    for name in ("information", "score", "by_tension", "nominal"):
        np.testing.assert_array_equal(running.belief[name], before[name])
    np.testing.assert_array_equal(running.belief["basis"]["nodes"], before["basis"]["nodes"])


def test_tension_far_from_the_middle_is_a_hundred_times_nearer():
    """Strains of 0.25, exponents within the sd of a belief of a third of the prior's width."""
    wrong = []
    running = narrowed(0.33)
    theta = running.belief["mean"] + 0.33 * running.record.prior.sd * np.tile([0.0, 1.0], 6)
    for _ in range(2):
        basis, c = running.belief["basis"], np.empty(running.belief["nominal"].shape)
        set_coefficients(basis, theta, c)
        summed = np.sum(c * np.exp(0.25 * basis["nodes"]), axis=1)
        exact = np.exp(theta[0::2] + np.exp(theta[1::2]) * (basis["centre"] + 0.25))
        wrong.append(np.abs(summed / exact - 1.0).max())
        refocus(running.belief, running.scratch["belief"])
    assert wrong[0] > 1e-3 and wrong[1] < 0.01 * wrong[0], wrong
