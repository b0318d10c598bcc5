"""Target signals: values, exact rates, continuity, and what a wrong description is told."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import TypeAdapter, ValidationError
from scipy.signal import chirp as scipy_chirp

from jawenv.playing.maneuvers.signals import AnySignal, Harmonics, Signal

SIGNAL: TypeAdapter[Signal] = TypeAdapter(AnySignal)

SMOOTH = {
    "keyframes": {
        "kind": "keyframes",
        "points": [{"t_s": 1, "value": 0}, {"t_s": 4, "value": 0.8}, {"t_s": 6, "value": -0.2}],
    },
    "repeated": {
        "kind": "keyframes",
        "repeat": True,
        "points": [{"t_s": 0, "value": 0.1}, {"t_s": 2, "value": 0.8}, {"t_s": 5, "value": 0.1}],
    },
    "harmonics": {
        "kind": "harmonics",
        "offset": 0.3,
        "harmonics": [{"amplitude": 0.2, "period_s": 4, "phase_deg": 30}, {"amplitude": 0.1, "frequency_hz": 0.7}],
    },
    "chirp": {"kind": "chirp", "amplitude": 0.4, "from_hz": 0.1, "to_hz": 1.1, "duration_s": 7, "offset": 0.2},
    "prbs": {"kind": "prbs", "amplitude": 0.3, "interval_s": 1.0, "switch_s": 0.4, "register_bits": 4, "offset": 0.5},
}


@pytest.mark.parametrize("name", SMOOTH)
def test_rate_is_the_derivative_of_the_value(name: str) -> None:
    signal = SIGNAL.validate_python(SMOOTH[name])
    t = np.linspace(0.0, 40.0, 4001) + 1.234e-3
    h = 1e-5
    numeric = (signal.value(t + h) - signal.value(t - h)) / (2 * h)
    np.testing.assert_allclose(signal.rate(t), numeric, atol=1e-6)


def test_keyframes_pass_their_points_at_rest_and_hold_the_ends() -> None:
    signal = SIGNAL.validate_python(SMOOTH["keyframes"])
    t = np.array([1.0, 4.0, 6.0])
    np.testing.assert_allclose(signal.value(t), [0.0, 0.8, -0.2], atol=1e-12)
    np.testing.assert_allclose(signal.rate(t), 0.0, atol=1e-9)
    np.testing.assert_allclose(signal.value([0.0, 100.0]), [0.0, -0.2])
    np.testing.assert_allclose(signal.rate([0.0, 100.0]), 0.0)


def test_smooth_keyframes_follow_the_minimum_jerk_polynomial() -> None:
    signal = SIGNAL.validate_python(SMOOTH["keyframes"])
    s = np.linspace(0.0, 1.0, 21)
    np.testing.assert_allclose(signal.value(1 + 3 * s), 0.8 * (10 * s**3 - 15 * s**4 + 6 * s**5), atol=1e-12)


def test_linear_keyframes_are_straight() -> None:
    signal = SIGNAL.validate_python({**SMOOTH["keyframes"], "interpolation": "linear"})
    np.testing.assert_allclose(signal.value([2.5, 5.0]), [0.4, 0.3])
    np.testing.assert_allclose(signal.rate([2.5, 5.0]), [0.8 / 3, -0.5])


def test_repeated_keyframes_are_periodic() -> None:
    signal = SIGNAL.validate_python(SMOOTH["repeated"])
    t = np.linspace(0.0, 5.0, 101)
    np.testing.assert_allclose(signal.value(t + 15.0), signal.value(t), atol=1e-12)


@given(
    amplitude=st.floats(-1, 1),
    period_s=st.floats(0.2, 30),
    phase_deg=st.floats(-360, 360),
    offset=st.floats(-1, 1),
    t=st.floats(0, 300),
)
def test_a_period_and_its_frequency_mean_the_same(
    amplitude: float, period_s: float, phase_deg: float, offset: float, t: float
) -> None:
    def build(**speed: float) -> Harmonics:
        harmonic = {"amplitude": amplitude, "phase_deg": phase_deg, **speed}
        return Harmonics.model_validate({"kind": "harmonics", "offset": offset, "harmonics": [harmonic]})

    expected = offset + amplitude * np.sin(2 * np.pi * t / period_s + np.deg2rad(phase_deg))
    assert float(build(period_s=period_s).value(t)) == pytest.approx(expected, abs=1e-9)
    assert float(build(frequency_hz=1 / period_s).value(t)) == pytest.approx(expected, abs=1e-9)


def test_first_sweep_of_the_chirp_is_scipys() -> None:
    signal = SIGNAL.validate_python(SMOOTH["chirp"])
    t = np.linspace(0.0, 7.0, 500)
    reference = scipy_chirp(t, f0=0.1, t1=7.0, f1=1.1, phi=-90.0)
    np.testing.assert_allclose(signal.value(t), 0.2 + 0.4 * reference, atol=1e-12)


def test_chirp_turns_without_a_jump() -> None:
    signal = SIGNAL.validate_python(SMOOTH["chirp"])
    for turn in (7.0, 14.0, 21.0):
        before, after = turn - 1e-9, turn + 1e-9
        assert float(signal.value(before)) == pytest.approx(float(signal.value(after)), abs=1e-7)
        assert float(signal.rate(before)) == pytest.approx(float(signal.rate(after)), abs=1e-6)


def test_prbs_visits_both_levels_evenly_and_repeats() -> None:
    signal = SIGNAL.validate_python(SMOOTH["prbs"])
    held = np.arange(15) + 0.7
    levels = signal.value(held)
    np.testing.assert_allclose(np.sort(levels), [0.2] * 7 + [0.8] * 8)
    np.testing.assert_allclose(signal.value(held + 30.0), levels)
    np.testing.assert_allclose(signal.rate(held), 0.0, atol=1e-9)


def test_prbs_seed_shifts_the_sequence() -> None:
    first = SIGNAL.validate_python(SMOOTH["prbs"])
    other = SIGNAL.validate_python({**SMOOTH["prbs"], "seed": 9})
    held = np.arange(15) + 0.7
    assert not np.allclose(first.value(held), other.value(held))


HZ = st.floats(0.01, 10.0)
SINE = st.fixed_dictionaries({"amplitude": st.floats(-0.4, 0.4), "frequency_hz": HZ, "phase_deg": st.floats(-360, 360)})


@given(
    description=st.one_of(
        st.fixed_dictionaries({"kind": st.just("harmonics"), "harmonics": st.lists(SINE, min_size=1, max_size=4)}),
        st.fixed_dictionaries(
            {
                "kind": st.just("chirp"),
                "amplitude": st.floats(-1, 1),
                "from_hz": HZ,
                "to_hz": HZ,
                "duration_s": st.floats(0.1, 100),
            }
        ),
        st.builds(
            lambda values, smooth: {
                "kind": "keyframes",
                "interpolation": "smooth" if smooth else "linear",
                "points": [{"t_s": 0.7 * k, "value": value} for k, value in enumerate(values)],
            },
            st.lists(st.floats(-1, 1), min_size=1, max_size=6),
            st.booleans(),
        ),
        st.builds(lambda switch_s: SMOOTH["prbs"] | {"switch_s": switch_s}, st.floats(0.05, 1.0)),
    ),
    start=st.floats(0, 3500),
)
def test_no_value_and_no_rate_lies_outside_of_the_bounds(description: dict, start: float) -> None:
    signal = SIGNAL.validate_python(description)
    t = start + np.linspace(0.0, 20.0, 2001)
    low, high = signal.bounds()
    room = 0.02 * (high - low) + 1e-9
    assert low - room <= signal.value(t).min() and signal.value(t).max() <= high + room
    assert np.abs(signal.rate(t)).max() <= signal.fastest() * (1 + 0.02) + 1e-9


def test_the_bounds_of_a_multisine_are_those_of_a_fine_grid() -> None:
    sines = [{"amplitude": 0.3 / k, "period_s": 12 / k, "phase_deg": 50 * k * k} for k in (1, 2, 3, 5)]
    signal = SIGNAL.validate_python({"kind": "harmonics", "offset": 0.1, "harmonics": sines})
    t = np.linspace(0.0, 12.0, 200_001)
    expected = [signal.value(t).min(), signal.value(t).max()]
    np.testing.assert_allclose(signal.bounds(), expected, atol=1e-3)
    assert signal.fastest() == pytest.approx(np.abs(signal.rate(t)).max(), rel=1e-3)
    assert signal.bounds()[1] < 0.1 + 0.9 * sum(sine["amplitude"] for sine in sines)


def test_two_sines_that_meet_after_half_an_hour() -> None:
    """Their sum is small for minutes, and twice as large as any of them in the end."""
    sines = [{"amplitude": 0.6, "frequency_hz": 0.5}, {"amplitude": -0.6, "frequency_hz": 0.5 + 1 / 3600}]
    low, high = SIGNAL.validate_python({"kind": "harmonics", "harmonics": sines}).bounds()
    assert high == pytest.approx(1.2, abs=0.01) and low == pytest.approx(-1.2, abs=0.01)


def test_bounds_of_the_largest_sum_take_no_time() -> None:
    sines = [{"amplitude": 1 / 32, "frequency_hz": 10 - 0.001 * k} for k in range(32)]
    signal = SIGNAL.validate_python({"kind": "harmonics", "harmonics": sines})
    assert signal.bounds()[1] >= 0.99 and signal.fastest() > 0.0


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"kind": "sawtooth"}, "sawtooth"),
        ({"kind": "keyframes", "points": []}, "points"),
        ({"kind": "keyframes", "points": [{"t_s": 1, "value": 0}, {"t_s": 1, "value": 1}]}, "times that increase"),
        ({"kind": "keyframes", "points": [{"t_s": 0, "value": float("nan")}]}, "finite"),
        (
            {"kind": "keyframes", "repeat": True, "points": [{"t_s": 0, "value": 0}, {"t_s": 1, "value": 1}]},
            "allowed: the first one",
        ),
        ({"kind": "harmonics", "harmonics": [{"amplitude": 1}]}, "exactly one of period_s and frequency_hz"),
        ({"kind": "harmonics", "harmonics": [{"amplitude": 0.01, "period_s": 9}] * 33}, "at most 32"),
        ({"kind": "harmonics", "harmonics": [{"amplitude": 0, "frequency_hz": 11}]}, "less than or equal to 10"),
        ({"kind": "keyframes", "points": [{"t_s": 1e300, "value": 0}]}, "less than or equal to 3600"),
        (
            {"kind": "keyframes", "points": [{"t_s": 1, "value": 0}, {"t_s": 1 + 1e-12, "value": 0}]},
            "t_s 1.000000000001 follows 1; allowed: 0.001 s later, or more",
        ),
        ({**SMOOTH["chirp"], "from_hz": 0}, "from_hz"),
        ({**SMOOTH["prbs"], "switch_s": 2.0}, "allowed: up to interval_s"),
        ({**SMOOTH["prbs"], "seed": 16}, "below 2\\^register_bits"),
        ({**SMOOTH["prbs"], "register_bits": 40}, "register_bits"),
    ],
)
def test_a_wrong_description_is_named(wrong: dict, message: str) -> None:
    with pytest.raises(ValidationError, match=message):
        SIGNAL.validate_python(wrong)
