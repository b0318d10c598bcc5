"""Used fractions of the comfort limits by hand, and what they cost."""

import newton_euler as twin
import numpy as np
import pytest

import jawenv
from jawenv.device.comfort import COMFORT_LIMITS, cost_of, limits_dtype, set_general_limits, used_fractions
from jawenv.device.comfort_settings import Comfort

REST_OPENING, RANGE = 0.004, 0.020
PATH = (0.090, -0.003, -0.002)


@pytest.fixture
def limits():
    record = np.zeros(1, dtype=limits_dtype(6))[0]
    record["rest_opening"], record["opening"], record["path"] = REST_OPENING, RANGE, PATH
    record["rest_side"], record["side"], record["fore_aft"] = 0.5e-3, 5e-3, 4e-3
    record["condyle_middle"], record["condyle_half"], record["rest_condyle_side"] = 4e-3, 5e-3, 0.2e-3
    set_general_limits(Comfort().records()[0], record)
    record["tension"] = [10, 20, 30, 40, 50, 5]
    return record


def fractions_of(jaw, log_parameters, limits, q, u, force):
    fractions = np.empty(8)
    muscles = np.exp(log_parameters).reshape(6, 2)
    used_fractions(jaw, muscles, limits, limits["tension"], (tuple(q), tuple(u), (0.0, 0.0)), force, fractions)
    return dict(zip(COMFORT_LIMITS, fractions, strict=True))


def test_fractions_of_a_pose_by_hand(jaw, limits, rng):
    log_parameters = jawenv.cohort("trismus").draw_log_parameters(rng)
    for _ in range(20):
        q = np.array([rng.uniform(0, 9e-3), *rng.uniform(-2e-3, 2e-3, 1), rng.uniform(0.1, 0.4), 0.05, -0.03])
        u = np.concatenate([rng.uniform(-0.05, 0.05, 2), rng.uniform(-1, 1, 3)])
        place, _, velocity, _ = np.split(twin.measurement(jaw, np.concatenate([q, u])), 4)
        above_rest = jaw["mouthpiece"][2] - place[2] - REST_OPENING
        natural = PATH[0] + PATH[1] * (above_rest / RANGE) + PATH[2] * (above_rest / RANGE) ** 2
        expected = {
            "force": 12.0 / 24.0,
            "opening": above_rest / RANGE,
            "side": abs(place[1] - 0.5e-3) / 5e-3,
            "fore_aft": abs(place[0] - natural) / 4e-3,
            "condyle_fore_aft": abs(q[0] - 4e-3) / 5e-3,
            "condyle_side": abs(q[1] - 0.2e-3) / 3e-3,
            "speed": np.linalg.norm(velocity) / 0.040,
            "tension": (twin.tensions(jaw, log_parameters, q) / limits["tension"]).max(),
        }
        assert fractions_of(jaw, log_parameters, limits, q, u, 12.0) == pytest.approx(expected, rel=1e-12)


def test_closing_beyond_rest_is_no_opening(jaw, limits):
    closed = fractions_of(jaw, np.zeros(12), limits, (4e-3, 0, -0.01, 0, 0), np.zeros(5), 0.0)
    assert closed["opening"] == 0.0


@pytest.mark.parametrize("hard", [2.0, 1.3, 1.8, 5.0])
def test_cost_is_0_at_the_soft_and_1_at_the_hard_limit(hard):
    assert cost_of(0.0, hard) == cost_of(1.0, hard) == 0.0
    assert cost_of(hard, hard) == pytest.approx(1.0)
    assert cost_of(0.5 * (1 + hard), hard) == pytest.approx(0.5)
    assert cost_of(2 * hard - 1, hard) == pytest.approx(2.0)
