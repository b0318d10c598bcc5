import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from jawenv.ladder import MODELS
from jawenv.metrics import BLOCKED_B, STIFF_F_O_N, diagnose, score, whole_muscles_per_line
from tests.metrics.linear_gaussian import linear_gaussian

TRUTH = np.log([[2.0, 2.0, 2.0, 0.5, 0.5]])
MEAN = np.log([[2.0, 1.05, 0.4, 0.5, 3.0]])
SD = np.full((1, 5), 0.1)


def test_decisions_by_hand():
    made = diagnose(TRUTH, MEAN, SD, threshold=1.0)
    assert made.called_raised.tolist() == [[True, False, False, False, True]]
    assert made.called_normal.tolist() == [[False, False, True, True, False]]
    assert made.sensitivity == pytest.approx(1 / 3)
    assert made.specificity == pytest.approx(1 / 2)
    assert made.undecided == pytest.approx(1 / 5)
    assert made.wrong == pytest.approx(2 / 4)


def test_who_has_learned_nothing_is_sensitive_and_specific_to_nothing():
    made = diagnose(TRUTH, np.zeros((1, 5)), np.full((1, 5), 0.5), threshold=1.0)
    assert (made.sensitivity, made.specificity, made.undecided) == (0.0, 0.0, 1.0)
    assert np.isnan(made.wrong)


def test_a_line_that_stands_for_several_muscles_has_a_threshold_as_much_higher():
    names = {name: model.muscles.parameter_names for name, model in MODELS.items()}
    found = {name: whole_muscles_per_line(parameters) for name, parameters in names.items()}
    assert found == {"hinge": 6.0, "sagittal": 2.0, "sides": 1.0, "jaw": 1.0, "portions": 0.5}
    assert whole_muscles_per_line(["log_F_o/tongue", "log_b/tongue"]) == 1.0
    recording = linear_gaussian(20, parameters=names["hinge"])
    made = score(recording)
    assert made.stiff.raised.tolist() == (recording.truth[:, :1] > np.log(6.0 * STIFF_F_O_N)).tolist()
    assert made.blocked.raised.tolist() == (recording.truth[:, 1:] > np.log(BLOCKED_B)).tolist()


def test_a_share_of_nobody_is_not_a_number():
    assert np.isnan(diagnose(TRUTH, MEAN, SD, threshold=10.0).sensitivity)


@given(st.integers(0, 2**32 - 1), st.floats(0.5, 0.99), st.floats(0.5, 0.99))
def test_asking_for_more_confidence_never_decides_more(seed, one, other):
    rng = np.random.default_rng(seed)
    truth, mean, sd = rng.standard_normal((3, 6)), rng.standard_normal((3, 6)), rng.uniform(0.1, 1.0, (3, 6))
    low, high = sorted((one, other))
    loose, strict = diagnose(truth, mean, sd, 1.0, low), diagnose(truth, mean, sd, 1.0, high)
    assert not (strict.called_raised & ~loose.called_raised).any()
    assert strict.undecided >= loose.undecided
