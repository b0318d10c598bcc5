"""Every rung of the ladder keeps what Gymnasium, stable-baselines3 and the default environment promise."""

import gymnasium as gym
import numpy as np
import pytest
from numpy_model import step
from recorded import recording

import jawenv
from jawenv.device.device import device_of
from jawenv.envs.observation import Parts
from jawenv.envs.registration import ENVIRONMENTS
from jawenv.ladder import MODELS

OTHERS = [env_id for env_id, name in ENVIRONMENTS.items() if name != "jaw"]
STEPS = 30


def actions(number):
    t, world = np.arange(STEPS)[:, None, None] / 20, np.arange(number)[None, :, None]
    return (0.4 * np.sin((2 + 0.3 * world + np.arange(4)) * t + np.arange(4))).astype(np.float32)


def played(env_id, number=2, seed=5, **arguments):
    """Observations, rewards and the last info of a short episode of some worlds."""
    env = gym.make_vec(env_id, num_envs=number, **{"control": "force", **arguments})
    seen, rewards = [env.reset(seed=seed)[0]], []
    for action in actions(number):
        observation, reward, _, _, info = env.step(action)
        seen.append(observation)
        rewards.append(reward)
    return np.array(seen), np.array(rewards), info


def test_the_registry_is_the_ladder():
    assert {env_id: model.name for model in MODELS.values() for env_id in [model.env_id]} == ENVIRONMENTS


def test_an_anatomy_known_within_sds_comes_with_a_disturbance_that_lasts():
    configuration = gym.make("jawenv/JawImaged-v3").unwrapped.simulation.configuration
    assert configuration.build_knowledge() == jawenv.anatomy.knowledge.IMAGED
    assert device_of(configuration.device) == jawenv.Device(unmodelled_time_s=0.5)


@pytest.mark.parametrize("env_id", OTHERS)
def test_names_and_sizes_follow_the_muscles(env_id):
    seen, _, info = played(env_id)
    muscles = MODELS[ENVIRONMENTS[env_id]].muscles
    parameters = len(muscles.parameter_names)
    for env in (gym.make(env_id), gym.make_vec(env_id, num_envs=2)):
        assert env.unwrapped.parameter_names == muscles.parameter_names
    assert info["belief_cov"].shape == (2, parameters, parameters)
    assert info["truth"].shape == (2, parameters)
    assert seen.shape[2] == max(place.stop for place in Parts(parameters).layout.values())
    assert (info["information_claimed"] > 1.0).all(), "a second and a half of motion teaches something"


@pytest.mark.parametrize("env_id", ["jawenv/JawHinge-v3", "jawenv/JawSagittal-v3"])
def test_planar_models_stay_in_their_plane(env_id):
    _, _, info = played(env_id)
    held = [1, 3, 4, 6, 7, 9] + ([0, 5] if "Hinge" in env_id else [])
    np.testing.assert_array_equal(info["jaw_state"][:, held], 0.0)
    assert np.abs(info["jaw_state"][:, 2]).max() > 1e-3


def test_a_patient_has_the_muscles_of_the_model():
    env = gym.make("jawenv/JawSides-v3", control="force")
    law = {"F_o_N": {"left": 3.0, "right": 1.0}, "b": {"left": 7.0, "right": 7.0}}
    _, info = env.reset(seed=0, options={"patient": law})
    np.testing.assert_allclose(np.exp(info["truth"]), [3.0, 7.0, 1.0, 7.0])
    whole = jawenv.Patient(F_o_N=dict.fromkeys(jawenv.MUSCLE_NAMES, 1.0), b=dict.fromkeys(jawenv.MUSCLE_NAMES, 7.0))
    with pytest.raises(jawenv.InputError):
        env.reset(options={"patient": whole})


def test_the_plant_in_contact_moves_as_the_smooth_one_does():
    """Under the same wrenches: friction and the chatter of contact change the motion by little."""
    for record in recording("sagittal", patients=2, seconds=3.0).records:
        smooth = record.states[0]
        for wrench in record.wrenches:
            smooth = step(record.jaw, np.concatenate([smooth, record.truth, [0.0]]), wrench, np.zeros(6), record.dt)
        np.testing.assert_allclose(record.states[-1][0], smooth[0], atol=0.3e-3)
        np.testing.assert_allclose(record.states[-1][2], smooth[2], atol=0.01)
        assert np.ptp(record.states[:, 2]) > 0.05
