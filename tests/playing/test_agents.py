"""The form that all agents answer in, and the memory that some have of each world."""

import numpy as np
import pytest

from jawenv.base.errors import InputError
from jawenv.playing.agents import BatchAgent, Memory, Remembering


class Counting(Remembering):
    """Says how many steps each world has played, and all together."""

    name = "counting"
    _remembered = (np.int64, np.dtype([("deep", float, 2)]))

    def _decide(self, rows, memory, starts, deterministic):
        step, deep = memory.of_worlds
        deep["deep"] += 1.0
        together = (memory.shared or 0) + 1
        action = np.stack([step, deep["deep"][:, 1], np.full(len(rows), together), rows[:, 0]], axis=1)
        return action.astype(np.float32), Memory((step + 1, deep), together)


def rows(worlds: int) -> np.ndarray:
    return np.arange(3 * worlds, dtype=np.float32).reshape(worlds, 3)


def test_one_world_is_answered_without_a_leading_axis() -> None:
    many, one = Counting().predict(rows(2))[0], Counting().predict(rows(2)[1])[0]
    assert many.shape == (2, 4) and one.shape == (4,)
    np.testing.assert_array_equal(one, many[1])
    with pytest.raises(InputError):
        BatchAgent().predict(np.zeros((1, 1, 3), np.float32))


def test_a_world_that_begins_is_forgotten_alone_and_all_together_with_what_they_share() -> None:
    agent = Counting()
    for _ in range(3):
        _, state = agent.predict(rows(2))
    np.testing.assert_array_equal(agent.predict(rows(2), state, [True, False])[0][:, :3], [[0, 1, 4], [3, 4, 4]])
    np.testing.assert_array_equal(agent.predict(rows(2), state)[0][:, :3], [[3, 4, 4]] * 2)  # not changed in place
    np.testing.assert_array_equal(agent.predict(rows(2), tuple(state))[0][:, :3], [[3, 4, 4]] * 2)
    np.testing.assert_array_equal(agent.predict(rows(2), None, [True, True])[0][:, :3], [[0, 1, 1]] * 2)
    agent.reset(2)
    np.testing.assert_array_equal(agent.predict(rows(2))[0][:, :3], [[0, 1, 1]] * 2)


def test_another_number_of_worlds_is_refused_until_all_begin() -> None:
    agent = Counting()
    agent.predict(rows(2))
    with pytest.raises(InputError):
        agent.predict(rows(3))
    assert agent.predict(rows(3), None, np.ones(3, bool))[0].shape == (3, 4)
