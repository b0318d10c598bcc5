"""Effects beyond the thesis as arguments of the environment: off by default, on the truth only, in every plant."""

import gymnasium as gym
import numpy as np
import pytest

PLANTS = ["jawenv/Jaw-v3", "jawenv/JawSagittal-v3"]
EFFECTS = [
    {"reflex_gain": 1.0},
    {"creep_share": 0.3},
    {"attachment_error": 0.3},
    {"fossa_error": 0.1},
    {"mass_error": 0.1},
    {"inertia_error": 0.1},
    {"damping_error": 0.2},
    {"centre_of_mass_error_mm": 4.0},
    {"head_tilt_error_deg": 3.0},
    {"mouthpiece_error_mm": 0.5},
    {"mouthpiece_error_deg": 0.5},
    {"cell_error_deg": 0.5},
    {"articular_stiffness_N_m": 3000.0, "articular_onset": 0.1},
    {"cell_bias_N": 0.1},
    {"encoder_play_mm": 0.3},
    {"lost_share": 0.1},
    {"frozen_share": 0.1},
]
STEPS = 40


def played(env_id, **arguments):
    env = gym.make(env_id, episode_s=STEPS / 20, **{"control": "force", **arguments})
    observation, info = env.reset(seed=3)
    seen, infos = [observation], [info]
    for k in range(STEPS - 1):
        push = np.array([0.4, 0.4, 0.1, 0.1]) * np.sin(np.pi * k / STEPS)
        observation, *_, info = env.step(push.astype(np.float32))
        seen.append(observation)
        infos.append(info)
    return np.array(seen), infos, env.unwrapped.simulation


@pytest.fixture(scope="module", params=PLANTS)
def plain(request):
    return request.param, *played(request.param)


def test_no_effect_is_the_plain_environment(plain):
    env_id, seen, _, _ = plain
    again, _, _ = played(env_id, reality={})
    np.testing.assert_array_equal(seen, again)


@pytest.mark.parametrize("effect", EFFECTS, ids=lambda effect: next(iter(effect)))
def test_each_effect_acts_on_the_truth_and_the_filter_does_not_know(plain, effect):
    env_id, seen, infos, simulation = plain
    changed, with_effect, other = played(env_id, reality=effect)
    assert not np.array_equal(seen, changed)
    np.testing.assert_array_equal(infos[-1]["truth"], with_effect[-1]["truth"])
    np.testing.assert_array_equal(simulation.models, other.models)


def test_the_joint_opposes_the_end_of_opening(plain):
    env_id, _, infos, _ = plain
    _, stiff, _ = played(env_id, reality={"articular_stiffness_N_m": 3000.0, "articular_onset": 0.1})
    assert max(i["comfort_opening"] for i in stiff) < max(i["comfort_opening"] for i in infos)
