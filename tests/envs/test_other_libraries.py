"""What other libraries do with an environment: strange arguments, infos as numbers, wrappers, limits of steps."""

import json

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.vector import AutoresetMode
from gymnasium.wrappers.vector import DictInfoToList

import jawenv
from jawenv.envs.jaw import JawEnv
from jawenv.envs.vector import JawVectorEnv

ID = "jawenv/Jaw-v3"
ACTION = np.array([0.3, 0.3, 0.1, 0.1], dtype=np.float32)
ACTIONS = np.tile(ACTION, (2, 1))


@pytest.mark.parametrize("form", [JawEnv, JawVectorEnv])
def test_an_unknown_argument_is_a_type_error_in_pythons_words(form):
    """Libraries try arguments of other environments, and take back what a ``TypeError`` of these words names."""
    with pytest.raises(jawenv.InputError) as caught:
        form(frameskip=1)
    assert isinstance(caught.value, TypeError)
    start = f"{form.__name__}.__init__() got an unexpected keyword argument 'frameskip'; allowed: control, sensors, "
    assert str(caught.value).startswith(start)


@pytest.mark.parametrize("arguments", [{}, {"track_bound": True, "control": "targets"}])
def test_infos_are_flat_and_hold_pythons_numbers_and_arrays(arguments):
    env = gym.make(ID, **arguments)
    infos = [env.reset(seed=0)[1], *(env.step(ACTION)[4] for _ in range(3))]
    assert all(list(info) == list(infos[0]) for info in infos)
    for info in infos:
        arrays = {key: value for key, value in info.items() if isinstance(value, np.ndarray)}
        assert arrays["episode_key"].dtype == np.int64
        kinds = {value.dtype for key, value in arrays.items() if key != "episode_key"}
        assert all(value.ndim > 0 for value in arrays.values()) and kinds == {np.dtype(np.float64)}
        scalars = {key: value for key, value in info.items() if key not in arrays}
        assert {key for key, value in scalars.items() if type(value) is not float} == {"violation", "settled"}
        assert type(scalars["violation"]) is type(scalars["settled"]) is bool
        assert json.loads(json.dumps(scalars)) == scalars
    assert env.get_wrapper_attr("parameter_names") == jawenv.PARAMETER_NAMES


@pytest.mark.parametrize("mode", list(AutoresetMode))
def test_infos_become_lists(mode):
    """With the last infos of ended episodes where the mode has them."""
    env = DictInfoToList(gym.make_vec(ID, num_envs=2, control="force", episode_s=0.15, autoreset_mode=mode))
    single = gym.make(ID, control="force", episode_s=0.15)
    _, infos = env.reset(seed=0)
    _, info = single.reset(seed=0)
    for k in range(3):
        assert len(infos) == 2 and list(infos[0]) == list(info)
        np.testing.assert_array_equal(infos[0]["belief_cov"], info["belief_cov"])
        _, _, _, truncated, infos = env.step(ACTIONS)
        observation, *_, info = single.step(ACTION)
        assert truncated.all() == (k == 2)
    if mode == AutoresetMode.SAME_STEP:
        np.testing.assert_array_equal(infos[0]["final_obs"], observation)
        assert list(infos[0]["final_info"]) == list(info)
        assert (infos[0]["final_info"]["time"], infos[0]["time"]) == (info["time"], 0.0)


def test_the_last_infos_are_those_of_the_worlds_that_ended():
    env = gym.make_vec(ID, num_envs=2, control="force", episode_s=0.1, autoreset_mode="same_step")
    env.reset(seed=0)
    env.step(ACTIONS)
    env.reset(options={"reset_mask": np.array([True, False])})
    info = env.step(ACTIONS)[4]
    for key in ("final_obs", "final_info"):
        np.testing.assert_array_equal(info[f"_{key}"], [False, True])
    np.testing.assert_array_equal(info["final_info"]["_time"], [False, True])


@pytest.mark.parametrize("limit", [None, -1, 2, 50])
def test_a_limit_of_steps_is_that_of_a_time_limit(limit):
    arguments = {"control": "force", "episode_s": 0.2, "max_episode_steps": limit}
    single, many = gym.make(ID, **arguments), gym.make_vec(ID, num_envs=2, **arguments)
    single.reset(seed=0)
    many.reset(seed=0)
    for k in range(1, 5):
        expected = single.step(ACTION)[3]
        np.testing.assert_array_equal(many.step(ACTIONS)[3], expected)
        assert expected == (k == min(4, limit if limit == 2 else 4))
        if expected:
            break


@pytest.mark.parametrize(
    "action",
    [ACTION, ACTION.astype(np.float64), ACTION.astype(np.float16), ACTION.tolist(), tuple(ACTION.tolist())],
    ids=["float32", "float64", "float16", "list", "tuple"],
)
def test_forms_of_an_action(action):
    env, plain = gym.make(ID).unwrapped, gym.make(ID).unwrapped
    for each in (env, plain):
        each.reset(seed=0)
    np.testing.assert_array_equal(env.step(action)[0], plain.step(np.array([float(part) for part in action]))[0])


def test_an_action_that_overshoots_by_rounding_is_clipped():
    env, plain = gym.make(ID).unwrapped, gym.make(ID).unwrapped
    for each in (env, plain):
        each.reset(seed=0)
    over = np.full(4, 1.0 + 5e-7)
    np.testing.assert_array_equal(env.step(over)[0], plain.step(np.ones(4))[0])
    assert (over > 1.0).all()
