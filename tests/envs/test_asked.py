"""Episodes that ask for some muscles: what is drawn, seen, paid for and recorded."""

import copy

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

import jawenv
from jawenv.envs.observation import Parts
from jawenv.envs.registration import ENVIRONMENTS

ID = "jawenv/Jaw-v3"
PLACE = Parts(12, asked=True).layout
OPEN = np.array([0.9, 0.9, 0.4, 0.0], dtype=np.float32)


def make(**arguments):
    return gym.make(ID, **{"asked": "random", "episode_s": 2.0, **arguments})


def test_an_episodes_key_draws_one_muscle_and_moves_nothing_else():
    env, plain = make(), gym.make(ID, episode_s=2.0)
    seen = []
    for seed in range(20):
        observation, info = env.reset(seed=seed)
        np.testing.assert_array_equal(observation[:63], plain.reset(seed=seed)[0])
        np.testing.assert_array_equal(observation[PLACE["asked"]], info["asked"])
        assert info["asked"].sum() == 1 and observation[PLACE["discomfort"]] == 0.0
        again = env.reset(options={"episode_key": info["episode_key"]})[1]
        np.testing.assert_array_equal(again["asked"], info["asked"])
        seen.append(int(info["asked"].argmax()))
        np.testing.assert_array_equal(env.step(OPEN)[0][:63], plain.step(OPEN)[0])
    assert set(seen) == set(range(6))
    check_env(env.unwrapped, skip_render_check=True)


def test_a_muscle_a_word_and_an_option():
    names = jawenv.MUSCLE_NAMES
    assert make(asked="masseter_right").reset(seed=0)[1]["asked"].tolist() == [
        name == "masseter_right" for name in names
    ]
    env = make(asked="left")
    assert env.reset(seed=0)[1]["asked"].tolist() == [name.endswith("left") for name in names]
    assert env.reset(options={"asked": "pterygoid"})[1]["asked"].tolist() == ["pterygoid" in name for name in names]
    assert env.reset()[1]["asked"].tolist() == [name.endswith("left") for name in names]


@pytest.mark.parametrize(
    ("arguments", "options", "message"),
    [
        ({"asked": "cat"}, None, "asked is 'cat'; allowed: random, masseter_left"),
        ({"asked": 3}, None, "asked is 3; allowed: random, masseter_left"),
        ({"asked": "left"}, {"asked": "lef"}, "option asked is 'lef'; did you mean left?"),
        ({}, {"asked": "left"}, "option asked is 'left'; allowed in an environment with the argument asked alone"),
    ],
)
def test_an_unusable_question_is_named(arguments, options, message):
    with pytest.raises(jawenv.InputError) as caught:
        gym.make(ID, **arguments).reset(seed=0, options=options)
    assert str(caught.value).startswith(message.partition(" did you")[0])


def test_the_worst_sd_of_what_is_asked_is_paid_for():
    env = make(reward="worst")
    _, first = env.reset(seed=3)
    steps = [env.step(OPEN) for _ in range(10)]
    asked = np.repeat(first["asked"], 2)
    norm = [np.mean(info["belief_sd"][asked] ** 6) ** (1.0 / 6.0) for info in (first, steps[-1][-1])]
    assert sum(step[1] for step in steps) == pytest.approx(2.0 * np.log(norm[0] / norm[1]), abs=1e-9)
    assert norm[0] > 2.0 * norm[1]


def test_discomfort_is_seen_and_paid_for_above_its_limit():
    arguments = {"cohort": "severe", "comfort": {"force_N": 4.0, "force_hard": 5.0}, "comfort_weight": 20.0}
    free, dear, limited = (
        make(**arguments | more) for more in ({"comfort_weight": 0.0}, {}, {"comfort_limit_s": 0.05})
    )
    for env in (free, dear, limited):
        env.reset(seed=1)
    discomfort = paid = 0.0
    for _ in range(10):
        observation, reward, *_, info = free.step(OPEN)
        discomfort += info["cost"] / 5.0
        assert observation[PLACE["discomfort"]] == pytest.approx(discomfort, rel=1e-5)
        assert dear.step(OPEN)[1] == pytest.approx(reward - 20.0 * info["cost"] / 5.0, abs=1e-9)
        paid += reward - limited.step(OPEN)[1]
    assert discomfort > 0.1
    assert paid == pytest.approx(20.0 * (discomfort - 0.05), abs=1e-9)


@pytest.mark.parametrize("mode", ["next_step", "same_step", "disabled"])
def test_the_vector_form_is_that_of_single_environments(mode):
    """Through the end of an episode, with one question for each world, and from a copy."""
    arguments = {"asked": "random", "reward": "worst", "episode_s": 1.0, "comfort_weight": 20.0}
    many = gym.make_vec(ID, num_envs=3, autoreset_mode=mode, **arguments)
    questions = ["left", None, "masseter_right"]
    together, info = many.reset(seed=5, options={"asked": questions})
    alone = [make(**arguments) for _ in questions]
    for i, (env, question) in enumerate(zip(alone, questions, strict=True)):
        observation, _ = env.reset(seed=5 + i, options={"asked": question})
        np.testing.assert_array_equal(together[i], observation)
    kept = copy.deepcopy(many)
    rows, rewards, *_ = many.step(np.tile(OPEN, (3, 1)))
    for i, env in enumerate(alone):
        observation, reward, *_ = env.step(OPEN)
        np.testing.assert_array_equal(rows[i], observation)
        assert rewards[i] == reward
    for _ in range(5):
        together, *_, info = many.step(np.tile(OPEN, (3, 1)))
    if mode != "disabled":
        np.testing.assert_array_equal(info["asked"].sum(axis=1), 1)  # drawn anew, as the argument says
        assert (together[:, PLACE["discomfort"]] < 1e-6).all() or mode == "same_step"
    np.testing.assert_array_equal(kept.step(np.tile(OPEN, (3, 1)))[0], rows)
    with pytest.raises(jawenv.InputError, match="option asked has 2 entries; allowed: 3"):
        many.reset(options={"asked": ["left", None]})


@pytest.mark.parametrize("env_id", ENVIRONMENTS)
def test_every_model_can_be_asked(env_id):
    env = gym.make(env_id, asked="random")
    observation, info = env.reset(seed=0)
    parameters = len(env.unwrapped.parameter_names)
    assert len(observation) == Parts(parameters, asked=True).size
    assert observation.shape == env.observation_space.shape and len(info["asked"]) == parameters // 2


@pytest.mark.parametrize("control", ["targets", "force"])
def test_a_recording_is_judged_by_what_was_asked(control):
    kwargs = {"asked": "random", "episode_s": 2.0}
    agent = jawenv.Player("slow_opening", control=control)
    recording = jawenv.play(agent, patients=4, seed=0, env_kwargs=kwargs)
    plain = jawenv.play(
        jawenv.Player("slow_opening", control=control), patients=4, seed=0, env_kwargs={"episode_s": 2.0}
    )
    np.testing.assert_array_equal(recording.belief_mean, plain.belief_mean)
    assert (recording.asked.sum(axis=1) == 2).all() and plain.asked.all()
    sd = recording.belief_sd[:, -1]
    expected = [sd[i, recording.asked[i]].max() for i in range(4)]
    np.testing.assert_array_equal(jawenv.score(recording).worst_sd, expected)
    np.testing.assert_array_equal(jawenv.score(plain).worst_sd, sd.max(axis=1))
