"""Evaluation of a policy on a fixed cohort."""

from collections.abc import Callable

import numpy as np
import pytest
from point_env import DT_S, EPISODE_STEPS, PointVectorEnv

from training.run.evaluate import Evaluation, evaluate
from training.run.vec_env import NativeVecEnv


def worlds(start: float = 1.0) -> NativeVecEnv:
    return NativeVecEnv(PointVectorEnv(6, "same_step", start=start))


class Policy:
    """Actions by a function of the observation, with noise where they are drawn; remembers where episodes began."""

    def __init__(self, act: Callable[[np.ndarray], np.ndarray]) -> None:
        self.act, self.starts, self.memories = act, [], []

    def predict(self, observation, state=None, episode_start=None, deterministic=True):  # noqa: ANN001, ANN201
        self.starts.append(np.array(episode_start))
        self.memories.append(state)
        action = self.act(observation)
        return action if deterministic else action + 0.5, (len(self.starts),)


def to_origin() -> Policy:
    return Policy(lambda observation: -observation[:, :2])


def test_same_seed_is_the_same_cohort_whatever_was_played_before() -> None:
    used = worlds()
    first = evaluate(to_origin(), used, seed=20_000)
    again = evaluate(to_origin(), used, seed=20_000)
    other = evaluate(Policy(lambda observation: np.full((6, 2), 0.3)), used, seed=20_000)
    assert first is not None and again is not None and other is not None
    np.testing.assert_array_equal(first.figures["return"], again.figures["return"])
    assert first.mean_return == pytest.approx(1.0 - 0.9**EPISODE_STEPS, abs=1e-6)
    assert first.mean_return > other.mean_return


def test_only_the_first_episode_of_a_world_counts() -> None:
    outcome = evaluate(Policy(lambda observation: np.ones((6, 2))), worlds(start=1.45), seed=5)
    assert outcome is not None
    lengths, violation = outcome.figures["length"], outcome.figures["violation"]
    assert lengths.min() == 1.0 and lengths.max() > 10.0
    np.testing.assert_array_equal(violation, lengths < EPISODE_STEPS)
    assert outcome.averages()["violation"] == violation.mean()


def test_evaluation_is_given_up_when_asked() -> None:
    asked = iter([False] * 5 + [True])
    assert evaluate(to_origin(), worlds(), seed=0, stopped=lambda: next(asked)) is None


def test_drawn_actions_and_memory_are_asked_for() -> None:
    policy = to_origin()
    drawn = evaluate(policy, worlds(), seed=20_000, deterministic=False)
    likely = evaluate(to_origin(), worlds(), seed=20_000)
    assert drawn is not None and likely is not None and drawn.mean_return < likely.mean_return - 0.1
    assert policy.starts[0].all() and not policy.starts[1].any()
    assert policy.memories[:3] == [None, (1,), (2,)]


def test_worst_sd_is_that_at_10_s_and_at_the_end_and_its_median_counts() -> None:
    outcome = evaluate(Policy(lambda observation: np.ones((6, 2))), worlds(start=1.0), seed=5)
    assert outcome is not None
    length, figures = outcome.figures["length"], outcome.figures
    np.testing.assert_allclose(figures["worst_sd"], 0.5 / (1.0 + length))
    at_10_s = np.ceil(10.0 / DT_S)
    np.testing.assert_allclose(figures["worst_sd_10s"], 0.5 / (1.0 + np.minimum(length, at_10_s)))
    assert length.min() < at_10_s < length.max()
    assert outcome.averages()["worst_sd"] == np.median(figures["worst_sd"])
    np.testing.assert_allclose(figures["discomfort_s"], 30.0 * figures["cost"] / length)


def test_intervals_hold_the_median_in_95_of_100_cohorts() -> None:
    rng = np.random.default_rng(0)
    held = []
    for _ in range(400):
        ends = Evaluation({"worst_sd": rng.exponential(size=32), "return": np.zeros(32)}).intervals()
        assert set(ends) == {"worst_sd_low", "worst_sd_high"}
        held.append(ends["worst_sd_low"] <= np.log(2.0) <= ends["worst_sd_high"])
    assert 0.94 <= np.mean(held) <= 1.0
