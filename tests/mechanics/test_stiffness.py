"""The bound on how fast a jaw swings, and the steps that follow from it."""

import numpy as np
import pytest

import jawenv
from jawenv.estimation.ekf import filter_scratch_dtype
from jawenv.mechanics.dynamics import linearise_acceleration
from jawenv.mechanics.stiffness import LARGEST_PHASE, MOST_PARTS, fastest_rate, parts_needed

STILL, NOTHING = (0.0,) * 5, (0.0,) * 6


@pytest.mark.parametrize("cohort", ["trismus", "severe", "blockage", "wide"])
def test_no_mode_is_faster_than_the_bound(jaw, rng, cohort):
    """Off the stops; the eigenvalues are those of the exact linearisation."""
    jaw["tooth_stiffness"] = jaw["condyle_stiffness"] = jaw["gravity"] = 0.0
    scratch = np.zeros(1, dtype=filter_scratch_dtype())[0]
    shares = []
    for _ in range(100):
        muscles = np.exp(jawenv.cohort(cohort).draw_log_parameters(rng)).reshape(6, 2)
        q = (rng.uniform(0, 6e-3), rng.uniform(-2e-3, 2e-3), rng.uniform(0, 0.3), *rng.uniform(-0.05, 0.05, 2))
        fields = [scratch[name] for name in ("by_state", "by_input", "stiffness", "pulls")]
        linearise_acceleration(jaw, muscles, q, STILL, NOTHING, *fields)
        fastest = np.sqrt(np.abs(np.linalg.eigvals(scratch["by_state"][:, :5])).max())
        shares.append(fastest / fastest_rate(jaw, muscles, q))
    assert 0.3 < np.median(shares) and max(shares) < 1.1, "a bound, and not a useless one"


def test_steps_are_halved_until_they_are_short_enough():
    assert parts_needed(LARGEST_PHASE / 0.01, 0.01, 1) == 1
    assert parts_needed(1.01 * LARGEST_PHASE / 0.01, 0.01, 1) == 2
    assert parts_needed(5.0 * LARGEST_PHASE / 0.01, 0.01, 2) == 8
    assert parts_needed(1e9, 0.01, 1) == MOST_PARTS
    assert parts_needed(0.0, 0.01, 5) == 5
