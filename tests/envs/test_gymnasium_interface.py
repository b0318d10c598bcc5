"""What Gymnasium and stable-baselines3 ask of an environment, and what a user gets told who asks for the impossible."""

import pickle
import subprocess
import sys

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.envs.registration import EnvSpec
from gymnasium.utils.env_checker import check_env

import jawenv
from jawenv.envs.observation import OBSERVATION_LAYOUT
from jawenv.envs.vector import JawVectorEnv

ID = "jawenv/Jaw-v0"
MODES = [(control, sensors) for control in ("force", "trajectory") for sensors in ("pose", "point")]
MUSCLES = dict.fromkeys(jawenv.MUSCLE_NAMES, 1.0)
NOTHING = np.zeros(4, dtype=np.float32)


def make(**arguments):
    """The bare environment, without Gymnasium's wrappers."""
    return gym.make(ID, **arguments).unwrapped


@pytest.mark.parametrize(("control", "sensors"), MODES)
def test_gymnasiums_checker_has_nothing_to_say(control, sensors):
    """Warnings are errors in this suite."""
    check_env(make(control=control, sensors=sensors, episode_s=1.0), skip_render_check=True)


@pytest.mark.parametrize(("control", "sensors"), MODES)
def test_stable_baselines3s_checker_has_nothing_to_say(control, sensors):
    checker = pytest.importorskip("stable_baselines3.common.env_checker")
    checker.check_env(make(control=control, sensors=sensors, episode_s=1.0), warn=True)


def test_make_vec_gives_the_native_vector_form():
    env = gym.make_vec(ID, num_envs=256, cohort="severe")
    assert isinstance(env, JawVectorEnv)
    assert env.num_envs == 256
    assert env.configuration.cohort == "severe"
    assert env.observation_space.shape == (256, 63)
    assert env.single_action_space == make().action_space


def test_a_spec_survives_json_and_pickle():
    spec = gym.make(ID, control="trajectory", device={"full_scale_N": 5.0}).spec
    for copy in (EnvSpec.from_json(spec.to_json()), pickle.loads(pickle.dumps(spec))):
        env = gym.make(copy).unwrapped
        assert env.configuration.control == "trajectory"
        assert env.simulation.device[0]["full_scale"] == 5.0


def test_importing_jawenv_imports_nothing_heavy():
    code = "import sys, jawenv; print(*sorted({name.split('.')[0] for name in sys.modules}))"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    heavy = {"torch", "matplotlib", "pymunk", "pygame", "numba", "scipy", "stable_baselines3", "pandas"}
    assert not heavy & set(loaded)


@pytest.mark.parametrize(("control", "sensors"), MODES)
def test_observations_stay_in_their_space_and_the_layout_covers_them(control, sensors, rng):
    env = gym.make_vec(ID, num_envs=4, control=control, sensors=sensors, episode_s=2.0)
    observation, _ = env.reset(seed=3)
    for _ in range(60):
        assert observation.dtype == np.float32
        assert env.observation_space.contains(observation)
        observation, reward, *_ = env.step(rng.uniform(-1, 1, (4, 4)).astype(np.float32))
        assert np.isfinite(reward).all()
    places = np.concatenate([np.arange(63)[part] for part in OBSERVATION_LAYOUT.values()])
    np.testing.assert_array_equal(places, np.arange(63))


def test_render_gives_a_frame():
    env = make(render_mode="rgb_array")
    env.reset(seed=0)
    env.step(NOTHING)
    frame = env.render()
    env.close()
    assert frame.shape == (720, 1280, 3)
    assert frame.dtype == np.uint8
    assert len(np.unique(frame.reshape(-1, 3), axis=0)) > 50


ARGUMENTS = [
    ({"speed": 1}, "argument 'speed' is unknown; allowed: control, sensors, reward, cohort, episode_s, control_hz, "),
    ({"control": "torque"}, "control is 'torque'; allowed: force, trajectory"),
    ({"sensors": 6}, "sensors is 6; allowed: pose, point"),
    ({"reward": "nats"}, "reward is 'nats'; allowed: uncertainty, bound, score"),
    ({"cohort": "cats"}, "cohort 'cats' is unknown; allowed: trismus, healthy, severe, one_sided, blockage, wide"),
    ({"episode_s": 0}, "episode_s is 0; allowed: a number, more than 0, at most 1e+06"),
    ({"episode_s": 0.01}, "episode_s is 0.01; allowed: at least one control period"),
    ({"comfort_weight": float("nan")}, "comfort_weight is nan; allowed: a number, 0 or more, at most 1e+06"),
    ({"control_hz": 30}, "control_hz is 30; allowed: 100 divided by a whole number"),
    ({"control_hz": 200}, "control_hz is 200; allowed: 100 divided by a whole number"),
    ({"track_bound": "yes"}, "track_bound is 'yes'; allowed: true or false"),
    ({"device": 5}, "device is 5; allowed: a mapping of its fields"),
    ({"device": {"colour": 1}}, "device.colour is not a field of Device; allowed: vertical_arm_mm, "),
    ({"device": {"lag_s": 0}}, "device.lag_s is 0; allowed: a finite number, more than 0"),
]


def assert_one_line(caught, message):
    """The whole message, or its beginning where the list of what is allowed goes on."""
    said = str(caught.value)
    assert "\n" not in said
    assert said == message or (message.endswith(", ") and said.startswith(message))


@pytest.mark.parametrize(("arguments", "message"), ARGUMENTS)
def test_an_unusable_argument_is_named(arguments, message):
    for form in (gym.make, gym.make_vec):
        with pytest.raises(jawenv.InputError) as caught:
            form(ID, **arguments)
        assert_one_line(caught, message)


def test_unusable_arguments_of_one_form_are_named():
    with pytest.raises(jawenv.InputError, match="^render_mode is 'ansi'; allowed: human, rgb_array$"):
        jawenv.envs.jaw.JawEnv(render_mode="ansi")
    for arguments, message in (
        ({"num_envs": 0}, "num_envs is 0; allowed: a whole number, 1 or more"),
        (
            {"num_envs": 2, "autoreset_mode": "later"},
            "autoreset_mode is 'later'; allowed: next_step, same_step, disabled",
        ),
        ({"num_envs": 2, "render_mode": "human"}, "render_mode is 'human'; allowed in the vector form: None"),
    ):
        with pytest.raises(jawenv.InputError) as caught:
            JawVectorEnv(**arguments)
        assert str(caught.value) == message


@pytest.mark.parametrize(
    ("action", "message"),
    [
        ([0.0, np.nan, 0.0, 0.0], "action[1] is nan; allowed: -1 to 1"),
        ([0.0, 0.0, 0.0, np.inf], "action[3] is inf; allowed: -1 to 1"),
        ([1.5, 0.0, 0.0, 0.0], "action[0] is 1.5; allowed: -1 to 1"),
        ([0.0, 0.0, 0.0], "action has shape (3,); allowed: (4,)"),
        ("open", "action is 'open'; allowed: numbers of shape (4,)"),
    ],
)
def test_an_unusable_action_is_named(action, message):
    env = make()
    env.reset(seed=0)
    before = env.simulation.worlds.tobytes()
    with pytest.raises(jawenv.InputError) as caught:
        env.step(action)
    assert str(caught.value) == message
    assert env.simulation.worlds.tobytes() == before


def test_an_unusable_action_of_many_is_named():
    env = gym.make_vec(ID, num_envs=2)
    env.reset(seed=0)
    with pytest.raises(jawenv.InputError, match=r"^action\[1, 2\] is -2.0; allowed: -1 to 1$"):
        env.step(np.array([[0, 0, 0, 0], [0, 0, -2, 0]]))
    with pytest.raises(jawenv.InputError, match=r"^action has shape \(4,\); allowed: \(2, 4\)$"):
        env.step(NOTHING)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"pose": 1}, "option 'pose' is unknown; allowed: patient"),
        ({"patient": 3}, "Patient: must hold a mapping of keys to values, not a number"),
        (
            {"patient": {"F_o_N": MUSCLES | {"masseter_left": -1.0}, "b": MUSCLES}},
            "Patient: F_o_N.masseter_left = -1.0 must be greater than 0",
        ),
        (
            {"patient": {"name": "limp", "F_o_N": dict.fromkeys(MUSCLES, 0.01), "b": MUSCLES}},
            "patient 'limp' has no rest pose within reach of the device, or a painless range of less than 5 mm; "
            "allowed: a jaw that rests less than 35 mm open and 5 mm aside",
        ),
    ],
)
def test_an_unusable_option_is_named(options, message):
    with pytest.raises(jawenv.InputError) as caught:
        make().reset(seed=0, options=options)
    assert str(caught.value) == message


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"options": {"patient": 1}}, "option 'patient' is unknown; allowed: patients, reset_mask"),
        ({"options": {"patients": [None]}}, "option patients has 1 entries; allowed: 2"),
        (
            {"options": {"reset_mask": [True, False]}},
            "option reset_mask is [True, False]; allowed: a bool array of shape (2,)",
        ),
        ({"seed": [1, 2, 3]}, "seed has 3 entries; allowed: an integer or 2 entries"),
    ],
)
def test_an_unusable_option_of_the_vector_form_is_named(arguments, message):
    with pytest.raises(jawenv.InputError) as caught:
        gym.make_vec(ID, num_envs=2).reset(**arguments)
    assert str(caught.value) == message


def test_step_and_render_need_a_reset():
    with pytest.raises(gym.error.ResetNeeded):
        gym.make(ID).step(NOTHING)
    with pytest.raises(gym.error.ResetNeeded):
        make().step(NOTHING)
    with pytest.raises(gym.error.ResetNeeded):
        make(render_mode="rgb_array").render()
    with pytest.raises(gym.error.ResetNeeded):
        gym.make_vec(ID, num_envs=2).step(np.zeros((2, 4)))
