"""The mandible is a body that can exist, the fossa a path that the literature knows."""

import pickle

import numpy as np
import pytest

from jawenv.anatomy import default_fossa, default_mandible, load_quantities


def test_mandible_numbers() -> None:
    mandible = default_mandible()
    assert mandible.mass_kg == 0.30
    np.testing.assert_allclose(mandible.centre_of_mass_m, [0.041, 0, -0.046], rtol=1e-12)
    np.testing.assert_allclose(mandible.mouthpiece_m, [0.091, 0, -0.037], rtol=1e-12)
    # The mesh's inertia per kilogram, 1e-4 m2, as published.
    roll, pitch, yaw, xz = 12.30, 7.37, 14.87, 2.25
    per_kg = 1e-4 * np.array([[roll, 0, xz], [0, pitch, 0], [xz, 0, yaw]])
    np.testing.assert_allclose(mandible.inertia_kg_m2, 0.30 * per_kg, atol=6e-7)
    assert (mandible.damping_rotation, mandible.damping_sliding) == (0.05, 2.0)
    assert (mandible.tooth_stiffness, mandible.gravity) == (4000.0, 9.81)
    assert mandible.condyle_half_width_m == pytest.approx(0.050)


def test_disc_is_the_modulus_times_area_over_thickness_and_loses_what_discs_lose() -> None:
    """0.5 MPa over 200 mm2 and 2.5 mm; loss tangent 0.25 at 1000 rad/s."""
    mandible = default_mandible()
    assert mandible.disc_stiffness == pytest.approx(0.5e6 * 200e-6 / 2.5e-3)
    assert 1000.0 * mandible.disc_damping / mandible.disc_stiffness == pytest.approx(0.25)


def test_inertia_is_that_of_a_rigid_body_in_the_measured_order() -> None:
    inertia = default_mandible().inertia_kg_m2
    np.testing.assert_array_equal(inertia, inertia.T)
    small, middle, large = np.linalg.eigvalsh(inertia)
    assert 0 < small and small + middle >= large
    roll, pitch, yaw = np.diag(inertia)
    assert yaw > roll > pitch


def test_gravity_at_the_incisors_is_what_the_literature_gives() -> None:
    mandible = default_mandible()
    weight = mandible.mass_kg * mandible.gravity
    assert weight * mandible.centre_of_mass_m[0] / mandible.mouthpiece_m[0] == pytest.approx(1.3, abs=0.05)


def test_teeth_are_a_symmetric_arch_below_the_condyles() -> None:
    incisor, left, right = default_mandible().teeth_m
    np.testing.assert_array_equal(incisor, default_mandible().mouthpiece_m)
    np.testing.assert_array_equal(left, right * [1, -1, 1])
    assert left[1] > 0 and incisor[0] > left[0] > 0
    assert incisor[2] == left[2]


def test_every_quantity_has_unit_source_grade_and_lies_in_its_range() -> None:
    for name in ("mandible.toml", "fossa.toml", "strengths.toml"):
        for quantity in load_quantities(name).values():
            assert quantity.source and quantity.grade and quantity.unit
            if quantity.range is not None:
                low, high = quantity.range
                assert low <= quantity.value <= high


def test_fossa() -> None:
    fossa = default_fossa()
    assert fossa.drop_m == pytest.approx(2.8e-3)
    assert fossa.spatial_frequency == 245.0
    assert 1e3 * fossa.crest_m == pytest.approx(12.8, abs=0.05)
    assert np.degrees(np.arctan(fossa.drop_m * fossa.spatial_frequency)) == pytest.approx(34, abs=0.5)


def test_pickling_keeps_the_arrays_read_only() -> None:
    mandible = pickle.loads(pickle.dumps(default_mandible()))
    np.testing.assert_array_equal(mandible.inertia_kg_m2, default_mandible().inertia_kg_m2)
    assert not mandible.inertia_kg_m2.flags.writeable
    assert pickle.loads(pickle.dumps(default_fossa())) == default_fossa()
