"""Load cell with an offset, encoders with play."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from reality_states import Tissue, drawn_muscles

from jawenv.reality import Reality, reality_state_dtype
from jawenv.reality.sensors import biased, play

BAND_MM, BAND_DEG = 0.4, 0.3
BAND = np.repeat([BAND_MM / 1e3, np.radians(BAND_DEG)], 3)
PATHS = st.lists(st.floats(-5.0, 5.0), min_size=1, max_size=30)


def shown(path, bands=1.0):
    """(steps, 6): what encoders show of a path given in dead bands, from 0 on."""
    reality = Reality(encoder_play_mm=BAND_MM, encoder_play_deg=BAND_DEG).records()[0]
    state = np.zeros(1, dtype=reality_state_dtype(6))[0]
    rows = []
    for step in path:
        measured = np.concatenate([step * BAND * bands, np.arange(6.0)])
        play(reality, state, measured)
        np.testing.assert_array_equal(measured[6:], np.arange(6.0))  # velocities
        rows.append(measured[:6])
    return np.array(rows)


@given(PATHS)
def test_shown_and_true_differ_by_half_the_band_at_most(path):
    assert np.all(np.abs(shown(path) - np.outer(path, BAND)) <= 0.5 * BAND * (1 + 1e-12))


@given(PATHS, st.integers(1, 5))
def test_play_does_not_depend_on_the_rate(path, slowness):
    """More readings on the way between the same turning points change nothing at these."""
    corners = np.concatenate([[0.0], path])
    times = np.linspace(0, len(path), slowness * len(path) + 1)
    slow = shown(np.interp(times, np.arange(len(corners)), corners))
    np.testing.assert_allclose(slow[slowness::slowness], shown(path), atol=1e-15)


@given(st.floats(1.0, 10.0))
def test_the_loop_of_a_full_swing(swing):
    """Up, dragged half a band behind; turned, stuck for one band; down, half a band ahead."""
    there = np.linspace(0.0, swing, 200)
    back = there[::-1]
    up, down = np.split(shown(np.concatenate([there, back])), 2)
    np.testing.assert_allclose(up, np.outer(np.maximum(there - 0.5, 0.0), BAND), atol=1e-15)
    np.testing.assert_allclose(down, np.outer(np.minimum(back + 0.5, swing - 0.5), BAND), atol=1e-15)


def test_a_reset_centres_the_play_on_the_reading(jaw, rng):
    tissue = Tissue(jaw, drawn_muscles(rng), encoder_play_mm=BAND_MM)
    assert np.all(tissue.state["play"] == 0.0)


def test_the_bias_is_constant_within_an_episode(jaw, rng):
    normals = rng.standard_normal(6)
    tissue = Tissue(jaw, drawn_muscles(rng), normals=normals, cell_bias_N=0.2, cell_bias_N_m=0.003)
    for _ in range(3):
        clean = rng.standard_normal((3, 6))
        samples = clean.copy()
        biased(tissue.state, samples)
        expected = normals * np.repeat([0.2, 0.003], 3)
        np.testing.assert_allclose(samples - clean, np.tile(expected, (3, 1)), atol=1e-15)
