"""The bound on how fast a jaw swings, and the steps that follow from it."""

import numpy as np
import pytest

import jawenv
from jawenv.mechanics import build_jaw
from jawenv.mechanics.dynamics import linear_dtype, linearise_acceleration
from jawenv.mechanics.stiffness import LARGEST_PHASE, MOST_PARTS, fastest_rate, parts_needed

STILL, NOTHING = (0.0,) * 5, (0.0,) * 6


def shares_of_the_bound(jaw, cohort, poses, rng):
    """The fastest mode of the exact linearisation at each pose, for a drawn patient, over the bound."""
    linear = np.zeros(1, dtype=linear_dtype(6))[0]
    shares = []
    for q in poses:
        muscles = np.exp(jawenv.cohort(cohort).draw_log_parameters(rng)).reshape(6, 2)
        linearise_acceleration(jaw, muscles, q, STILL, NOTHING, linear)
        fastest = np.sqrt(np.abs(np.linalg.eigvals(linear["by_state"][:, :5])).max())
        shares.append(fastest / fastest_rate(jaw, muscles, q))
    return np.array(shares)


@pytest.mark.parametrize("cohort", ["trismus", "severe", "blockage", "wide"])
def test_no_mode_is_faster_than_the_bound(jaw, rng, cohort):
    """Off the stops. Measured: 1.11 at most, as a line's pull has a stiffness across it too, and the jaw is open."""
    jaw["tooth_stiffness"] = jaw["condyle_stiffness"] = jaw["gravity"] = 0.0
    poses = [
        (rng.uniform(0, 6e-3), rng.uniform(-2e-3, 2e-3), rng.uniform(0, 0.3), *rng.uniform(-0.05, 0.05, 2))
        for _ in range(100)
    ]
    shares = shares_of_the_bound(jaw, cohort, poses, rng)
    assert 0.3 < np.median(shares) and max(shares) < 1.15, "a bound, and not a useless one"


def test_nor_on_the_teeth_and_at_the_stops(jaw, rng):
    """Teeth pressed together, the condyles behind their path's start or beyond its end."""
    jaw["gravity"] = 0.0
    behind = [(rng.uniform(-2e-3, 0.0), 0.0, rng.uniform(-0.03, 0.0), 0.0, 0.0) for _ in range(50)]
    beyond = [(float(jaw["crest"]) + rng.uniform(0.0, 2e-3), 0.0, 0.2, 0.0, 0.0) for _ in range(50)]
    for poses in (behind, beyond):
        shares = shares_of_the_bound(jaw, "trismus", poses, rng)
        assert 0.3 < np.median(shares) and max(shares) < 1.1
    off = build_jaw()
    off["tooth_stiffness"] = off["condyle_stiffness"] = off["gravity"] = 0.0
    muscles = np.exp(jawenv.cohort("trismus").prior.mean).reshape(6, 2)
    for q in (behind[0], beyond[0]):
        assert fastest_rate(jaw, muscles, q) > fastest_rate(off, muscles, q)


def test_mobilities_are_those_of_a_free_body(jaw):
    """A push of 1 N at a point: the acceleration of that point along it, by Newton and Euler."""
    teeth = [(tooth, np.array([0.0, 0.0, 1.0])) for tooth in jaw["teeth"]]
    condyles = [(np.zeros(3), np.array([1.0, 0.0, 0.0]))]
    for (point, along), stated in zip(
        [*teeth, *condyles], [*jaw["tooth_mobility"], jaw["condyle_mobility"]], strict=True
    ):
        arm = point - jaw["centre_of_mass"]
        turning = np.linalg.solve(jaw["inertia"], np.cross(arm, along))
        assert stated == pytest.approx(along @ (along / jaw["mass"] + np.cross(turning, arm)), rel=1e-12)


def test_the_mouthpiece_gives_way_most_in_one_direction(jaw, rng):
    arm = jaw["mouthpiece"] - jaw["centre_of_mass"]
    ways = rng.normal(size=(20_000, 3))
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    turning = np.linalg.solve(jaw["inertia"], np.cross(arm, ways).T).T
    found = np.sum(ways * (ways / jaw["mass"] + np.cross(turning, arm)), axis=1)
    assert 0.999 * jaw["mouthpiece_mobility"] < found.max() <= jaw["mouthpiece_mobility"] * (1 + 1e-12)


def test_steps_are_divided_into_as_few_parts_as_are_short_enough():
    for parts in range(1, MOST_PARTS + 1):
        assert parts_needed(0.999 * parts * LARGEST_PHASE / 0.01, 0.01, 1) == parts
    assert parts_needed(1.01 * LARGEST_PHASE / 0.01, 0.01, 1) == 2
    assert parts_needed(4.9 * LARGEST_PHASE / 0.01, 0.01, 2) == 5
    assert parts_needed(float("nan"), 0.01, 1) == MOST_PARTS
    assert parts_needed(1e9, 0.01, 1) == MOST_PARTS
    assert parts_needed(0.0, 0.01, 5) == 5
