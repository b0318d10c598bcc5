"""Ranks and singular values of the joint problem, against the derivative of whole simulated motions."""

from dataclasses import replace
from functools import cache

import newton_euler as twin
import numpy as np
import pytest
from numpy_model import step

import jawenv
from agents import load_agent
from jawenv.analysis.observability import numerical_rank, observability

TICKS = 6


@cache
def record_of(env_id="jawenv/Jaw-v3"):
    agent = load_agent("opening_with_swings_and_fore_aft", env_id=env_id, control="force")
    settings = {"record": True, "episode_s": 3.0}
    return jawenv.play(agent, patients=1, seed=5_001, env_kwargs=settings, env_id=env_id).records[0]


def flight(record, values, wrench):
    """Whitened encoder readings over a few ticks under a constant wrench, by the independent model; complex-safe."""
    jaw, motion, samples = record.jaw, values[:10], np.tile(wrench, (3, 1))
    states, readings = [motion], [twin.measurement(jaw, motion)]
    for _ in range(TICKS):
        motion = step(jaw, np.concatenate([motion, values[10:], [0.0]]), samples, np.zeros(6), record.dt)
        states.append(motion)
        readings.append(twin.measurement(jaw, motion))
    return np.array(states), np.concatenate([reading / record.measurement_sd for reading in readings])


def test_singular_values_are_those_of_the_whole_flight():
    """The derivative of all readings by the start, through the simulation, in units of noise and prior."""
    record = record_of()
    wrench, start = record.wrenches[150, 0], np.concatenate([record.states[150], record.truth])
    states, _ = flight(record, start, wrench)
    short = replace(record.until(TICKS * record.dt), states=states.real, wrenches=np.tile(wrench, (TICKS, 3, 1)))
    scale = np.concatenate([record.start_sd, record.prior.sd])
    expected = np.linalg.svd(twin.derivative(lambda v: flight(record, v, wrench)[1], start) * scale, compute_uv=False)
    found = observability(short, window_s=TICKS * record.dt)
    np.testing.assert_allclose(found.singular_values[0], expected, rtol=1e-6, atol=1e-9 * expected[0])
    assert (found.singular_values[0] > 1.0).sum() == (expected > 1.0).sum() and 10 <= (expected > 1.0).sum() < 22


@pytest.mark.parametrize(("env_id", "states"), [("jawenv/Jaw-v3", 22), ("jawenv/JawHinge-v3", 4)])
def test_one_moment_cannot_tell_all_parameters_and_the_motion_can(env_id, states):
    """At one moment they act through the accelerations alone: half of the motion's numbers."""
    found = observability(record_of(env_id))
    motion = states - len(record_of(env_id).parameter_names)
    assert found.states == states and found.singular_values.shape == (3, states)
    np.testing.assert_allclose(found.start, [0.0, 1.0, 2.0])
    assert (found.frozen_rank == motion + motion // 2).all()
    assert (found.growing_rank == states).all() and (found.rank == states).all()


def test_a_point_without_angles_tells_less_and_blindness_nothing():
    record = record_of()
    whole = observability(record).singular_values
    point, blind = record.measured.copy(), np.full_like(record.measured, np.nan)
    point[:, 3:6] = point[:, 9:12] = np.nan
    fewer = observability(replace(record, measured=point))
    assert (fewer.singular_values[:, :22] < whole + 1e-9).all() and fewer.singular_values.sum() < 0.9 * whole.sum()
    nothing = observability(replace(record, measured=blind))
    assert not nothing.rank.any() and not nothing.growing_rank.any() and not nothing.frozen_rank.any()


def test_rank_counts_what_rounding_does_not_explain():
    assert numerical_rank(np.array([1.0, 1e-3, 1e-17])) == 2
    assert numerical_rank(np.zeros(3)) == 0
