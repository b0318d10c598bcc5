"""What the score owes to the noise in the lines' strains, against differences of the lines' generalised forces."""

import numpy as np
import pytest
from recorded import recording
from running import Running, half_way, line_wrenches, to_coordinates

from jawenv.estimation.online.regressors import set_by_place, set_line_wrenches


def rows_of(R):
    return tuple(tuple(float(value) for value in row) for row in R)


@pytest.mark.parametrize("model", ["jaw", "hinge", "bilateral"])
def test_what_a_change_of_pose_makes_of_unit_coefficients(model, rng):
    """``spilt`` with one entry at a time makes the score that of the wrench's derivative by one coordinate."""
    record = recording(model).records[0]
    jaw, running = record.jaw, Running(record)
    n = running.size // 2
    q = record.start_mean[:n] + np.concatenate([np.full(n - 3, 3e-4), [0.1, 0.05, -0.04]]) * rng.uniform(0.5, 1.5, n)
    if model == "hinge":
        q[[0, 1, 3, 4]] = record.start_mean[[0, 1, 3, 4]]
    reading, scratch = rng.normal(size=6), running.scratch

    def forces(at):
        place, R = half_way(jaw, np.concatenate([at, at]), np.concatenate([at, at]))
        return to_coordinates(jaw, at, R) @ line_wrenches(jaw, running.basis, place, R, reading)[:, :-1]

    place, R = half_way(jaw, np.concatenate([q, q]), np.concatenate([q, q]))
    midline = tuple(float(v) for v in (q if n == 5 else q[[0, 1, 3, 4, 5]]))
    scratch["reading"] = reading
    bend = set_by_place(jaw, midline, rows_of(R), scratch)
    by_pose = np.zeros((6, n, running.belief["score"].size))
    for k in range(6):
        for c in range(n):
            scratch["spilt"] = 0.0
            scratch["spilt"][k, c] = 1.0
            running.belief["score"] = 0.0
            set_line_wrenches(jaw, running.belief, tuple(place), rows_of(R), bend, record.dt, scratch)
            by_pose[k, c] = running.belief["score"]
    np.testing.assert_array_equal(by_pose[:, :, -1], 0.0)
    held = to_coordinates(jaw, q, R)
    for c in range(n):
        step = 1e-6 * np.eye(n)[c]
        expected = (forces(q + step) - forces(q - step)) / 2e-6
        scale = np.abs(expected).max(axis=1, keepdims=True) + 1e-6
        np.testing.assert_allclose(held @ by_pose[:, c, :-1] / scale, expected / scale, rtol=0, atol=1e-6)
