"""What a policy is shown: its own parts of an observation, and the belief beside its own prior."""

import numpy as np
import pytest

from jawenv.anatomy import cohort
from jawenv.base.errors import InputError
from jawenv.envs.observation import OBSERVATION_LAYOUT, observation_size
from jawenv.playing.policies.inputs import OwnPrior, fitted


def observation_of(mean, sd, prior):
    rows = np.zeros((1, 63), dtype=np.float32)
    rows[0, OBSERVATION_LAYOUT["belief_mean"]] = (mean - prior.mean) / prior.sd
    rows[0, OBSERVATION_LAYOUT["belief_sd"]] = np.log10(sd / prior.sd)
    return rows


def test_one_belief_is_shown_alike_under_two_priors():
    own, other = cohort("anyone").prior, cohort("severe").prior
    mean, sd = other.mean + 0.3, 0.2 * other.sd
    shown = OwnPrior(own)
    shown.take(other)
    np.testing.assert_allclose(shown(observation_of(mean, sd, other)), observation_of(mean, sd, own), atol=1e-5)
    shown.take(own)
    rows = observation_of(mean, sd, own)
    assert shown(rows) is rows


def test_ends_that_a_policy_does_not_know_are_left_out_and_nothing_is_spent_where_no_budget_is_kept():
    rows = np.arange(2 * 70, dtype=np.float32).reshape(2, 70)
    np.testing.assert_array_equal(fitted(rows, 63, "p"), rows[:, :63])
    with_budget = fitted(rows[:, :63], observation_size(budget=True), "p")
    np.testing.assert_array_equal(with_budget[:, :63], rows[:, :63])
    assert (with_budget[:, 63] == 0.0).all()
    assert fitted(rows, 70, "p") is rows


def test_what_is_spent_is_shown_to_a_policy_that_knows_no_correlations_and_they_to_one_that_knows_no_budget():
    rows = np.arange(2 * 130, dtype=np.float32).reshape(2, 130)
    np.testing.assert_array_equal(fitted(rows, 64, "p"), rows[:, :64])
    np.testing.assert_array_equal(fitted(rows, 129, "p"), np.delete(rows, 63, axis=1))


@pytest.mark.parametrize(("given", "known"), [(63, 70), (51, 63), (62, 63), (63, 75), (64, 130), (129, 136)])
def test_other_observations_are_refused(given, known):
    with pytest.raises(InputError, match=f"trained on observations of {known} values, got {given}"):
        fitted(np.zeros((1, given), dtype=np.float32), known, "p")
