"""What a reading counts for beside unknown numbers or a disturbance that lasts: less as the jaw stays or returns."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from jawenv.anatomy.knowledge import IMAGED, Knowledge
from jawenv.device.device import Device
from jawenv.envs.configuration import Configuration
from jawenv.envs.simulation import Simulation
from jawenv.filter.readings.model_error import cell_of, reading_weight
from jawenv.kernels.compiled import njit

DT = 0.01


@njit
def weigh(jaw, belief, settings):
    return reading_weight(jaw, belief, settings)


@njit
def cell(jaw, motion, n_cells):
    return cell_of(jaw, motion, n_cells)


def parts(knowledge, force_sensor="cell", **device):
    """Jaw, belief and settings of one whose episode has not begun."""
    made = Simulation(1, Configuration(knowledge=knowledge, device=Device(**device), force_sensor=force_sensor))
    belief = made.worlds["known"]["belief"][0].copy()
    belief["motion"] = 0.0
    belief["trend"] = [10.0, 0.0, 0.0, 0.0, 0.0, 0.0]
    belief["dwell"]["visits"] = belief["dwell"]["drift_rates"] = 0.0
    return made._jaw, belief, made.settings[0]["filter"]


@pytest.fixture(scope="module", params=["imaged", "a disturbance that lasts", "motors"])
def doubting(request):
    if request.param == "motors":
        return parts(Knowledge(), force_sensor="motors")
    return parts(IMAGED) if request.param == "imaged" else parts(Knowledge(), unmodelled_time_s=0.5)


def weights_along(openings_mm, jaw, belief, settings):
    """Weight of each tick at these openings, by the turn about the condyles."""
    belief, before, weights = belief.copy(), openings_mm[0], []
    for opening in openings_mm:
        belief["motion"][2] = opening * 1e-3 / jaw["mouthpiece"][0]
        belief["motion"][7] = (opening - before) * 1e-3 / jaw["mouthpiece"][0] / DT
        before = opening
        weights.append(weigh(jaw, belief, settings))
    return np.array(weights)


def test_a_path_driven_again_counts_for_less_and_a_new_one_does_not(doubting):
    """Up and down at 10 mm/s ten times, the same way or each time 12 mm further."""
    way = np.concatenate([np.arange(0.0, 10.0, 0.1), np.arange(10.0, 0.0, -0.1)])
    again, further = (
        weights_along(np.concatenate([way + k * far for k in range(10)]), *doubting).reshape(10, -1).sum(axis=1)
        for far in (0.0, 12.0)
    )
    assert again[0] == further[0]
    assert again[-1] < 0.8 * further[-1]
    assert further[-1] > 0.9 * further[1]


def test_all_visits_of_a_pose_count(doubting):
    """The last of n ticks at a pose counts for r / (r + n s)."""
    comes = np.tile(np.repeat([0.0, 20.0], 100), 10)
    at_pose = weights_along(comes, *doubting)[comes == 0.0]
    np.testing.assert_allclose((1.0 / at_pose[-1] - 1.0) / (1.0 / at_pose[499] - 1.0), 2.0, rtol=1e-9)


@pytest.mark.parametrize("knowledge", [Knowledge(), Knowledge(inertia=0.1)])
def test_where_muscles_alone_are_unknown_a_quarter_of_a_minute_at_a_pose_counts_whole(knowledge):
    jaw, belief, settings = parts(knowledge)
    weights = [weigh(jaw, belief, settings) for _ in range(2000)]
    assert set(weights[:1500]) == {1.0}
    assert weights[1999] < weights[1700] < 1.0


def test_a_jaw_at_the_edge_of_a_cell_weighs_both_sides_alike():
    """Else noise in one direction counts for more than in the other."""
    jaw, belief, settings = parts(Knowledge())
    openings = np.where(np.random.default_rng(0).random(6000) < 0.9, 10.4, 10.6)
    weights = weights_along(openings, jaw, belief, settings)[5000:]
    aside = openings[5000:] == 10.6
    np.testing.assert_allclose(weights[aside].mean(), weights[~aside].mean(), rtol=0.05)
    assert weights.max() < 0.5


@given(st.lists(st.floats(-1e3, 1e3) | st.just(float("nan")), min_size=10, max_size=10))
def test_any_motion_has_a_cell(motion):
    jaw = Simulation(1, Configuration())._jaw
    number = cell(jaw, np.array(motion), 1024)
    assert 0 <= number < 1024


def test_poses_within_a_millimetre_share_a_cell_and_others_hardly_ever(doubting, rng):
    jaw = doubting[0]
    scale = np.array([1.0, 1.0, *[jaw["mouthpiece"][0]] * 3])
    cells = rng.integers(-20, 20, (400, 5))
    centres = cells * 1e-3 / scale
    near = centres + rng.uniform(-0.4e-3, 0.4e-3, (400, 5)) / scale
    pad = np.zeros(5)
    numbers = [cell(jaw, np.concatenate([at, pad]), 1 << 40) for at in centres]
    assert numbers == [cell(jaw, np.concatenate([at, pad]), 1 << 40) for at in near]
    assert len(set(numbers)) == len({tuple(at) for at in cells.tolist()})
