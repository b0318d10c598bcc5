"""What Gymnasium asks of an environment, and what a user gets told who asks for the impossible."""

import json
from dataclasses import fields

import gymnasium as gym
import numpy as np
import pytest

import jawenv
from jawenv.anatomy import COHORTS, Cohort
from jawenv.controls import CONTROLS
from jawenv.envs.configuration import Configuration, configure
from jawenv.envs.jaw import JawEnv
from jawenv.envs.observation import OBSERVATION_LAYOUT
from jawenv.envs.registration import ENVIRONMENTS
from jawenv.envs.vector import JawVectorEnv
from tests.processes import python

ID = "jawenv/Jaw-v3"
MODES = [(control, sensors) for control in CONTROLS for sensors in ("pose", "point")]
MUSCLES = dict.fromkeys(jawenv.MUSCLE_NAMES, 1.0)
NOTHING = np.zeros(4, dtype=np.float32)


def make(**arguments):
    """The bare environment, without Gymnasium's wrappers."""
    return gym.make(ID, **{"control": "force", **arguments}).unwrapped


NOT_DEFAULT = {
    "control": "force",
    "sensors": "point",
    "reward": "worst",
    "cohort": Cohort.from_dict({**COHORTS["wide"].to_dict(), "name": "mine"}),
    "episode_s": 12.0,
    "control_hz": 10.0,
    "comfort_weight": 2.0,
    "comfort_limit_s": 0.03,
    "comfort_budget_s": 0.03,
    "track_bound": True,
    "info": "light",
    "record": True,
    "device": {"full_scale_N": 5.0},
    "reality": {"creep_share": 0.2},
    "model": "sides",
    "estimator": "none",
    "knowledge": {"mass": 0.1},
    "force_sensor": "straps",
    "comfort": {"force_N": 9.0},
    "anatomy": {
        "mandible": {"mass_kg": 0.4},
        "attachments": {"superficial_masseter_left": {"origin_m": [0.01, 0.05, 0.0]}},
    },
    "plant": "my_module:MyJaw",
    "asked": "left",
}


def test_every_argument_is_described_and_comes_back_from_a_mapping_of_plain_values():
    assert NOT_DEFAULT.keys() == {each.name for each in fields(Configuration)}
    for name, value in NOT_DEFAULT.items():
        default, other = Configuration(), configure({name: value})
        assert name in other.differences(default) and other.digest != default.digest
        assert Configuration.from_mapping(json.loads(json.dumps(other.to_mapping()))) == other
        assert all(each.metadata["help"].endswith(".") for each in fields(Configuration))
    whole = configure({name: NOT_DEFAULT[name] for name in NOT_DEFAULT.keys() - {"comfort_budget_s"}})  # of targets
    assert Configuration.from_mapping(json.loads(json.dumps(whole.to_mapping()))) == whole


@pytest.mark.parametrize("env_id", [*ENVIRONMENTS, "jawenv/JawImaged-v3"])
def test_a_configuration_knows_its_id(env_id):
    made = gym.make(env_id).unwrapped.configuration
    again = Configuration.from_mapping({"env": env_id})
    assert made == again and made.env_id == env_id and not made.differences(again)
    others = {"control": "targets", "sensors": "pose", "cohort": "trismus", "episode_s": 30.0}
    assert made.to_mapping() == {"env": env_id, **others}


def test_numpys_numbers_are_numbers():
    """The same episode as with Python's."""
    plain = {"episode_s": 1, "control_hz": 10, "comfort_weight": 2, "device": {"full_scale_N": 5}}
    numpys = {
        "episode_s": np.int64(1),
        "control_hz": np.float32(10),
        "comfort_weight": np.uint8(2),
        "track_bound": np.bool_(False),
        "device": {"full_scale_N": np.float64(5)},
        "reality": {"creep_share": np.float32(0)},
    }
    seen = []
    for arguments, seed in ((plain, 3), (numpys, np.int64(3))):
        env = make(**arguments)
        env.reset(seed=seed)
        seen.append(env.step(NOTHING)[0])
        assert type(env.configuration.episode_s) is float
    np.testing.assert_array_equal(*seen)
    together = gym.make_vec(ID, num_envs=np.int64(2), **{"control": "force", **numpys})
    from_number, _ = together.reset(seed=np.uint32(3))
    from_entries, _ = together.reset(seed=np.array([3, 4]))
    np.testing.assert_array_equal(from_number, from_entries)


@pytest.mark.parametrize("seed", [-1, 1.0, "one", True, np.float64(2)])
def test_an_unusable_seed_is_named(seed):
    assert_refused(f"seed is {seed!r}; allowed: a whole number, 0 or more", make().reset, seed=seed)


def test_importing_jawenv_imports_nothing_heavy():
    code = "import sys, jawenv; print(*sorted({name.split('.')[0] for name in sys.modules}))"
    heavy = {"torch", "matplotlib", "pymunk", "pygame", "numba", "scipy", "stable_baselines3", "pandas"}
    assert not heavy & set(python("-c", code).stdout.split())


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


LAW = {"F_o_N": 1.2, "F_o_sd": 0.5, "b": 7.0, "b_sd": 0.3}


def stiff_left(**change):
    return {"groups": [{"left": LAW | change, "right": LAW}]}


ARGUMENTS = [
    ({"control": "torque"}, "control is 'torque'; allowed: force, trajectory, targets"),
    ({"sensors": 6}, "sensors is 6; allowed: pose, point"),
    ({"reward": "nats"}, "reward is 'nats'; allowed: uncertainty, bound, score, worst, mixed"),
    ({"cohort": "cats"}, "cohort is 'cats'; allowed: trismus, healthy, severe, one_sided, patchy, blockage, "),
    ({"cohort": 5}, "cohort is 5; allowed: a name, a Cohort, a mapping of its fields, or a file"),
    ({"cohort": {"groups": []}}, "Cohort: groups is []; allowed: at least 1 item after validation, not 0"),
    ({"cohort": "no/such.toml"}, "no/such.toml: no such file"),
    ({"cohort": stiff_left(b_sd=np.nan)}, "Cohort: groups.0.left.b_sd is nan; allowed: a finite number"),
    ({"cohort": stiff_left(b_sd=0)}, "Cohort: groups.0.left.b_sd is 0; allowed: greater than 0"),
    ({"cohort": stiff_left(c=1)}, "Cohort: unknown key 'groups.0.left.c'; allowed: F_o_N, F_o_sd, b, b_sd"),
    ({"cohort": stiff_left(b_sd=2)}, "cohort 'cohort': sd of log b = 2; allowed: more than 0, at most 1.5"),
    ({"cohort": stiff_left(F_o_N=80)}, "cohort 'cohort': F_o_N = 80 with a log sd of 0.5 is drawn larger than 200"),
    ({"episode_s": 0}, "episode_s is 0; allowed: a number, more than 0, at most 1e+06"),
    ({"episode_s": 0.01}, "episode_s is 0.01; allowed: at least one control period"),
    ({"comfort_weight": float("nan")}, "comfort_weight is nan; allowed: a number, 0 or more, at most 1e+06"),
    ({"control_hz": 30}, "control_hz is 30; allowed: 20 divided by a whole number"),
    ({"control": "force", "control_hz": 30}, "control_hz is 30; allowed: 100 divided by a whole number"),
    ({"track_bound": "yes"}, "track_bound is 'yes'; allowed: true or false"),
    ({"control_hz": 1e-320}, "control_hz is 9.99989e-321; allowed: 20 divided by a whole number"),
    ({"episode_s": True}, "episode_s is True; allowed: a number, more than 0, at most 1e+06"),
    ({"force_sensor": "spring"}, "force_sensor is 'spring'; allowed: cell, motors, straps"),
    ({"device": 5}, "device is 5; allowed: a Device, a mapping of its fields, or the path of a file with them"),
    ({"reality": 5}, "reality is 5; allowed: a Reality, a mapping of its fields, or the path of a file with them"),
    ({"reality": {"magic": 1.0}}, "reality.magic is not a field of Reality; allowed: reflex_gain, "),
    ({"reality": {"creep_share": 1.5}}, "reality.creep_share is 1.5; allowed: a finite number, 0 or more, at most 0.9"),
    ({"device": {"colour": 1}}, "device.colour is not a field of Device; allowed: vertical_arm_mm, "),
    ({"device": {"lag_s": 0}}, "device.lag_s is 0; allowed: a finite number, more than 0, at most 2"),
]


def assert_refused(message, call, *given, **named):
    """In one line that begins so."""
    with pytest.raises(jawenv.InputError) as caught:
        call(*given, **named)
    assert str(caught.value).startswith(message) and "\n" not in str(caught.value)


@pytest.mark.parametrize(("arguments", "message"), ARGUMENTS)
def test_an_unusable_argument_is_named(arguments, message):
    for form in (gym.make, gym.make_vec):
        assert_refused(message, form, ID, **arguments)


@pytest.mark.parametrize(
    ("form", "arguments", "message"),
    [
        (JawEnv, {"render_mode": "ansi"}, "render_mode is 'ansi'; allowed: human, rgb_array"),
        (JawVectorEnv, {"max_episode_steps": 0}, "max_episode_steps is 0; allowed: a whole number, 1 or more, or None"),
        (JawVectorEnv, {"max_episode_steps": 1.5}, "max_episode_steps is 1.5; allowed: a whole number, 1 or more, "),
        (JawVectorEnv, {"num_envs": 0}, "num_envs is 0; allowed: a whole number, 1 or more"),
        (JawVectorEnv, {"num_envs": 2, "autoreset_mode": "later"}, "autoreset_mode is 'later'; allowed: next_step, "),
        (JawVectorEnv, {"num_envs": 2, "render_mode": "human"}, "render_mode is 'human'; allowed in the vector form: "),
    ],
)
def test_unusable_arguments_of_one_form_are_named(form, arguments, message):
    assert_refused(message, form, control="force", **arguments)


@pytest.mark.parametrize(
    ("action", "message"),
    [
        ([0.0, np.nan, 0.0, 0.0], "action[1] is nan; allowed: -1 to 1"),
        ([0.0, 0.0, 0.0, np.inf], "action[3] is inf; allowed: -1 to 1"),
        ([1.5, 0.0, 0.0, 0.0], "action[0] is 1.5; allowed: -1 to 1"),
        (np.full(4, 0.5j), "action is array([0.+0.5j, 0.+0.5j, 0.+0.5j, 0.+0.5j]); allowed: numbers of shape (4,)"),
        (["0", "0", "0", "0"], "action is ['0', '0', '0', '0']; allowed: numbers of shape (4,)"),
        ([0.0, 0.0, 0.0], "action has shape (3,); allowed: (4,)"),
        ("open", "action is 'open'; allowed: numbers of shape (4,)"),
    ],
)
def test_an_unusable_action_is_named(action, message):
    env = make()
    env.reset(seed=0)
    before = env.simulation.worlds.tobytes()
    assert_refused(message, env.step, action)
    assert env.simulation.worlds.tobytes() == before


def test_an_unusable_action_of_many_is_named():
    env = gym.make_vec(ID, num_envs=2, control="force")
    env.reset(seed=0)
    with pytest.raises(jawenv.InputError):
        env.step(np.array([[0, 0, 0, 0], [0, 0, -2, 0]]))
    with pytest.raises(jawenv.InputError):
        env.step(NOTHING)


FEW = dict.fromkeys(MUSCLES, 0.01)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"pose": 1}, "option 'pose' is unknown; allowed: patient, episode_key, asked"),
        ({"patient": 3}, "option patient is 3; allowed: a Patient, a mapping of its fields, or the path of a file"),
        ({"patient": "no/such.json"}, "no/such.json: no such file"),
        ({"patient": {"F_o_N": FEW | {"masseter_left": -1.0}, "b": MUSCLES}}, "Patient: F_o_N.masseter_left is -1.0; "),
        ({"patient": {"name": "limp", "F_o_N": FEW, "b": MUSCLES}}, "patient 'limp' has no rest pose within reach"),
    ],
)
def test_an_unusable_option_is_named(options, message):
    assert_refused(message, make().reset, seed=0, options=options)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"options": {"patient": 1}}, "option 'patient' is unknown; allowed: patients, reset_mask, episode_keys, "),
        ({"options": {"patients": [None]}}, "option patients has 1 entries; allowed: 2"),
        ({"options": {"patients": "ab"}}, "option patients is 'ab'; allowed: a sequence of 2 entries"),
        ({"options": {"patients": [None, 3]}}, "option patients[1] is 3; allowed: a Patient, a mapping of its fields"),
        ({"options": {"reset_mask": [True, False]}}, "option reset_mask is [True, False]; allowed: a bool array of "),
        ({"seed": [1, 2, 3]}, "seed has 3 entries; allowed: an integer or 2 entries"),
        ({"seed": -1}, "seed is -1; allowed: a whole number, 0 or more"),
    ],
)
def test_an_unusable_option_of_the_vector_form_is_named(arguments, message):
    assert_refused(message, gym.make_vec(ID, num_envs=2, control="force").reset, **arguments)


def test_step_and_render_need_a_reset():
    with pytest.raises(gym.error.ResetNeeded):
        gym.make(ID, control="force").step(NOTHING)
    with pytest.raises(gym.error.ResetNeeded):
        make().step(NOTHING)
    with pytest.raises(gym.error.ResetNeeded):
        make(render_mode="rgb_array").render()
    with pytest.raises(gym.error.ResetNeeded):
        gym.make_vec(ID, num_envs=2, control="force").step(np.zeros((2, 4)))


@pytest.mark.parametrize("reason", ["truncated", "terminated"])
def test_a_step_after_the_end_warns_and_changes_nothing(reason):
    """Gymnasium's classic control warns too; here nothing goes on either."""
    soft = {"stop_stiffness_N_m": 1.0, "stop_damping_N_s_m": 1e-3, "brake_N_s_m": 1e-3, "full_scale_N": 10.0}
    ending = {"episode_s": 0.1, "record": True} if reason == "truncated" else {"device": soft, "cohort": "healthy"}
    env = make(**ending)
    env.reset(seed=1)
    ended = (False, False)
    while not any(ended):
        observation, _, *ended, info = env.step(np.array([1, 1, 0, 0], dtype=np.float32))
    assert ended == ([True, False] if reason == "terminated" else [False, True])
    before = env.simulation.worlds.tobytes()
    for _ in range(5):
        with pytest.warns(UserWarning, match="after the end of the episode does nothing; call reset"):
            again, reward, *flags, after = env.step(NOTHING)
        np.testing.assert_array_equal(again, observation)
        assert (reward, flags, after["time"]) == (0.0, ended, info["time"])
        np.testing.assert_array_equal(after["belief_cov"], info["belief_cov"])
    assert env.simulation.worlds.tobytes() == before
    env.reset()
    assert env.step(NOTHING)[2:4] == (False, False)
