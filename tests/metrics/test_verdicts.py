"""Words and probabilities of verdicts, against sampling and by hand."""

import numpy as np
import pytest

from jawenv.metrics import BLOCKED_B, STIFF_F_O_N
from jawenv.metrics.verdicts import BLOCKED, BOTH, NORMAL, NOT_MEASURED, STIFF, UNKNOWN, truly, verdict


def said(F_o, b, sd=0.05, correlation=0.0):
    cov = np.array([[1.0, correlation], [correlation, 1.0]]) * sd**2
    return verdict(np.log([F_o, b]), cov)


@pytest.mark.parametrize(
    ("F_o", "b", "word"),
    [(0.7, 7.0, NORMAL), (4.0, 10.0, STIFF), (0.8, 18.0, BLOCKED), (4.0, 18.0, BOTH), (1.7, 7.0, UNKNOWN)],
)
def test_good_knowledge_finds_the_word(F_o, b, word):
    found = said(F_o, b)
    assert found.word == word
    assert (found.probability > 0.999) == (word != UNKNOWN)
    if word != UNKNOWN:
        assert truly(np.log([F_o, b])) == word == found.likeliest


def test_a_wide_belief_decides_nothing_and_says_what_is_likeliest():
    found = said(2.0, 7.0, sd=0.6)
    assert (found.word, found.likeliest) == (UNKNOWN, STIFF)
    assert 0.3 < found.probability < 0.95


def test_a_verdict_is_the_datas_or_none():
    """A prior of stiff patients says nothing; a parameter that the data tell says its part."""
    mean, prior = np.log([4.0, 9.0]), np.array([0.35, 0.25])
    assert verdict(mean, np.diag(prior**2)).word == STIFF
    for shares, word in (
        ((1.0, 1.0), NOT_MEASURED),
        ((0.6, 0.1), NOT_MEASURED),
        ((0.4, 1.0), STIFF),
        ((0.1, 0.1), STIFF),
    ):
        assert verdict(mean, np.diag((np.array(shares) * prior) ** 2), prior).word == word
    soft = np.log([0.7, 7.0])
    assert verdict(soft, np.diag((np.array([0.1, 0.6]) * prior) ** 2), prior).word == NOT_MEASURED
    assert verdict(soft, np.diag((np.array([0.1, 0.1]) * prior) ** 2), prior).word == NORMAL


def test_what_is_not_known_of_a_stiff_muscle_is_said():
    found = verdict(np.log([4.0, 13.0]), np.diag([0.05, 0.3]) ** 2)
    assert (found.word, found.open_question) == (STIFF, BLOCKED)
    assert said(4.0, 10.0).open_question == ""
    assert verdict(np.log([1.5, 18.0]), np.diag([0.5, 0.05]) ** 2).open_question == STIFF


@pytest.mark.parametrize("correlation", [-0.9, 0.0, 0.9])
def test_probabilities_are_those_of_samples(correlation, rng):
    found = said(1.5, 12.5, sd=0.2, correlation=correlation)
    cov = np.array([[1.0, correlation], [correlation, 1.0]]) * 0.04
    drawn = np.exp(rng.multivariate_normal(np.log([1.5, 12.5]), cov, size=200_000))
    stiff, blocked = drawn[:, 0] > STIFF_F_O_N, drawn[:, 1] > BLOCKED_B
    assert found.stiff == pytest.approx(stiff.mean(), abs=0.005)
    assert found.blocked == pytest.approx(blocked.mean(), abs=0.005)
    assert (found.word, found.likeliest) == (UNKNOWN, NORMAL)
    assert found.probability == pytest.approx((~stiff & ~blocked).mean(), abs=0.005)
