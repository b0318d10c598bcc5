"""A plant of the user's moves the true jaw; jawenv's own mechanics, handed in as such a plant, are the reference."""

import copy
import pickle

import gymnasium as gym
import numpy as np
import pytest
from test_copies import actions, assert_same

import jawenv
from jawenv.mechanics import build_jaw
from jawenv.mechanics.dynamics import state_rate
from jawenv.mechanics.kinematics import fossa
from jawenv.mechanics.plant import body_motion, checked_motion, motion_at_mouthpiece, plant_of

ID = "jawenv/Jaw-v3"


class Midline:
    """The midline model by the explicit midpoint rule."""

    def reset(self, patient, rng):
        self.jaw, self.muscles = patient.jaw, np.column_stack([patient.F_o_N, patient.b])
        (x, y, _, *angles), _ = body_motion(patient.rest, self.jaw["mouthpiece"])
        self.q, self.u = np.array([x, y, *angles]), np.zeros(5)
        return self.motion()

    def take_muscles(self, F_o_N, b):
        self.muscles[:] = np.column_stack([F_o_N, b])

    def advance(self, wrench, dt):
        q, u = self.q, self.u
        for share in (0.5, 1.0):
            rates = state_rate(self.jaw, self.muscles, tuple(q), tuple(u), tuple(wrench))
            q, u = self.q + share * dt * np.array(rates[0]), self.u + share * dt * np.array(rates[1])
        self.q, self.u = q, u
        return self.motion()

    def motion(self):
        (x, y, *angles), (x_rate, y_rate, *omega) = self.q, self.u
        height, slope, _, _ = fossa(self.jaw, x)
        return motion_at_mouthpiece(
            ((x, y, height, *angles), (x_rate, y_rate, slope * x_rate, *omega)), self.jaw["mouthpiece"]
        )


class Still(Midline):
    """A jaw that no force moves; without ``take_muscles``."""

    take_muscles = property()

    def advance(self, wrench, dt):
        return self.motion()


class Shaken(Midline):
    """At rest somewhere else in each episode, for a step of a quarter of a tick."""

    step_s = 0.0025

    def reset(self, patient, rng):
        super().reset(patient, rng)
        self.q[1] += 1e-3 * rng.uniform(-1.0, 1.0)
        return self.motion()


def gently(steps):
    """Openings with a swing, far from stops and brakes."""
    time = np.arange(1, steps + 1)[:, None] / 20
    return (0.35 * np.sin(np.pi * time * [0.5, 0.5, 0.4, 0.3]) ** 2).astype(np.float32)


@pytest.mark.parametrize(
    "arguments",
    [
        {"control": "force", "reality": {"creep_share": 0.3, "articular_stiffness_N_m": 2000.0}},
        {"control": "trajectory"},
    ],
)
def test_jawenvs_own_mechanics_as_a_plant_give_the_belief_that_it_gives(arguments):
    """Noise is the same, so what is apart is the error of a wrench that is held for half a millisecond."""
    env, own = gym.make(ID, **arguments), gym.make(ID, plant=Midline(), **arguments)
    first, other = env.reset(seed=5000), own.reset(seed=5000)
    np.testing.assert_allclose(other[0], first[0], atol=1e-5)
    for action in gently(40):
        first, other = env.step(action), own.step(action)
    sd = first[4]["belief_sd"]
    assert np.ptp(first[4]["jaw_state"][:3]) > 1e-3 and sd.min() < 0.2
    np.testing.assert_allclose(other[4]["jaw_state"][:5], first[4]["jaw_state"][:5], atol=1e-4)
    np.testing.assert_allclose(other[4]["belief_mean"], first[4]["belief_mean"], atol=0.2 * sd.max())
    np.testing.assert_allclose(other[4]["belief_sd"], sd, rtol=0.05)


def test_every_world_has_a_copy_of_its_own_and_equal_seeds_give_equal_episodes():
    given = Shaken()
    vec, single = gym.make_vec(ID, num_envs=2, plant=given), gym.make(ID, plant="test_own_plants:Shaken")
    seen, _ = vec.reset(seed=5000)
    alone, _ = single.reset(seed=5001)
    np.testing.assert_array_equal(seen[1], alone)
    assert not vars(given) and len({id(each.plant) for each in vec.simulation.moved.each}) == 2
    for row in actions(2, 4):
        seen, _, _, _, info = vec.step(row)
        alone, *_, one = single.step(row[1])
        np.testing.assert_array_equal(seen[1], alone)
        np.testing.assert_array_equal(info["belief_mean"][1], one["belief_mean"])
    again = gym.make(gym.envs.registration.EnvSpec.from_json(single.spec.to_json()))
    np.testing.assert_array_equal(again.reset(seed=5000)[0], vec.reset(seed=5000)[0][0])


@pytest.mark.parametrize("way", [copy.deepcopy, lambda env: pickle.loads(pickle.dumps(env))])
def test_copies_go_on_alike(way):
    env = gym.make(ID, plant=Shaken(), control="force")
    env.reset(seed=5000)
    env.step(np.full(4, 0.3, np.float32))
    other = way(env)
    expected = [env.step(action) for (action,) in actions(1, 4)]
    for (action,), step in zip(actions(1, 4), expected, strict=True):
        assert_same(other.step(action), step)


def test_the_plant_gets_the_true_anatomy_and_the_filter_another():
    env = gym.make(ID, plant=Midline(), reality={"attachment_error": 0.1})
    env.reset(seed=5000)
    for (action,) in actions(1, 4):
        *_, info = env.step(action)
    simulation = env.unwrapped.simulation
    true = simulation.moved.each[0].plant.jaw
    np.testing.assert_array_equal(true["insertion"], simulation.worlds[0]["truth"]["jaw"]["insertion"])
    assert np.abs(true["insertion"] - simulation.models[0]["insertion"]).max() > 1e-4
    assert np.isfinite(info["belief_mean"]).all() and np.isfinite(info["nees"])


def motion_of(jaw, **changed):
    motion = motion_at_mouthpiece(
        ((1e-3, 2e-3, -1e-3, 0.2, 0.1, -0.1), (0.01, 0.02, 0.03, 0.1, 0.2, 0.3)), jaw["mouthpiece"]
    )
    return motion._replace(**changed)


@pytest.mark.parametrize(
    ("changed", "told"),
    [
        ({"place_m": [0.0, np.nan, 0.0]}, "here: place_m is [0.0, nan, 0.0]; allowed: finite numbers of shape (3,)"),
        ({"velocity_m_s": np.zeros(2)}, "velocity_m_s"),
        ({"angular_velocity_rad_s": "quick"}, "angular_velocity_rad_s"),
        ({"rotation": np.eye(3) * 1.001}, "here: rotation"),
        ({"rotation": np.diag([1.0, -1.0, 1.0])}, "allowed: a rotation matrix, body to head axes"),
        ({"rotation": [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]}, "yaw"),
    ],
)
def test_what_is_no_motion_is_refused_by_its_field(changed, told):
    with pytest.raises(jawenv.InputError) as error:
        checked_motion(motion_of(build_jaw(), **changed), "here")
    assert told in str(error.value)
    with pytest.raises(jawenv.InputError, match="allowed: a jawenv.Motion"):
        checked_motion((1, 2), "here")


def with_step(step_s):
    plant = Midline()
    plant.step_s = step_s
    return plant


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        ({"plant": 3}, "plant is 3; allowed: an object with the methods reset"),
        ({"plant": Midline}, "allowed: an object with the methods reset"),
        ({"plant": "no name"}, "plant is 'no name'; allowed: an object with the methods reset"),
        ({"plant": "no_such_module:Jaw"}, "plant 'no_such_module:Jaw': no module 'no_such_module'"),
        ({"plant": "test_own_plants:gently"}, "test_own_plants:gently"),
        ({"plant": "test_own_plants:Jaw"}, "module 'test_own_plants' has no 'Jaw'"),
        ({"plant": with_step(3e-3)}, "plant Midline: step_s is 0.003; allowed: 0.01 over a whole number"),
        ({"plant": with_step("long")}, "step_s is 'long'"),
        ({"plant": Still(), "reality": {"creep_share": 0.2}}, "plant Still has no take_muscles"),
    ],
)
def test_plants_that_are_none_are_refused_in_one_line(arguments, told):
    with pytest.raises(jawenv.InputError) as error:
        gym.make(ID, **arguments)
    assert told in str(error.value) and "\n" not in str(error.value)


class Broken(Midline):
    """Goes astray in its second step."""

    def advance(self, wrench, dt):
        motion = super().advance(wrench, dt)
        return motion if abs(wrench[2]) < 1.0 else motion._replace(place_m=motion.place_m * np.nan)


class FarOpen(Midline):
    def reset(self, patient, rng):
        return super().reset(patient, rng)._replace(place_m=[0.05, 0.0, -0.1])


def test_a_plant_that_fails_ends_the_episode():
    env = gym.make(ID, plant=Broken(), control="force")
    before, _ = env.reset(seed=5000)
    with pytest.raises(jawenv.InputError, match="plant Broken: advance: place_m"):
        for _ in range(10):
            env.step(np.ones(4, np.float32))
    with pytest.raises(gym.error.ResetNeeded):
        env.step(np.zeros(4, np.float32))
    np.testing.assert_array_equal(env.reset(seed=5000)[0], before)
    with pytest.raises(jawenv.InputError, match="the plant rests with"):
        gym.make(ID, plant=FarOpen()).reset(seed=5000)


def test_a_plant_by_its_name_is_a_plain_argument():
    configuration = gym.make(ID, plant="test_own_plants:Midline").unwrapped.configuration
    assert configuration.arguments["plant"] == "test_own_plants:Midline"
    assert isinstance(plant_of("test_own_plants:Midline"), Midline)
    with pytest.raises(jawenv.InputError, match="allowed where a configuration is kept"):
        gym.make(ID, plant=Midline()).unwrapped.configuration.arguments  # noqa: B018
