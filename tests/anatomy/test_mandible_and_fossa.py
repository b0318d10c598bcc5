"""The mandible is a body that can exist, the fossa a path that the literature knows."""

import numpy as np
import pytest

from jawenv.anatomy import default_mandible, load_quantities


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
