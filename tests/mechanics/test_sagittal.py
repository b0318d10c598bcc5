"""The plant in the sagittal plane: its coordinates, its forces and what its contacts do."""

import numpy as np
import pytest
import sagittal_plane as plane

from jawenv.base.errors import InputError
from jawenv.mechanics.forces import resultant
from jawenv.mechanics.kinematics import contact_point, rotation
from jawenv.mechanics.sagittal import SagittalJaw
from jawenv.mechanics.sagittal_forces import passive_forces


@pytest.fixture
def jaw():
    return plane.flat_jaw()


def plant(jaw, **options):
    return SagittalJaw(jaw, plane.muscles(), **options)


def weightless(jaw):
    """The jaw without weight, and muscles that hardly pull: what is left is contact."""
    jaw["gravity"] = jaw["tone"] = 0.0
    return jaw, plane.muscles((1e-9, 7.0))


def test_mouthpiece_moves_as_the_kinematics_say(jaw):
    sagittal, seen = plant(jaw, friction=0.0), []
    sagittal.place([*plane.on_path(jaw, 4e-3, 0.2)[:3], 0.0, 0.0, 0.5])
    sagittal.advance(sagittal.step, lambda *given: seen.append(given) or (0.0, 0.0, 0.0))
    (place, velocity, theta, rate, since), turn = seen[0], rotation((0.0, 0.0, seen[0][2], 0.0, 0.0))
    arm = np.array(turn) @ jaw["mouthpiece"]
    condyle = np.array(contact_point(jaw, (4e-3, 0.0, 0.0, 0.0, 0.0)))
    # The body turns about its centre of mass in the first step; the condyle leaves its place by micrometres.
    np.testing.assert_allclose(place, (condyle + arm)[::2], atol=2e-5)
    np.testing.assert_allclose(velocity, np.cross([0.0, rate, 0.0], arm)[::2], atol=2e-5)
    assert place[1] < jaw["mouthpiece"][2] + condyle[2]  # theta > 0 opens
    assert (theta, rate, since) == (pytest.approx(0.2 + 0.5 * sagittal.step), 0.5, sagittal.step)


@pytest.mark.parametrize("x", [1e-3, 6e-3, 14e-3])
def test_forces_are_those_of_the_midline_model(jaw, x):
    q, x_rate, theta_rate = (x, 0.0, -0.03, 0.0, 0.0), 0.02, 0.4
    force, moment = resultant(jaw, plane.muscles(), q, (x_rate, 0.0, 0.0, theta_rate, 0.0), rotation(q))
    slope = -jaw["fossa_drop"] * jaw["fossa_frequency"] * np.sin(jaw["fossa_frequency"] * x)
    state = (x, contact_point(jaw, q)[2], q[2], x_rate, slope * x_rate, theta_rate)
    expected = (force[0], force[2], moment[1] - jaw["damping_rotation"] * theta_rate)
    np.testing.assert_allclose(passive_forces(jaw, plane.muscles(), state), expected, rtol=1e-12)


def test_lines_of_one_side_with_twice_the_force_are_both_sides(jaw):
    state = (4e-3, -2e-3, 0.2, 0.0, 0.0, 0.0)
    both = passive_forces(jaw, plane.muscles(), state)
    one_sided = plane.muscles((3.0, 7.0))
    one_sided[3:, 0] = 0.0
    np.testing.assert_allclose(passive_forces(jaw, one_sided, state), both, rtol=1e-12)


def test_it_rests_where_the_midline_model_does(jaw):
    sagittal, rest = plant(jaw, friction=0.0), plane.on_path(jaw, *plane.midline_rest(jaw))
    sagittal.place(rest)
    sagittal.advance(0.5)
    np.testing.assert_allclose(sagittal.state[:3], rest[:3], rtol=0.0, atol=5e-5)
    sagittal.advance(0.1)
    x, z, theta, *speed = sagittal.state
    assert sagittal.contact.touching and sagittal.contact.share == 1.0
    np.testing.assert_allclose(speed, 0.0, atol=2e-3)
    assert z == pytest.approx(contact_point(jaw, (x, 0.0, 0.0, 0.0, 0.0))[2], abs=2e-6)
    push = passive_forces(jaw, plane.muscles(), tuple(sagittal.state))
    assert sagittal.contact.normal == pytest.approx(np.hypot(*push[:2]), rel=0.01)
    assert sagittal.contact.friction == pytest.approx(0.0, abs=1e-9)


def test_the_condyle_leaves_the_fossa_when_it_is_pulled_down(jaw):
    sagittal = plant(jaw)
    sagittal.place(plane.on_path(jaw, *plane.midline_rest(jaw)))
    sagittal.advance(0.1)
    assert sagittal.contact.touching
    # A force of 15 N whose line runs through the condyle: at the mouthpiece, the force and a closing moment.
    sagittal.advance(0.1, lambda place, *_: (0.0, -15.0, -15.0 * (place[0] - sagittal.state[0])))
    x, z, *_ = sagittal.state
    assert z < contact_point(jaw, (x, 0.0, 0.0, 0.0, 0.0))[2] - 1e-3
    assert not sagittal.contact.touching and sagittal.contact.share < 0.5
    sagittal.advance(0.5)
    assert sagittal.contact.touching


def through_condyle(sagittal, forward, up):
    """A force through the condyle, given at the mouthpiece."""

    def wrench(place, *_):
        x, z, *_ = sagittal.state
        return forward, up, -((place[1] - z) * forward - (place[0] - x) * up)

    return wrench


@pytest.mark.parametrize("forward", [-20.0, 40.0])
def test_the_condyle_stays_between_its_walls(jaw, forward):
    jaw, law = weightless(jaw)
    jaw["damping_sliding"] = 50.0  # else it arrives with metres per second, some 1 mm in a step
    sagittal = SagittalJaw(jaw, law)
    sagittal.place(plane.on_path(jaw, 3e-3, 0.4))
    for _ in range(100):
        sagittal.advance(0.01, through_condyle(sagittal, forward, 10.0))
        assert -2e-4 < sagittal.state[0] < 1.5 * jaw["crest"] + 2e-4
    if forward < 0:
        np.testing.assert_allclose(sagittal.state[:2], 0.0, atol=3e-5)
    else:
        assert sagittal.state[0] > jaw["crest"]


def test_friction_holds_a_small_force_and_gives_way_to_a_large_one(jaw):
    jaw, law = weightless(jaw)
    mu, radius = 0.3, 4.4e-3
    sagittal = SagittalJaw(jaw, law, friction=mu, condyle_radius=radius)
    for forward in (0.2 * mu * 10.0, 2.0 * mu * 10.0):
        sagittal.place(plane.on_path(jaw, 0.5 * jaw["crest"], 0.4))
        # Forces along the normal and the tangent of the fossa, and the moment that keeps friction from turning the jaw.
        slope = -jaw["fossa_drop"] * jaw["fossa_frequency"]
        normal, tangent = np.array([-slope, 1.0]) / np.hypot(slope, 1.0), np.array([1.0, slope]) / np.hypot(slope, 1.0)
        force, rub = 10.0 * normal + forward * tangent, min(forward, mu * 10.0)

        def wrench(place, *_, force=force, rub=rub):
            pull = through_condyle(sagittal, *force)(place)
            return pull[0], pull[1], pull[2] + rub * radius

        sagittal.advance(0.02, wrench)
        moved = sagittal.state[0] - 0.5 * jaw["crest"]
        ratio = -sagittal.contact.friction / sagittal.contact.normal
        if forward < 10.0 * mu:
            assert abs(moved) < 2e-5
            assert ratio == pytest.approx(forward / 10.0, rel=0.2)
        else:
            assert moved > 1e-4
            assert ratio == pytest.approx(mu, rel=0.05)


def test_same_inputs_same_numbers(jaw):
    def run(sagittal):
        sagittal.place(plane.on_path(jaw, *plane.midline_rest(jaw)))
        return plane.pulled_down(sagittal, 0.5, lambda t: 10.0 * t).tolist(), sagittal.contact

    one, other = plant(jaw), plant(jaw)
    first = run(one)
    assert run(other) == first
    assert run(one) == first  # also the second episode of the same object


def test_an_error_in_the_device_is_not_swallowed(jaw):
    def broken(*_):
        raise RuntimeError("the device broke")

    with pytest.raises(RuntimeError, match="the device broke"):
        plant(jaw).advance(0.01, broken)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"friction": -0.1}, "friction is -0.1; allowed: numbers from 0 on"),
        ({"step": 0.0}, "step is 0.0; allowed: numbers above 0"),
        ({"segment": 0.0}, "segment is 0.0; allowed: numbers above 0"),
        ({"condyle_radius": 6e-3}, "condyle_radius is 0.006; allowed: 0 to the path's 0.00595"),
    ],
)
def test_faulty_arguments_are_refused(jaw, options, message):
    with pytest.raises(InputError) as caught:
        plant(jaw, **options)
    assert str(caught.value) == message


def test_faulty_muscles_and_durations_are_refused(jaw):
    with pytest.raises(InputError):
        SagittalJaw(jaw, [1.5, 7.0])
    with pytest.raises(InputError):
        plant(jaw).advance(7e-4)
