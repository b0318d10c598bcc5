"""Evaluation of a policy on a fixed cohort."""

import numpy as np
import pytest
from point_env import EPISODE_STEPS, PointVectorEnv

from training.evaluate import evaluate
from training.vec_env import NativeVecEnv


def worlds(start: float = 1.0) -> NativeVecEnv:
    return NativeVecEnv(PointVectorEnv(6, "same_step", start=start))


def to_origin(observation: np.ndarray) -> np.ndarray:
    return -observation[:, :2]


def test_same_seed_is_the_same_cohort_whatever_was_played_before() -> None:
    used = worlds()
    first = evaluate(to_origin, used, seed=20_000)
    again = evaluate(to_origin, used, seed=20_000)
    other = evaluate(lambda observation: np.full((6, 2), 0.3), used, seed=20_000)
    assert first is not None and again is not None and other is not None
    np.testing.assert_array_equal(first.figures["return"], again.figures["return"])
    assert first.mean_return == pytest.approx(1.0 - 0.9**EPISODE_STEPS, abs=1e-6)
    assert first.mean_return > other.mean_return


def test_only_the_first_episode_of_a_world_counts() -> None:
    outcome = evaluate(lambda observation: np.ones((6, 2)), worlds(start=1.45), seed=5)
    assert outcome is not None
    lengths, violation = outcome.figures["length"], outcome.figures["violation"]
    assert lengths.min() == 1.0 and lengths.max() > 10.0
    np.testing.assert_array_equal(violation, lengths < EPISODE_STEPS)
    assert outcome.means()["violation"] == violation.mean()


def test_evaluation_is_given_up_when_asked() -> None:
    asked = iter([False] * 5 + [True])
    assert evaluate(to_origin, worlds(), seed=0, stopped=lambda: next(asked)) is None
