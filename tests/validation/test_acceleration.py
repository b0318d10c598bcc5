"""jawenv's accelerations are those of MuJoCo's rigid body on the same fossa."""

from dataclasses import replace

import numpy as np
import pytest
from jaw_motion import random_patient, random_state, random_wrench
from mujoco_twin import MujocoTwin
from scipy.spatial.transform import Rotation

import jawenv
from jawenv.anatomy import Fossa, default_fossa, default_mandible
from jawenv.mechanics import build_jaw

N_STATES = 200


def relative_error(actual, expected):
    """Largest error over the largest number of the same unit: linear rows, then angular rows."""
    rows = (slice(0, 2), slice(2, 5))
    return max(np.abs(actual[r] - expected[r]).max() / np.abs(expected[r]).max() for r in rows)


def largest_error(jaws, rng, *, on_stops):
    """Over random states; ``jaws`` yields a jawenv record and its MuJoCo twin for each."""
    errors = []
    for jaw, twin in jaws:
        log_parameters, wrench = random_patient(rng), random_wrench(rng)
        q, u = random_state(rng, on_stops=on_stops)
        expected = twin.acceleration(twin.state(q, u), log_parameters, wrench)
        errors.append(relative_error(jawenv.acceleration(jaw, q, u, log_parameters, wrench), expected))
    print(f"largest relative error {max(errors):.1e}")
    return max(errors)


@pytest.mark.parametrize("on_stops", [False, True], ids=["off the stops", "on the stops"])
@pytest.mark.parametrize("head_tilt_deg", [0.0, 25.0])
def test_acceleration_is_that_of_mujocos_body(on_stops, head_tilt_deg):
    pair = build_jaw(head_tilt_deg=head_tilt_deg), MujocoTwin(head_tilt_deg=head_tilt_deg)
    assert largest_error([pair] * N_STATES, np.random.default_rng(1), on_stops=on_stops) < 1e-10


def lopsided_anatomy(rng):
    """A mandible that is heavier on one side, with all products of inertia, and another fossa."""
    mandible, fossa, turn = default_mandible(), default_fossa(), Rotation.random(rng=rng).as_matrix()
    return replace(
        mandible,
        mass_kg=rng.uniform(0.2, 0.44),
        centre_of_mass_m=mandible.centre_of_mass_m + rng.uniform(-6e-3, 6e-3, 3),
        inertia_kg_m2=turn @ np.diag(rng.uniform(2.5e-4, 4.5e-4, 3)) @ turn.T,
        mouthpiece_m=mandible.mouthpiece_m + rng.uniform(-5e-3, 5e-3, 3),
        damping_rotation=rng.uniform(0.005, 0.4),
        damping_sliding=rng.uniform(0, 10),
    ), Fossa(fossa.drop_m * rng.uniform(0.7, 1.2), fossa.spatial_frequency * rng.uniform(0.9, 1.4))


def test_nothing_relies_on_the_default_mandibles_symmetry():
    rng = np.random.default_rng(2)
    anatomies = [lopsided_anatomy(rng) for _ in range(N_STATES)]
    jaws = [(build_jaw(mandible=m, fossa=f), MujocoTwin(m, f)) for m, f in anatomies]
    assert largest_error(jaws, rng, on_stops=False) < 1e-10
