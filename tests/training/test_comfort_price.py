"""The learned price of discomfort."""

import numpy as np
import pytest
from point_env import DT_S, EPISODE_STEPS, PointVectorEnv

from training.run.comfort import Multiplier
from training.run.config import ComfortConfig
from training.run.vec_env import NativeVecEnv

CONFIG = ComfortConfig(target_discomfort_s=0.1, initial_multiplier=8.0, rate=0.5, largest_multiplier=1000.0)


def test_price_rises_above_the_target_falls_below_it_and_rests_at_it() -> None:
    multiplier = Multiplier(CONFIG)
    multiplier.update(0.1)
    assert multiplier.value == pytest.approx(8.0)
    multiplier.update(0.2)
    assert multiplier.value == pytest.approx(8.0 * np.exp(0.5))
    multiplier.update(0.0)
    assert multiplier.value == pytest.approx(8.0)


def test_one_terrible_batch_does_not_blow_the_price_up_and_it_has_an_end() -> None:
    multiplier = Multiplier(CONFIG)
    multiplier.update(1e6)
    assert multiplier.value == pytest.approx(8.0 * np.exp(0.5 * 2.0))
    for _ in range(100):
        multiplier.update(1e6)
    assert multiplier.value == 1000.0


def test_reward_is_less_by_price_times_discomfort_also_in_the_last_step() -> None:
    multiplier = Multiplier(CONFIG)
    priced, native = (NativeVecEnv(PointVectorEnv(4, "same_step"), price) for price in (multiplier, None))
    for worlds in (priced, native):
        worlds.seed(3)
        worlds.reset()
    spent, episode_cost = np.zeros(4), 0.0
    for _ in range(EPISODE_STEPS):
        outward = np.tile([0.6, 0.0], (4, 1))
        _, reward, done, infos = priced.step(outward)
        _, plain, _, _ = native.step(outward)
        np.testing.assert_allclose(plain - reward, 8.0 * priced.discomfort_s, atol=1e-6)
        spent += priced.discomfort_s
        for i in np.flatnonzero(done):
            assert spent[i] == pytest.approx(DT_S * infos[i]["episode"]["cost"], rel=1e-5)
            episode_cost += infos[i]["episode"]["cost"]
            spent[i] = 0.0
    assert episode_cost > 0.5
