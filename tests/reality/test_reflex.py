"""The stretch reflex against its closed form: latency, gain for steady and for quick stretches, and slope."""

import newton_euler as twin
import numpy as np
import pytest
from reality_states import REST, STILL, TICK, Tissue, drawn_muscles, tensions

OPENING = (0.01, -0.002, 0.02, 0.5, -0.03)  # x', y', omega: all muscles lengthen
GAIN, LAG = 0.8, 0.04


def tension_rates(jaw, muscles, q, u):
    """Independent: (6,) rate of each tension, by complex step along the motion."""
    rates = np.concatenate([u[:2], np.linalg.solve(twin.angle_axes(np.asarray(q)), u[2:])])
    moved = np.asarray(q) + 1j * twin.IMAGINARY_STEP * rates
    return twin.tensions(jaw, np.log(muscles).ravel(), moved).imag / twin.IMAGINARY_STEP


@pytest.mark.parametrize(("latency_ms", "ticks"), [(0, 1), (9, 1), (14, 1), (16, 2), (42, 4), (80, 8)])
def test_a_steady_stretch_is_answered_after_the_latency_and_with_the_lag(jaw, rng, latency_ms, ticks):
    muscles = drawn_muscles(rng)
    tissue = Tissue(jaw, muscles, reflex_gain=GAIN, reflex_latency_ms=latency_ms, reflex_lag_ms=1e3 * LAG)
    rates, passive = tension_rates(jaw, muscles, REST, np.array(OPENING)), tensions(jaw, muscles, REST)
    assert np.all(rates > 0.0)
    for tick in range(120):
        since = max(tick + 1 - ticks, 0) * TICK  # at the end of the tick for which the tension is held
        expected = GAIN * LAG * rates * (1.0 - np.exp(-since / LAG))
        np.testing.assert_allclose(tissue.tick(REST, OPENING) - passive, expected, rtol=1e-9, atol=1e-12)


def test_a_quick_stretch_is_met_with_the_gain_times_its_passive_stiffness_and_then_let_go(jaw, rng):
    muscles = drawn_muscles(rng)
    tissue = Tissue(jaw, muscles, reflex_gain=GAIN, reflex_lag_ms=1000.0)
    rates, passive = tension_rates(jaw, muscles, REST, np.array(OPENING)), tensions(jaw, muscles, REST)
    tissue.tick(REST, OPENING)
    added = tissue.tick(REST) - passive
    np.testing.assert_allclose(added, GAIN * rates * TICK, rtol=0.01)  # a tick is 1 % of the lag
    for _ in range(100):
        left = tissue.tick(REST) - passive
    np.testing.assert_allclose(left, added * np.exp(-1.0), rtol=1e-9)


def test_shortening_excites_nothing(jaw, rng):
    muscles = drawn_muscles(rng)
    tissue = Tissue(jaw, muscles, reflex_gain=GAIN)
    for _ in range(20):
        tissue.tick(REST, [-v for v in OPENING])
    assert tissue.effective.tobytes() == muscles.tobytes()


def test_active_tension_neither_stiffens_nor_follows_the_length(jaw, rng):
    muscles = drawn_muscles(rng)
    tissue = Tissue(jaw, muscles, reflex_gain=10.0, reflex_lag_ms=1000.0)
    for _ in range(50):
        active = tissue.tick(REST, OPENING) - tensions(jaw, muscles, REST)
    assert np.all(active > tensions(jaw, muscles, REST))
    moved = np.add(REST, 1e-6)
    change = tensions(jaw, tissue.effective, moved) - tensions(jaw, tissue.effective, REST)
    passive = tensions(jaw, muscles, moved) - tensions(jaw, muscles, REST)
    np.testing.assert_allclose(change, passive, rtol=1e-4)


def test_creep_and_reflex_act_together(jaw, rng):
    """What excites is the rate of the tension that creep has left."""
    muscles = drawn_muscles(rng)
    options = {"creep_share": 0.5, "creep_time_s": 1e3}
    both, creep = (Tissue(jaw, muscles, reflex_gain=gain, **options) for gain in (GAIN, 0.0))
    both.state["creep"] = creep.state["creep"] = 0.1
    for _ in range(60):
        added = both.tick(REST, OPENING) - creep.tick(REST, OPENING)
    rates = tension_rates(jaw, creep.effective, REST, np.array(OPENING))
    np.testing.assert_allclose(added, GAIN * LAG * rates, rtol=1e-4)


def test_a_lift_stretches_what_it_raises(jaw, rng):
    """A lift shifts the mandible, and its rate moves it: an insertion moves by ``up`` and ``rate`` along z."""
    muscles, up, rate = drawn_muscles(rng), 0.4e-3, 3e-3
    tissue = Tissue(jaw, muscles, reflex_gain=GAIN)
    R, r = twin.rotation(np.array(REST)), twin.contact(jaw, REST) + [0, 0, up]
    lines = jaw["origin"] - r - jaw["insertion"] @ R.T
    lengths = np.linalg.norm(lines, axis=1)
    passive = muscles[:, 0] * np.exp(muscles[:, 1] * (lengths / jaw["l_o"] - 1.0))
    # The rate is turned to stretch the lines: all insertions sink.
    rises = passive * muscles[:, 1] / jaw["l_o"] * lines[:, 2] / lengths * rate
    for _ in range(120):
        tissue.tick(REST, STILL, (up, -rate))
    np.testing.assert_allclose(tissue.state["activation"], GAIN * LAG * rises, rtol=1e-9)
    strain = lengths / jaw["l_o"] - 1.0
    held = tissue.effective[:, 0] * np.exp(tissue.effective[:, 1] * strain)
    np.testing.assert_allclose(held, passive + GAIN * LAG * rises, rtol=1e-9)
