"""Evaluation of a policy on a fixed cohort, which is the best, and the learned price of discomfort."""

from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from point_env import DT_S, EPISODE_STEPS, PointVectorEnv
from rich.console import Console

from jawenv.base.progress import Progress
from jawenv.sb3 import KNOWN, NativeVecEnv
from training.run.callbacks import Multiplier
from training.run.config import ComfortConfig, EvaluationConfig
from training.run.evaluations import Evaluation, Evaluations, evaluate, in_words
from training.run.folder import RunFolder
from training.run.train import TrainingSession


def worlds(start: float = 1.0) -> NativeVecEnv:
    return NativeVecEnv(PointVectorEnv(6, "same_step", start=start))


class Policy:
    """Actions by a function of the observation, with noise where they are drawn; remembers where episodes began."""

    def __init__(self, act: Callable[[np.ndarray], np.ndarray]) -> None:
        self.act, self.starts, self.memories = act, [], []

    def predict(self, observation, state=None, episode_start=None, deterministic=True):  # noqa: ANN001, ANN201
        self.starts.append(np.array(episode_start))
        self.memories.append(state)
        action = self.act(observation)
        return action if deterministic else action + 0.5, (len(self.starts),)


def to_origin() -> Policy:
    return Policy(lambda observation: -observation[:, :2])


def outward() -> Policy:
    return Policy(lambda observation: np.ones((6, 2)))


def test_same_seed_is_the_same_cohort_whatever_was_played_before() -> None:
    used = worlds()
    first = evaluate(to_origin(), used, seed=20_000)
    evaluate(outward(), used, seed=1)
    again = evaluate(to_origin(), used, seed=20_000)
    assert first is not None and again is not None
    np.testing.assert_array_equal(first.figures["return"], again.figures["return"])
    assert first.figures["return"].mean() == pytest.approx(1.0 - 0.9**EPISODE_STEPS, abs=1e-6)


def test_only_the_first_episode_of_a_world_counts() -> None:
    outcome = evaluate(outward(), worlds(start=1.45), seed=5)
    assert outcome is not None
    lengths, violation = outcome.figures["length"], outcome.figures["violation"]
    assert lengths.min() == 1.0 and lengths.max() > 10.0
    np.testing.assert_array_equal(violation, lengths < EPISODE_STEPS)
    assert outcome.averages()["violation"] == violation.mean()


def test_evaluation_is_given_up_when_asked() -> None:
    asked = iter([False] * 5 + [True])
    assert evaluate(to_origin(), worlds(), seed=0, stopped=lambda: next(asked)) is None


def test_drawn_actions_and_memory_are_asked_for() -> None:
    policy = to_origin()
    drawn = evaluate(policy, worlds(), seed=20_000, deterministic=False)
    likely = evaluate(to_origin(), worlds(), seed=20_000)
    assert drawn is not None and likely is not None
    assert drawn.figures["return"].mean() < likely.figures["return"].mean() - 0.1
    assert policy.starts[0].all() and not policy.starts[1].any()
    assert policy.memories[:3] == [None, (1,), (2,)]


def test_worst_sd_is_that_at_10_s_and_at_the_end_and_its_median_counts() -> None:
    outcome = evaluate(outward(), worlds(), seed=5)
    assert outcome is not None
    length, figures = outcome.figures["length"], outcome.figures
    np.testing.assert_allclose(figures["worst_sd"], 0.5 / (1.0 + length))
    at_10_s = np.ceil(10.0 / DT_S)
    np.testing.assert_allclose(figures["worst_sd_10s"], 0.5 / (1.0 + np.minimum(length, at_10_s)))
    assert length.min() < at_10_s < length.max()
    steps = np.ceil(0.5 / KNOWN - 1.0)
    np.testing.assert_allclose(figures["known_s"], np.where(length < steps, np.inf, DT_S * steps))
    assert outcome.averages()["worst_sd"] == np.median(figures["worst_sd"])
    np.testing.assert_allclose(figures["discomfort_s"], 30.0 * figures["cost"] / length)


def test_intervals_hold_the_median_in_95_of_100_cohorts() -> None:
    rng = np.random.default_rng(0)
    held = []
    for _ in range(400):
        ends = Evaluation({"worst_sd": rng.exponential(size=32), "return": np.zeros(32)}).averages()
        held.append(ends["worst_sd_low"] <= np.log(2.0) <= ends["worst_sd_high"])
    assert 0.94 <= np.mean(held) <= 1.0


def test_a_comfortable_policy_is_better_than_any_that_is_not(tmp_path: Path) -> None:
    progress = Progress(1, "steps", Console(quiet=True))
    evaluations = Evaluations(
        RunFolder(tmp_path),
        None,
        worlds(),
        lambda: None,
        progress,
        largest_discomfort_s=0.05,  # type: ignore[arg-type]
    )
    for steps, mean_return, discomfort, better in (
        (0, 50.0, 0.9, True),
        (1, 40.0, 0.5, True),
        (2, 60.0, 0.6, False),
        (3, 10.0, 0.05, True),
        (4, 70.0, 0.06, False),
        (5, 11.0, 0.01, True),
    ):
        row = {"steps": steps, "return": mean_return, "discomfort_s": discomfort}
        assert (", above the 0.05 s allowed" in in_words(row, 0.05)) == (discomfort > 0.05)
        assert evaluations._compare(row) is better, row


PRICE = ComfortConfig(target_discomfort_s=0.1, initial_multiplier=8.0, rate=0.5, largest_multiplier=1000.0, episodes=2)


def test_the_price_rises_above_the_target_falls_below_it_and_rests_at_it() -> None:
    price = Multiplier(PRICE)
    for discomfort, expected in ((0.1, 8.0), (0.2, 8.0 * np.exp(0.5)), (0.0, 8.0)):
        price.update(discomfort)
        assert price.value == pytest.approx(expected)


def test_one_terrible_batch_does_not_blow_the_price_up_and_it_has_an_end() -> None:
    price = Multiplier(PRICE)
    price.update(1e6)
    assert price.value == pytest.approx(8.0 * np.exp(0.5 * 2.0))
    for _ in range(100):
        price.update(1e6)
    assert price.value == 1000.0


def test_reward_is_less_by_price_times_discomfort_also_in_the_last_step() -> None:
    priced, native = (NativeVecEnv(PointVectorEnv(4, "same_step"), price=price) for price in (Multiplier(PRICE), None))
    for each in (priced, native):
        each.seed(3)
        each.reset()
    spent, episode_cost = np.zeros(4), 0.0
    for _ in range(EPISODE_STEPS):
        actions = np.tile([0.6, 0.0], (4, 1))
        _, reward, done, infos = priced.step(actions)
        _, plain, _, _ = native.step(actions)
        np.testing.assert_allclose(plain - reward, 8.0 * priced.discomfort_s, atol=1e-6)
        spent += priced.discomfort_s
        for i in np.flatnonzero(done):
            assert spent[i] == pytest.approx(DT_S * infos[i]["episode"]["cost"], rel=1e-5)
            episode_cost += infos[i]["episode"]["cost"]
            spent[i] = 0.0
    assert episode_cost > 0.5


def test_the_beginning_and_the_best_are_shown_of_the_same_patients_without_nats(tmp_path: Path) -> None:
    progress = Progress(1, "steps", Console(quiet=True))
    evaluations = Evaluations(RunFolder(tmp_path), EvaluationConfig(every_steps=64), worlds(), lambda: None, progress)
    for row in (
        {"steps": 0, "return": 43.15, "worst_sd": 0.0333, "known_s": 6.5, "discomfort_s": 0.064},
        {"steps": 32000, "return": 44.8, "worst_sd": 0.0293, "known_s": 5.5, "discomfort_s": 0.07},
    ):
        assert evaluations._compare(row)
    evaluations._show_best()
    assert progress.describe() == (
        "best: worst error bar 2.93 %, all within 5 % after 5.5 s, discomfort 0.07 s in 30 s; "
        "at the beginning: worst error bar 3.33 %, all within 5 % after 6.5 s, discomfort 0.064 s in 30 s"
    )


def test_who_is_never_known_is_told_so() -> None:
    assert in_words({"worst_sd": 0.4, "known_s": np.inf}) == "worst error bar 40 %, all within 5 % never"
    assert in_words({"return": 3.0}) == "return 3"


def test_the_first_evaluations_follow_each_other_sooner(tmp_path: Path) -> None:
    progress = Progress(1, "steps", Console(quiet=True))
    config = EvaluationConfig(every_steps=64)
    evaluations = Evaluations(RunFolder(tmp_path), config, worlds(), lambda: None, progress)
    evaluations.model, at = SimpleNamespace(num_timesteps=0), []

    def evaluate() -> None:
        evaluations.last = evaluations.model.num_timesteps
        at.append(evaluations.last)

    evaluations.evaluate = evaluate
    for steps in range(0, 260, 2):
        evaluations.model.num_timesteps = steps
        evaluations._on_rollout_start()
    assert at == [0, 8, 16, 32, 64, 128, 192, 256]


def test_the_end_says_that_nothing_was_learned_and_why() -> None:
    for steps, base, words in ((0, object(), "the maneuver itself is kept"), (0, None, "the untrained policy is kept")):
        console = Console(record=True, width=500, quiet=False)
        session = SimpleNamespace(
            model=SimpleNamespace(num_timesteps=10),
            run=SimpleNamespace(path="run"),
            base=base,
            _from_step=0,
            _console=console,
            _validation=SimpleNamespace(num_envs=2),
        )
        row = {"steps": steps, "return": 1.0, "discomfort_s": 0.09}
        TrainingSession._report(session, SimpleNamespace(best=row, limit_s=0.04), 1.0)  # type: ignore[arg-type]
        said = console.export_text()
        assert f"nothing was learned: {words}" in said and "above the 0.04 s allowed" in said
        row["steps"] = 5
        TrainingSession._report(session, SimpleNamespace(best=row, limit_s=0.1), 1.0)  # type: ignore[arg-type]
        assert "nothing" not in (said := console.export_text()) and "above" not in said
