"""A residual on a maneuver: zero is the maneuver itself, and agent and training agree."""

from pathlib import Path

import numpy as np

from jawenv.envs.observation import Parts
from jawenv.playing.maneuvers import Maneuver
from jawenv.playing.policies.residual import N_FEATURES, BaseTargets, ResidualPolicy

NAME = "opening_with_swings_and_fore_aft"
BASE = BaseTargets(Maneuver.named(NAME), scale=0.5)


class Constant:
    """A policy that always answers the same, with a memory that counts."""

    name = "constant"

    def __init__(self, value: float = 0.0) -> None:
        self.value, self.seen = value, np.zeros(0)

    def reset(self, num_envs: int, seed: int | None = None) -> None: ...

    def predict(self, observation, state=None, episode_start=None, deterministic=True):  # noqa: ANN001, ANN201
        self.seen = observation
        counted = np.zeros(len(observation)) if state is None else state[0]
        return np.full((len(observation), 4), self.value, np.float32), (counted + 1,)


def agent(value: float = 0.0) -> ResidualPolicy:
    return ResidualPolicy(Constant(value), BASE, Path("run"), Parts())


def observations(worlds: int) -> np.ndarray:
    return np.random.default_rng(1).uniform(-1, 1, (worlds, Parts().size)).astype(np.float32)


def test_features_are_the_targets_of_three_steps_ahead() -> None:
    step = np.array([0, 7, 0, 40])
    features = BASE.features(step)
    assert features.shape == (4, N_FEATURES) and features.dtype == np.float32
    for ahead in range(3):
        expected = BASE.maneuver.targets((step + 1 + ahead) / 5.0).value
        np.testing.assert_allclose(features[:, 4 * ahead : 4 * ahead + 4], expected, atol=1e-6)


def test_residual_moves_each_channel_by_its_scale_and_stops_at_the_limits() -> None:
    step = np.array([30])
    targets = BASE.maneuver.targets(np.array([31 / 5.0])).value
    small = BASE.actions(step, np.full((1, 4), 0.01))
    width = 1.0 - np.array([0.0, -1.0, -1.0, -1.0])
    np.testing.assert_allclose(small - BASE.actions(step, np.zeros((1, 4))), 2 * 0.005 / width[None], atol=1e-6)
    assert abs(targets).max() < 1.0
    np.testing.assert_array_equal(BaseTargets(BASE.maneuver, 2.0).actions(step, np.full((1, 4), -1.0)), -1.0)


def test_residuals_of_actions_are_what_gives_these_actions() -> None:
    base = BaseTargets(Maneuver.named("opening_with_swings"), 0.4)
    step, residual = np.arange(8), np.random.default_rng(0).uniform(-0.2, 0.2, (8, 4))
    residual[:, 0] = abs(residual[:, 0])  # the opening begins at its lowest
    np.testing.assert_allclose(base.residuals(step, base.actions(step, residual)), residual, atol=1e-6)
    assert (base.residuals(step, np.ones((8, 4))) == 1.0).any()  # as far as a correction reaches


def test_a_world_that_starts_anew_is_at_step_0_and_the_old_state_stays_as_it_was() -> None:
    policy, seen = agent(), observations(2)
    _, state = policy.predict(seen)
    _, state = policy.predict(seen, state)
    assert state is not None
    before = state.of_worlds[0].copy()
    _, after = policy.predict(seen, state, np.array([False, True]))
    assert after is not None
    np.testing.assert_array_equal(after.of_worlds[0], [3, 1])
    np.testing.assert_array_equal(state.of_worlds[0], before)
    np.testing.assert_array_equal(policy.agent.seen[:, Parts().size :], BASE.features(np.array([2, 0])))
