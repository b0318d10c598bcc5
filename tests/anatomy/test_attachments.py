"""The attachment table against independently known lengths, and its integrity."""

import numpy as np
import pytest

from jawenv.anatomy import PORTIONS, attachment, attachment_rows, load_quantities

# Straight-line lengths, mm, published beside the table.
LENGTHS_MM = {
    "superficial_masseter": 45.4,
    "deep_masseter": 34.2,
    "anterior_temporalis": 49.5,
    "posterior_temporalis": 51.9,
    "anterior_medial_pterygoid": 37.5,
    "posterior_medial_pterygoid": 43.9,
    "inferior_lateral_pterygoid": 32.0,
    "superior_lateral_pterygoid": 30.8,
}


@pytest.mark.parametrize("side", ["left", "right"])
@pytest.mark.parametrize("portion", LENGTHS_MM)
def test_length(portion: str, side: str) -> None:
    line = attachment(portion, side)
    assert 1e3 * np.linalg.norm(line.insertion_m - line.origin_m) == pytest.approx(LENGTHS_MM[portion], abs=0.051)


def test_every_portion_is_accepted_exactly_once_and_has_a_strength() -> None:
    accepted = [row.portion for row in attachment_rows() if row.status == "accepted"]
    assert sorted(accepted) == sorted(LENGTHS_MM)
    assert set(load_quantities("strengths.toml")) == set(LENGTHS_MM)
    assert set(PORTIONS) < set(LENGTHS_MM)


@pytest.mark.parametrize("portion", LENGTHS_MM)
def test_the_left_side_is_the_mirror_image(portion: str) -> None:
    left, right = attachment(portion, "left"), attachment(portion, "right")
    mirror = np.array([1, -1, 1])
    np.testing.assert_array_equal(left.origin_m, mirror * right.origin_m)
    np.testing.assert_array_equal(left.insertion_m, mirror * right.insertion_m)
    assert left.strength_N == right.strength_N
    assert left.origin_m[1] > 0 > right.origin_m[1]


def test_medial_pterygoid_strength_is_shared_by_cross_section() -> None:
    anterior = attachment("anterior_medial_pterygoid", "right").strength_N
    posterior = attachment("posterior_medial_pterygoid", "right").strength_N
    assert anterior + posterior == pytest.approx(174.8)
    assert anterior / posterior == pytest.approx(2.47 / 3.53, rel=1e-4)
