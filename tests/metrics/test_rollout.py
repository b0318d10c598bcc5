from dataclasses import fields

import gymnasium as gym
import numpy as np
import pytest

import jawenv
from jawenv.base.errors import InputError
from jawenv.envs.jaw import JawEnv
from jawenv.playing.agents import own_seed
from jawenv.playing.rollout import play

SHORT = {"episode_s": 1.0}


class Push:
    """Sends the same action for ever, and remembers how it was called."""

    control = "force"

    def __init__(self, *action):
        self.action = np.array(action, dtype=np.float32)
        self.resets, self.starts = [], []

    def reset(self, num_envs, seed=None):
        self.resets.append((num_envs, seed))

    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        self.starts.append(episode_start.copy())
        return np.tile(self.action, (len(observation), 1)), state


REST, OPEN = Push(0, 0, 0, 0), Push(0.3, 0.3, 0, 0)


@pytest.fixture(scope="module")
def recording():
    return play(OPEN, patients=3, seed=5, env_kwargs=SHORT)


def test_a_recording_starts_at_the_reset_and_ends_with_the_episode(recording):
    assert recording.time[0] == 0.0
    assert recording.time[-1] == pytest.approx(1.0)
    assert recording.belief_mean.shape == (3, 21, 12)
    assert recording.parameter_names == jawenv.PARAMETER_NAMES
    np.testing.assert_array_equal(recording.prior_sd, jawenv.cohort("trismus").prior.sd)
    assert recording.valid.all()


def test_another_agent_meets_the_same_patients(recording):
    other = play(REST, patients=3, seed=5, env_kwargs=SHORT)
    np.testing.assert_array_equal(other.truth, recording.truth)
    assert not np.array_equal(other.belief_mean, recording.belief_mean)


def test_the_same_seed_repeats_bit_for_bit_and_does_not_depend_on_the_company(recording):
    again = play(OPEN, patients=2, seed=[7, 6], env_kwargs=SHORT)
    np.testing.assert_array_equal(again.belief_cov, recording.belief_cov[[2, 1]])


def test_metrics_equal_what_the_environment_reports(recording):
    judged = jawenv.score(recording)
    np.testing.assert_allclose(judged.information_claimed, recording.information_claimed[:, -1], atol=1e-9)
    np.testing.assert_allclose(judged.information_true, recording.information_true[:, -1], atol=1e-9)


def test_the_alarm_is_recorded_and_rings_where_the_readings_do_not_fit():
    kwargs = {"episode_s": 6.0, "control": "targets"}
    honest, misled = (
        play(jawenv.Player("refined"), patients=4, seed=5, env_kwargs=kwargs | {"reality": reality})
        for reality in (None, {"fossa_error": 0.2})
    )
    # Where the readings are filtered again, they are judged again, and what the old belief claimed is forgotten.
    assert (misled.misfit[:, -1] >= 0.25 * misled.misfit.max(axis=1)).all()
    assert not jawenv.score(honest).rings.any() and jawenv.score(honest).misfit.min() > 0.0
    assert jawenv.score(misled).rings.mean() >= 0.5 and "do not fit the model" in jawenv.score(misled).alarm


def test_patients_may_be_files_and_mappings(tmp_path):
    patient = jawenv.cohort("severe").draw(np.random.default_rng(1))
    patient.save(tmp_path / "patient.json")
    played = play(REST, patients=[patient.model_dump(), tmp_path / "patient.json"], seed=0, env_kwargs=SHORT)
    np.testing.assert_allclose(played.truth, [patient.log_parameters()] * 2)


def test_an_agent_is_told_how_many_worlds_and_when_they_start():
    agent, steps = Push(0, 0, 0, 0), []
    play(agent, patients=2, seed=9, env_kwargs={"episode_s": 0.2}, progress=lambda *step: steps.append(step))
    assert agent.resets == [(2, own_seed(0))]
    assert [starts.all() for starts in agent.starts] == [True, False, False, False]
    assert steps == [(1, 4), (2, 4), (3, 4), (4, 4)]


def test_a_world_that_ended_early_keeps_its_last_values():
    ungoverned = {"stop_stiffness_N_m": 1.0, "stop_damping_N_s_m": 1e-3, "brake_N_s_m": 1e-3}
    played = play(Push(1, 1, 1, 1), patients=4, seed=0, env_kwargs={"episode_s": 4.0, "device": ungoverned})
    ended = np.flatnonzero(played.terminated)
    assert len(ended), "full thrust without end stops is expected to cross a hard limit"
    world = ended[np.argmin(played.last[ended])]
    last = played.last[world]
    assert played.violation[world, last] and last < played.belief_cov.shape[1] - 1
    after = played.belief_cov[world, last + 1 :]
    np.testing.assert_array_equal(after, np.broadcast_to(played.belief_cov[world, last], after.shape))
    assert not played.cost[world, last + 1 :].any()


def test_a_filter_that_diverged_ends_its_episode_the_step_before(monkeypatch):
    from jawenv.envs.vector import JawVectorEnv

    step = JawVectorEnv.step

    def diverging(self, actions):
        observation, reward, terminated, truncated, info = step(self, actions)
        if info["time"][0] > 0.45:
            info["belief_cov"][0] = np.nan
            info["information_claimed"][0] = np.nan
            terminated[0] = True
        return observation, reward, terminated, truncated, info

    monkeypatch.setattr(JawVectorEnv, "step", diverging)
    played = play(REST, patients=2, seed=0, env_kwargs=SHORT)
    assert played.terminated.tolist() == [True, False]
    assert played.last.tolist() == [9, 20]
    assert np.isfinite(jawenv.score(played).nees).all()


class Doubled(JawEnv):
    """Another reward."""

    def step(self, action):
        observation, reward, *rest = super().step(action)
        return observation, 2.0 * reward, *rest


@pytest.fixture
def subclass_id():
    """Id of a subclass that is registered without a vector form."""
    env_id = "jawenv-test/Doubled-v0"
    gym.register(env_id, entry_point=Doubled, kwargs={"model": "jaw"})
    yield env_id
    del gym.registry[env_id]


def test_an_environment_without_a_vector_form_is_played_world_by_world(subclass_id):
    firm = {name: dict.fromkeys(jawenv.MUSCLE_NAMES, value) for name, value in (("F_o_N", 1.0), ("b", 7.0))}
    arguments = {"patients": [None, firm], "seed": 5, "env_kwargs": {**SHORT, "record": True}}
    one, other = play(OPEN, env_id=subclass_id, **arguments), play(OPEN, **arguments)
    for field in fields(one):
        if field.name != "records":
            np.testing.assert_array_equal(getattr(one, field.name), getattr(other, field.name))
    for mine, theirs in zip(one.records, other.records, strict=True):
        np.testing.assert_array_equal(mine.measured, theirs.measured)


def test_a_world_that_ends_early_stands_still_while_single_ones_go_on(subclass_id):
    soft = {"stop_stiffness_N_m": 1.0, "stop_damping_N_s_m": 1e-3, "brake_N_s_m": 1e-3, "full_scale_N": 10.0}
    arguments = {"patients": 3, "seed": 0, "env_kwargs": {"episode_s": 3.0, "device": soft, "cohort": "healthy"}}
    one, other = (play(Push(1, 1, 0, 0), **arguments, **kwargs) for kwargs in ({"env_id": subclass_id}, {}))
    assert other.terminated.any()
    np.testing.assert_array_equal(one.valid, other.valid)
    np.testing.assert_array_equal(one.belief_cov, other.belief_cov)
    np.testing.assert_array_equal(one.cost, other.cost)


def test_an_agent_that_plans_needs_the_native_vector_form(subclass_id):
    class Planner(Push):
        def attach(self, env):
            self.worlds = env.unwrapped.simulation

    with pytest.raises(InputError):
        play(Planner(0, 0, 0, 0), patients=1, seed=0, env_id=subclass_id, env_kwargs=SHORT)
