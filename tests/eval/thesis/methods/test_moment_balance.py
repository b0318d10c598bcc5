"""What the muscles exert by the balance, against the independent model; smoothing and rows on recorded episodes."""

from dataclasses import replace

import newton_euler as twin
import numpy as np
import pytest
from estimation_records import quiet_records

from eval.thesis.methods.least_squares import exerted
from eval.thesis.methods.moment_balance import balance, balance_of
from jawenv.anatomy import cohort

LOW = np.array([-2e-4, -3e-3, -0.02, -0.1, -0.1, -0.03, -0.03, -1.0, -1.0, -1.0])
HIGH = np.array([1.2e-2, 3e-3, 0.4, 0.1, 0.1, 0.03, 0.03, 1.0, 1.0, 1.0])


def scenes(jaw, rng, number=20):
    """States, accelerations, wrenches and what the muscles exert (N, 5), all by the independent model."""
    states, wrenches = rng.uniform(LOW, HIGH, (number, 10)), rng.normal(size=(number, 6)) * np.repeat([5.0, 0.1], 3)
    truth = cohort("trismus").draw_log_parameters(rng)
    turned = np.array(
        [twin.acceleration(jaw, truth, s[:5], s[5:], w).real for s, w in zip(states, wrenches, strict=True)]
    )
    return states, turned, wrenches, truth


def pulls(jaw, q):
    """(6, 5) what each line with 1 N exerts: along the tangents (1, 0, slope), (0, 1, 0), and about the contact."""
    R, contact, slope = twin.rotation(q), twin.contact(jaw, q), twin.fossa(jaw, q[0])[1]
    insertions = contact + jaw["insertion"] @ R.T
    lines = jaw["origin"] - insertions
    units = lines / np.linalg.norm(lines, axis=1)[:, None]
    along = units @ np.array([[1, 0, slope], [0, 1, 0]]).T
    return np.hstack([along, np.cross(insertions - contact, units) @ R])


def test_needed_is_what_the_muscles_exert(jaw, rng):
    """All five rows, teeth, capsule, damping and all: 7-unknown Newton and Euler about the centre of mass."""
    states, turned, wrenches, truth = scenes(jaw, rng)
    needed, _, pull, strain = balance(jaw, states, turned, wrenches)
    for n, state in enumerate(states):
        q = state[:5]
        np.testing.assert_allclose(pull[n], pulls(jaw, q), atol=1e-12)
        np.testing.assert_allclose(strain[n], twin.muscle_lengths(jaw, q) / jaw["l_o"] - 1.0, atol=1e-12)
        expected = twin.tensions(jaw, truth, q) @ pulls(jaw, q)
        np.testing.assert_allclose(needed[n], expected, rtol=1e-8, atol=1e-9 * np.abs(turned[n]).max())


def test_derivative_by_the_wrench(jaw, rng):
    states, turned, wrenches, _ = scenes(jaw, rng, 5)
    needed, by_wrench, _, _ = balance(jaw, states, turned, wrenches)
    change = rng.normal(size=wrenches.shape)
    moved, _, _, _ = balance(jaw, states, turned, wrenches + change)
    np.testing.assert_allclose(needed - moved, np.einsum("nij,nj->ni", by_wrench, change), atol=1e-10)


@pytest.mark.parametrize("model", ["Jaw", "JawHinge"])
def test_a_record_without_noise_balances(model):
    record = quiet_records(model)[0]
    for rows, number in (("all", 5 if model == "Jaw" else 1), ("moment", 3 if model == "Jaw" else 1)):
        equations = balance_of(record, rows=rows)
        assert equations.needed.shape[1] == number
        gap = equations.needed - exerted(equations, record.truth)
        assert np.abs(gap).max() < 0.01 * np.abs(equations.needed).max()


def test_force_rows_come_first_and_moments_are_the_same_either_way():
    record = quiet_records("Jaw")[0]
    every, moments = balance_of(record, rows="all"), balance_of(record, rows="moment")
    np.testing.assert_array_equal(every.needed[:, 2:], moments.needed)
    np.testing.assert_array_equal(every.noise[2:, 2:], moments.noise)


def test_noise_and_whitening(rng):
    """The noise claimed of the smoothed rows is that of many drawn wrenches, and whitening makes it the identity."""
    record = quiet_records("Jaw")[0]
    clean = balance_of(record)
    shift = record.wrench_sd * rng.standard_normal((len(record.samples), 6))
    noisy = balance_of(replace(record, samples=record.samples + shift[:, None]))
    error = noisy.needed - clean.needed
    spread = np.sqrt(np.diag(clean.noise))
    np.testing.assert_allclose(
        error.T @ error / len(error) / np.outer(spread, spread), clean.noise / np.outer(spread, spread), atol=0.25
    )
    np.testing.assert_allclose(clean.whitened(clean.noise).noise, np.eye(5), atol=1e-9)
