"""All lines at once give the numbers that one line after the other gives."""

from math import exp, sqrt

import numpy as np
import pytest

from jawenv.kernels.compiled import njit, njit_inlined
from jawenv.kernels.lanes import all_lines, lane, total
from jawenv.kernels.records import record_dtype, record_zeros
from jawenv.mechanics import build_jaw
from jawenv.mechanics.forces import carried_with_stiffness, muscle_pull
from jawenv.mechanics.kinematics import contact_point, rotation

COUNTS = (1, 2, 3, 6, 8, 12)


def lines(count, rng):
    """A record with a number and three columns for each of ``count`` lines, and room for results."""
    fields = [(name, "f8", (count,)) for name in ("a", "b", "result")]
    record = record_zeros(1, record_dtype([*fields, ("columns", "f8", (count, 3))]))[0]
    record["a"], record["b"] = rng.uniform(0.1, 3.0, count), rng.uniform(-3.0, 3.0, count)
    record["columns"] = rng.normal(size=(count, 3))
    return record


@njit_inlined
def formula(record, i):
    """Every operator of ``Lanes``, with numbers on either side."""
    first = 2.0 * record.a[i] - record.b[i] * record.columns[i, 1] / 3.0
    return -min(first, record.b[i]) + max(record.columns[i, 2], 1.0 / record.a[i]) + (1 - record.a[i]) * 2


@njit
def one_by_one(record, results):
    for i in range(results.shape[0]):
        results[i] = formula(record, i)


@njit
def at_once(record, results):
    index = all_lines(record.a)
    lanes = formula(record, index)
    record.result[index] = lanes
    record.columns[index, 2] = lanes
    for i in range(results.shape[0]):
        results[i] = lane(lanes, i)
    return total(lanes)


@pytest.mark.parametrize("count", COUNTS)
def test_lanes_are_the_scalar_kernels_numbers(count):
    record = lines(count, np.random.default_rng(count))
    expected, results = np.empty(count), np.empty(count)
    one_by_one(record, expected)
    first_columns = record["columns"][:, :2].copy()
    added = at_once(record, results)
    np.testing.assert_allclose(results, expected, rtol=1e-15, atol=1e-15)
    assert added == pytest.approx(expected.sum(), rel=1e-14, abs=1e-14)
    np.testing.assert_array_equal(record["result"], results)
    np.testing.assert_array_equal(record["columns"][:, 2], results)
    np.testing.assert_array_equal(record["columns"][:, :2], first_columns)


@njit
def functions(record):
    index = all_lines(record.a)
    record.result[index] = sqrt(record.a[index])
    record.b[index] = exp(record.b[index])


def ulps(actual, desired):
    return np.max(np.abs(actual - desired) / np.spacing(np.abs(desired)))


def test_roots_are_exact_and_exponentials_to_two_units_in_the_last_place():
    rng = np.random.default_rng(0)
    for scale in (1e-3, 1.0, 30.0, 650.0):
        for _ in range(200):
            record = lines(8, rng)
            record["a"], record["b"] = scale * record["a"], scale * rng.uniform(-1.0, 1.0, 8)
            root, power = np.sqrt(record["a"]), np.exp(record["b"])
            functions(record)
            np.testing.assert_array_equal(record["result"], root)
            assert ulps(record["b"], power) <= 2.0


def test_exponentials_beyond_the_limit_are_those_of_the_limit():
    record = lines(8, np.random.default_rng(0))
    record["b"] = [701.0, 1e308, np.inf, -701.0, -1e308, -np.inf, 0.0, np.nan]
    functions(record)
    np.testing.assert_allclose(record["b"][:3], np.exp(700.0), rtol=1e-15)
    np.testing.assert_allclose(record["b"][3:6], np.exp(-700.0), rtol=1e-15)
    assert record["b"][6] == 1.0
    assert np.isnan(record["b"][7])


@njit
def pulls_of(jaw, muscles, q, values):
    for i in range(values.shape[0]):
        arm, direction, length, tension = muscle_pull(jaw, muscles, i, contact_point(jaw, q), rotation(q))
        values[i, 0], values[i, 1], values[i, 2] = length, tension, tension * (arm[0] * direction[2])


@njit
def resultants(jaw, muscles, q, stiffness, pulls):
    return carried_with_stiffness(jaw, muscles, contact_point(jaw, q), rotation(q), stiffness, pulls)


def test_forces_and_stiffness_of_all_lines_are_the_sum_of_one_by_one():
    jaw, q, rng = build_jaw(), (4e-3, 1e-3, 0.2, 0.02, -0.01), np.random.default_rng(0)
    muscles = np.column_stack([rng.uniform(1.0, 3.0, 6), rng.uniform(5.0, 9.0, 6)])
    values, stiffness, pulls = np.empty((6, 3)), np.empty((3, 3, 3)), np.empty((6, 7))
    pulls_of(jaw, muscles, q, values)
    whole = resultants(jaw, muscles, q, stiffness, pulls)
    np.testing.assert_allclose(pulls[:, 6], values[:, 0] / jaw["l_o"] - 1.0, rtol=1e-13)
    np.testing.assert_allclose(np.linalg.norm(pulls[:, :3], axis=1), values[:, 1], rtol=1e-14)
    added, without, none = np.zeros((3, 3, 3)), np.empty((3, 3, 3)), muscles * [0.0, 1.0]
    weight = resultants(jaw, none, q, without, np.empty((6, 7)))
    force = np.zeros((2, 3))
    for i in range(6):
        alone, part = none.copy(), np.empty((3, 3, 3))
        alone[i] = muscles[i]
        force += np.subtract(resultants(jaw, alone, q, part, np.empty((6, 7))), weight)
        added += part - without
    np.testing.assert_allclose(force, np.subtract(whole, weight), rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(added, stiffness - without, rtol=1e-10, atol=1e-10 * np.abs(stiffness).max())
