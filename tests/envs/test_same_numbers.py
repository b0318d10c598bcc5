"""The same seed gives the same episode: alone, in company, on any number of threads, in another process."""

import hashlib
import os

import gymnasium as gym
import numba
import numpy as np
import pytest
from gymnasium.vector import AutoresetMode, SyncVectorEnv

import jawenv
from jawenv.controls import CONTROLS
from jawenv.envs.registration import ENVIRONMENTS
from jawenv.kernels.compiled import WORLDS_AT_ONCE
from tests.processes import python

ID = "jawenv/Jaw-v3"
THREADS = sorted({1, min(2, numba.config.NUMBA_NUM_THREADS)})


def actions(number, steps=40):
    """Smooth, different in every world, alike for a world whatever the company."""
    t, world = np.arange(steps)[:, None, None] / 20, np.arange(number)[None, :, None]
    return (0.4 * np.sin((2 + 0.3 * world + np.arange(4)) * t + np.arange(4))).astype(np.float32)


def random_targets(number):
    return np.random.default_rng(1).uniform(-1.0, 1.0, (30, number, 4)).astype(np.float32)


@pytest.fixture
def threads():
    before = numba.get_num_threads()
    yield numba.set_num_threads
    numba.set_num_threads(before)


@pytest.mark.parametrize(
    ("env_id", "control", "number", "count"),
    [(env_id, control, 2, 1) for env_id in ENVIRONMENTS for control in CONTROLS]
    + [(ID, "trajectory", 2 * WORLDS_AT_ONCE + 3, count) for count in THREADS],  # shared out to threads
)
def test_world_i_equals_the_single_environment_with_its_seed_bit_for_bit(env_id, control, number, count, threads):
    """For every model in every control, and in company of any size on any number of threads."""
    threads(count)
    arguments = {"control": control, "reward": "bound", "comfort_weight": 0.5}
    many = gym.make_vec(env_id, num_envs=number, **arguments)
    alone = [gym.make(env_id, **arguments) for _ in range(number)]
    together, info = many.reset(seed=11)
    started = [env.reset(seed=11 + i) for i, env in enumerate(alone)]
    for i, (observation, single) in enumerate(started):
        np.testing.assert_array_equal(together[i], observation)
        np.testing.assert_array_equal(info["truth"][i], single["truth"])
    for action in random_targets(number) if control == "targets" else actions(number):
        together, rewards, terminated, truncated, info = many.step(action)
        for i, env in enumerate(alone):
            observation, reward, ended, cut_off, single = env.step(action[i])
            np.testing.assert_array_equal(together[i], observation)
            assert (rewards[i], terminated[i], truncated[i]) == (reward, ended, cut_off)
            assert list(info) == [*single, *(f"_{key}" for key in single)]
            for key, value in single.items():
                np.testing.assert_array_equal(info[key][i], value, err_msg=key)


def test_the_next_episode_of_a_seed_is_another_one_and_repeats_too():
    env = gym.make(ID, control="force")

    def two_episodes():
        return env.reset(seed=5)[1]["truth"], env.reset()[1]["truth"]

    first, second = two_episodes(), two_episodes()
    np.testing.assert_array_equal(first, second)
    assert not np.array_equal(first[0], first[1])


_EPISODE = """
import hashlib, gymnasium, jawenv, numpy
env = gymnasium.make("jawenv/Jaw-v3", control="force")
observations = [env.reset(seed=8)[0]]
for k in range(20):
    observations.append(env.step(numpy.full(4, 0.2 * numpy.sin(k), dtype=numpy.float32))[0])
print(hashlib.sha256(numpy.array(observations).tobytes()).hexdigest())
"""


def test_the_same_seed_gives_the_same_episode_in_another_process():
    env = gym.make(ID, control="force")
    observations = [env.reset(seed=8)[0]]
    for k in range(20):
        observations.append(env.step(np.full(4, 0.2 * np.sin(k), dtype=np.float32))[0])
    other = python("-c", _EPISODE).stdout.strip()
    assert other == hashlib.sha256(np.array(observations).tobytes()).hexdigest()


_FORK = """
import os, gymnasium, jawenv, numba, numpy
numba.set_num_threads(min(2, numba.config.NUMBA_NUM_THREADS))
env = gymnasium.make_vec("jawenv/Jaw-v3", num_envs=20, control="force")
env.reset(seed=8)
actions = numpy.zeros((20, 4), dtype=numpy.float32)
env.step(actions)
child = os.fork()
observation = env.step(actions)[0]
if child == 0:
    print(observation.sum(), flush=True)
    os._exit(0)
assert os.waitpid(child, 0)[1] == 0
print(observation.sum())
"""


@pytest.mark.skipif(not hasattr(os, "fork"), reason="the system has no fork")
def test_a_forked_process_has_threads_of_its_own():
    """Workers of Gymnasium's AsyncVectorEnv are forked: the parent's threads are not there."""
    first, second = python("-c", _FORK).stdout.split()
    assert first == second


@pytest.mark.parametrize("mode", list(AutoresetMode))
def test_autoreset_is_gymnasiums_own(mode):
    """Step by step equal to SyncVectorEnv over single environments, through several ends of episodes."""
    arguments = {"episode_s": 0.2, "reward": "score"}
    native = gym.make_vec(ID, num_envs=3, autoreset_mode=mode, **{"control": "force", **arguments})
    reference = SyncVectorEnv([lambda: gym.make(ID, **{"control": "force", **arguments})] * 3, autoreset_mode=mode)
    np.testing.assert_array_equal(native.reset(seed=2)[0], reference.reset(seed=2)[0])
    ended = False
    for k, action in enumerate(actions(3, 14)):
        if mode == AutoresetMode.DISABLED and ended:
            mask = np.array([True, True, True])
            options = {"reset_mask": mask}
            np.testing.assert_array_equal(native.reset(options=options)[0], reference.reset(options=options)[0])
        mine, theirs = native.step(action), reference.step(action)
        for actual, expected in zip(mine[:4], theirs[:4], strict=True):
            np.testing.assert_array_equal(actual, expected)
        np.testing.assert_array_equal(mine[4]["truth"], theirs[4]["truth"])
        ended = bool((mine[2] | mine[3]).any())
        if mode == AutoresetMode.SAME_STEP:
            assert ended == (k % 4 == 3) == ("final_obs" in mine[4]) == ("final_obs" in theirs[4])
        if mode == AutoresetMode.SAME_STEP and ended:
            np.testing.assert_array_equal(mine[4]["_final_obs"], theirs[4]["_final_obs"])
            np.testing.assert_array_equal(np.stack(mine[4]["final_obs"]), np.stack(theirs[4]["final_obs"]))
            for key in ("truth", "belief_cov", "time"):
                np.testing.assert_array_equal(mine[4]["final_info"][key], theirs[4]["final_info"][key])
            np.testing.assert_array_equal(mine[4]["_final_info"], theirs[4]["_final_info"])


def test_a_disabled_world_stands_still_until_its_mask_resets_it():
    env = gym.make_vec(ID, num_envs=3, episode_s=0.1, autoreset_mode="disabled", control="force")
    first, _ = env.reset(seed=0)
    env.step(np.zeros((3, 4)))
    last, _, _, truncated, _ = env.step(np.full((3, 4), 0.3))
    assert truncated.all()
    frozen, reward, _, truncated, _ = env.step(np.ones((3, 4)))
    np.testing.assert_array_equal(frozen, last)
    np.testing.assert_array_equal(reward, 0.0)
    assert truncated.all()
    mask = np.array([False, True, False])
    after, info = env.reset(seed=0, options={"reset_mask": mask})
    np.testing.assert_array_equal(after[1], first[1])
    np.testing.assert_array_equal(after[~mask], last[~mask])
    np.testing.assert_array_equal(info["_truth"], mask)
    _, _, _, truncated, info = env.step(np.zeros((3, 4)))
    np.testing.assert_array_equal(truncated, ~mask)
    np.testing.assert_allclose(info["time"], [0.1, 0.05, 0.1])


def test_a_given_patient_is_the_truth_and_only_of_this_episode():
    patient = jawenv.Patient(
        name="Ann", F_o_N=dict.fromkeys(jawenv.MUSCLE_NAMES, 1.5), b=dict.fromkeys(jawenv.MUSCLE_NAMES, 6.0)
    )
    env = gym.make(ID, control="force")
    _, info = env.reset(seed=0, options={"patient": patient})
    np.testing.assert_array_equal(info["truth"], patient.log_parameters())
    as_mapping = {"F_o_N": dict(patient.F_o_N), "b": dict(patient.b)}
    np.testing.assert_array_equal(env.reset(options={"patient": as_mapping})[1]["truth"], patient.log_parameters())
    assert not np.array_equal(env.reset()[1]["truth"], patient.log_parameters())
    many = gym.make_vec(ID, num_envs=2, control="force")
    _, info = many.reset(seed=0, options={"patients": [None, patient]})
    np.testing.assert_array_equal(info["truth"][1], patient.log_parameters())
    np.testing.assert_array_equal(info["truth"][0], env.reset(seed=0)[1]["truth"])
