"""Simulation in batches is the single environment, row by row, and leaves out whom the device cannot treat."""

from types import SimpleNamespace

import gymnasium as gym
import numpy as np
import pytest

import jawenv
from jawenv.inference import simulations
from jawenv.ladder import MODELS, model_named
from jawenv.recordings.of_simulation import record_of

SOFT = np.log([1.2, 7.0] * 6)
LIMP = np.log([1e-4, 7.0] * 6)  # hangs far open


def coarse(*shape, seed=0):
    return np.random.default_rng(seed).uniform(-1, 1, (*shape, 4)).astype(np.float32)


def alone(theta, actions, seed, env_id="jawenv/Jaw-v3", **kwargs):
    """The record of a single environment, until it terminates."""
    muscles = model_named(gym.spec(env_id).kwargs["model"]).muscles.names
    env = gym.make(env_id, record=True, **kwargs)
    env.reset(seed=seed, options={"patient": jawenv.Patient.from_log_parameters(theta, muscles=muscles)})
    for action in actions:
        if env.step(action)[2]:
            break
    return record_of(env.unwrapped.simulation, 0)


def assert_equal(record, expected):
    for name in ("time", "measured", "samples", "start_mean", "truth", "states", "wrenches"):
        np.testing.assert_array_equal(getattr(record, name), getattr(expected, name), err_msg=name)


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("control", ["targets", "force"])
def test_a_row_is_the_single_environment(model, control):
    rung = model_named(model)
    theta = jawenv.cohort("trismus", rung.muscles).sample(
        2, 0, accept=lambda rows: jawenv.treatable(rows, env_id=rung.env_id)
    )
    actions = coarse(2, 3)
    made = jawenv.simulate(theta, actions, 11, states=True, env_id=rung.env_id, env_kwargs={"control": control})
    assert made.treatable.all()
    for i in range(2):
        expected = alone(theta[i], actions[i], 11 + i, rung.env_id, control=control)
        assert_equal(made.records[i], expected)
        np.testing.assert_array_equal(made.measured[i], expected.measured)
        np.testing.assert_array_equal(made.samples[i], expected.samples)
        np.testing.assert_array_equal(made.states[i], expected.states)


def test_arguments_of_the_environment_reach_it():
    kwargs = {"control": "trajectory", "sensors": "point", "control_hz": 10, "reality": {"attachment_error": 1.0}}
    actions = coarse(6)
    made = jawenv.simulate([SOFT], actions, 5, states=True, env_kwargs=kwargs)
    assert made.time[-1] == pytest.approx(0.6)
    assert_equal(made.records[0], alone(SOFT, actions, 5, **kwargs))
    assert np.isnan(made.measured[0, :, 3:6]).all()


def test_those_who_cannot_be_treated_are_masked_and_change_nobody():
    theta = np.array([SOFT, LIMP, SOFT + 0.1, SOFT + 9.0])
    actions = coarse(4, 3)
    made = jawenv.simulate(theta, actions, 3)
    assert made.treatable.tolist() == [True, False, True, False]
    assert made.ticks.tolist() == [60, -1, 60, -1]
    assert [record is None for record in made.records] == [False, True, False, True]
    assert made.measured.shape == (4, 61, 12) and made.samples.shape == (4, 60, 3, 6)
    assert np.isnan(made.measured[[1, 3]]).all() and np.isnan(made.samples[[1, 3]]).all()
    for i in (0, 2):
        row = jawenv.simulate(theta[[i]], actions[i], 3 + i)
        np.testing.assert_array_equal(row.measured[0], made.measured[i])


def test_the_seed_decides_and_parts_do_not(monkeypatch):
    theta = np.tile(SOFT, (5, 1))
    whole = jawenv.simulate(theta, coarse(2), 3)
    monkeypatch.setattr(simulations, "MOST_WORLDS", 2)
    np.testing.assert_array_equal(jawenv.simulate(theta, coarse(2), 3).measured, whole.measured)
    other = jawenv.simulate(theta, coarse(2), 4)
    np.testing.assert_array_equal(other.measured[:4], whole.measured[1:])
    assert not np.array_equal(other.measured[0], whole.measured[0])


def test_an_episode_ends_where_the_environment_does():
    """Motors without a governor's help, and a jaw so soft that they throw it beyond a hard limit."""
    device = {"slew_N_s": 1000.0, "full_scale_N": 60.0, "force_cap_N": 400.0, "stop_stiffness_N_m": 1.0}
    kwargs = {"control": "force", "device": device}
    actions = np.ones((40, 4), dtype=np.float32)
    made = jawenv.simulate([SOFT, SOFT], actions, 0, states=True, env_kwargs=kwargs)
    expected = alone(SOFT, actions, 0, **kwargs)
    assert 0 < made.ticks[0] < 200 and len(expected.samples) == made.ticks[0]
    assert_equal(made.records[0], expected)
    assert np.isnan(made.measured[0, made.ticks[0] + 1 :]).all() and np.isnan(made.states[0, -1]).all()


def test_what_is_true_is_kept_when_asked_for():
    made = jawenv.simulate([SOFT], coarse(2))
    assert made.states is None and made.wrenches is None
    assert made.records[0].states is None and made.records[0].wrenches is None
    assert jawenv.simulate(np.empty((0, 12)), coarse(2)).measured.shape == (0, 41, 12)


@pytest.mark.parametrize(
    "change",
    [
        {"theta": SOFT},
        {"actions": coarse()},
        {"actions": np.empty((0, 4))},
        {"actions": coarse(3, 2)},
        {"actions": np.full((2, 4), 2.0)},
        {"actions": np.zeros((2, 3))},
        {"seed": -1},
        {"seed": None},
        {"env_id": "CartPole-v1"},
        {"env_kwargs": {"episode_s": 3.0}},
        {"env_kwargs": {"controls": "force"}},
        {"env_kwargs": 3},
        {"env_kwargs": {"estimator": SimpleNamespace(reset=print, update=print)}},
    ],
)
def test_what_is_refused(change):
    given = {"theta": [SOFT], "actions": coarse(2), "seed": 0} | change
    with pytest.raises(jawenv.InputError):
        jawenv.simulate(given.pop("theta"), given.pop("actions"), given.pop("seed"), **given)
