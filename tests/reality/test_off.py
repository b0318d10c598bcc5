"""With every option 0 nothing changes by a bit, and nothing is drawn."""

import numpy as np
import pytest
from reality_states import Tissue, drawn_muscles

from jawenv.anatomy import known_muscle_sets
from jawenv.device.comfort import limits_dtype
from jawenv.mechanics import build_jaw
from jawenv.reality import Reality
from jawenv.reality.geometry import perturb_geometry
from jawenv.reality.joint import articular_push
from jawenv.reality.sensors import biased, fail, play

KEY = np.uint64(1), np.uint64(2)


def test_the_tissue_keeps_its_law(jaw, rng):
    muscles = drawn_muscles(rng)
    tissue = Tissue(jaw, muscles)
    for _ in range(50):
        tissue.tick([5e-3, *rng.uniform(-0.1, 0.4, 4)], rng.uniform(-1, 1, 5))
        assert tissue.effective.tobytes() == muscles.tobytes()


def test_the_sensors_show_what_they_showed(jaw, rng):
    tissue = Tissue(jaw, drawn_muscles(rng), normals=rng.standard_normal(6))
    samples, measured = rng.standard_normal((3, 6)), rng.standard_normal(12)
    samples[0, 0] = measured[0] = -0.0
    before = samples.tobytes(), measured.tobytes()
    biased(tissue.state, samples)
    play(tissue.reality, tissue.state, measured)
    fail(tissue.reality, tissue.state, KEY, 7, measured, samples, np.empty(20))
    assert (samples.tobytes(), measured.tobytes()) == before


def test_the_joint_pushes_nowhere(jaw):
    limits = np.zeros(1, dtype=limits_dtype(6))[0]
    limits["opening"] = 1e-3
    assert articular_push(Reality().records()[0], limits, jaw, (5e-3, 0.0, 0.5, 0.0, 0.0), (0.0, 0.0)) == (
        0.0,
        0.0,
        0.0,
    )


@pytest.mark.parametrize("name", known_muscle_sets())
def test_the_geometry_stays_and_nothing_is_drawn(name, rng):
    muscles = known_muscle_sets()[name]
    jaw, before = build_jaw(muscles), rng.bit_generator.state
    perturb_geometry(Reality(), muscles, jaw, rng)
    assert jaw.tobytes() == build_jaw(muscles).tobytes()
    assert rng.bit_generator.state == before
