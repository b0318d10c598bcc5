"""The pairs that a recording confuses: drawn where they are, and nowhere else."""

import numpy as np
import pytest
from matplotlib.figure import Figure

from eval.patient import pairs
from eval.patient.treatments import Treatment


def treatment(correlations):
    """A belief with sds of 10 %, and correlations of some pairs."""
    cov = 0.01 * np.eye(12)
    for (i, k), value in correlations.items():
        cov[i, k] = cov[k, i] = 0.01 * value
    mean = np.log(np.tile([1.5, 8.0], 6))[None]
    return Treatment(time=np.array([1.0]), mean=mean, cov=cov[None], truth=mean[0], violated=False, misfit=0.1)


def test_confused_pairs_are_drawn_the_most_correlated_first():
    drawn = pairs.confused(treatment({(0, 6): -0.8, (1, 7): 0.95, (2, 3): 0.5}), with_truth=True)
    assert "masseter left b and masseter right b: correlation 0.95" in drawn[0]
    assert "masseter left Fₒ, N and masseter right Fₒ, N: correlation −0.80" in drawn[1]
    assert len(drawn) == 2


def test_a_recording_that_tells_all_apart_has_none():
    assert pairs.confused(treatment({(0, 6): 0.6}), with_truth=False) == []


@pytest.mark.parametrize("correlation", [0.0, 0.9])
def test_the_ellipse_holds_95_percent(correlation):
    """Drawn on axes that keep what they are given, it has the belief's reach."""
    axes = Figure().subplots()
    mean, cov = np.zeros(2), 0.01 * np.array([[1.0, correlation], [correlation, 1.0]])
    pairs._draw(axes, mean, cov)
    drawn = np.log(axes.patches[0].get_xy().T)
    draws = np.random.default_rng(0).multivariate_normal(mean, cov, 20_000)
    distance = np.einsum("ij,jk,ik->i", draws, np.linalg.inv(cov), draws)
    outline = np.einsum("ji,jk,ki->i", drawn, np.linalg.inv(cov), drawn)
    assert np.ptp(outline) < 1e-9 and np.mean(distance < outline[0]) == pytest.approx(0.95, abs=0.01)
