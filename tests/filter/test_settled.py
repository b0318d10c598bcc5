"""A belief counts once no replay of the readings is due."""

import gymnasium as gym
import numpy as np
import pytest

import jawenv
from jawenv.filter.settled import settled


@pytest.mark.parametrize(
    ("moved", "sd", "learnt_s", "expected"),
    [
        ([0.04, 0.0], 0.01, 1.0, True),
        ([0.06, 0.0], 0.01, 1.0, False),
        ([0.0, -0.19], 0.1, 1.0, True),
        ([0.0, -0.21], 0.1, 1.0, False),
        ([0.0, 0.0], 0.1, 0.49, False),
    ],
)
def test_settled_by_the_distance_moved_and_the_seconds_learnt(moved, sd, learnt_s, expected):
    assert settled(np.array([moved]), np.full((1, 2), sd), np.array([learnt_s])).tolist() == [expected]


def test_infos_of_one_world_and_of_many_say_the_same():
    one = gym.make("jawenv/Jaw-v3", control="force", episode_s=4.0)
    many = gym.make_vec("jawenv/Jaw-v3", num_envs=2, control="force", episode_s=4.0, autoreset_mode="disabled")
    infos = [(one.reset(seed=40_003)[1], many.reset(seed=[40_003, 40_004])[1])]
    rng = np.random.default_rng(0)
    for _ in range(20):
        action = rng.uniform(-1.0, 1.0, one.action_space.shape).astype(np.float32)
        infos.append((one.step(action)[4], many.step(np.stack([action, action]))[4]))
    assert not infos[0][0]["settled"] and infos[0][0]["learnt_s"] <= 0.01
    for mine, theirs in infos:
        assert mine["settled"] == theirs["settled"][0] and mine["learnt_s"] == theirs["learnt_s"][0]


def test_false_beliefs_on_the_way_have_not_settled():
    """Sixty jaws of anyone, at every step; the rule was chosen on others (docs/tables/honesty.md, "on the way")."""
    played = jawenv.play(
        jawenv.Player("opening_with_swings_and_fore_aft"),
        patients=60,
        seed=41_000,
        env_kwargs={"cohort": "anyone", "episode_s": 10.0, "track_bound": False},
    )
    error = played.belief_mean - played.truth[:, None]
    solved = np.linalg.solve(played.belief_cov, error[..., None])[..., 0]
    false = np.mean(error * solved, axis=-1) > 10.0
    assert false.any() and not (false & played.settled).any()
    assert played.settled[:, -1].mean() > 0.7


def test_a_filter_on_the_bench_says_it_too():
    record = jawenv.play(
        jawenv.Player("slow_opening"), patients=1, seed=41_500, env_kwargs={"record": True, "episode_s": 5.0}
    ).records[0]
    online = jawenv.OnlineFilter(cohort="trismus")
    online.reset()
    said = [
        online.update(measured, samples).settled
        for measured, samples in zip(record.measured[1:], record.samples, strict=True)
    ]
    assert not said[0] and said[-1]
