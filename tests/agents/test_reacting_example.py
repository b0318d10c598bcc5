"""The example of an agent that reacts: whom it knows least decides where it goes."""

import numpy as np
import pytest

from examples.least_known import HOLD, LeastKnown
from jawenv.envs.observation import OBSERVATION_LAYOUT, Parts


def seen(parameter: int) -> np.ndarray:
    """An observation (1, size) in which this parameter's sd is the largest."""
    row = np.zeros((1, Parts().size), np.float32)
    row[:, OBSERVATION_LAYOUT["belief_sd"]] = -1.0
    row[0, OBSERVATION_LAYOUT["belief_sd"].start + parameter] = 0.0
    return row


def first_action(parameter: int) -> np.ndarray:
    agent = LeastKnown()
    agent.reset(1)
    return agent.predict(seen(parameter))[0][0]


@pytest.mark.parametrize("parameter", range(0, 6))
def test_sides_are_mirrored(parameter: int) -> None:
    left, right = first_action(parameter), first_action(parameter + 6)
    np.testing.assert_array_equal(left, right * [1, -1, 1, -1])
    assert np.abs(left).max() <= 1.0


def test_it_holds_a_target_before_it_chooses_again() -> None:
    agent = LeastKnown()
    agent.reset(1)
    actions = [agent.predict(seen(parameter))[0][0] for parameter in (0, *[7] * (HOLD - 1), 1)]
    assert len({tuple(action) for action in actions[:HOLD]}) == 1
    assert tuple(actions[0]) != tuple(actions[HOLD])
