"""Worlds of the twin against the environment."""

from math import log

import gymnasium as gym
import numpy as np
import pytest
import torch
from agreement import _shaking, agreement

from agents.twin.constants import Patients, Twin
from agents.twin.objective import log_worst, weights
from agents.twin.observation import observation
from agents.twin.search import cost_of, searched
from agents.twin.worlds import Worlds
from jawenv.device.comfort import COMFORT_LIMITS
from jawenv.envs.observation import OBSERVATION_LAYOUT, Parts
from jawenv.playing.maneuvers import Maneuver
from jawenv.playing.maneuvers.maneuver import action_of

TARGETS = Maneuver.named("refined_one_sided").targets(0.2 * np.arange(1, 16)).value


@pytest.fixture(scope="module")
def env():
    env = gym.make_vec("jawenv/Jaw-v3", 4, cohort="trismus", episode_s=3.0, autoreset_mode="disabled")
    env.reset(seed=5000)
    return env


def test_the_gradient_is_that_of_finite_differences(env):
    simulation = env.unwrapped.simulation
    twin, patients = Twin(simulation), Patients.of_worlds(simulation.worlds)

    def loss(targets):
        worlds = Worlds(twin, patients, torch.Generator().manual_seed(1))
        return cost_of(worlds, targets.expand(len(patients), -1, -1), 2.0).mean()

    t = 0.2 * torch.arange(1, 11, dtype=torch.float64)[:, None]  # away from every limit of the targets
    parts = 0.4 - 0.4 * (2.0 * t).cos(), 0.3 * (3.0 * t).sin(), 0.1 * (2.0 * t).sin(), 0.2 * (3.0 * t).cos() - 0.2
    targets = torch.cat(parts, -1).requires_grad_(True)
    (gradient,) = torch.autograd.grad(loss(targets), targets)
    step = 1e-4 * gradient / gradient.norm()
    with torch.no_grad():
        change = loss(targets + step) - loss(targets - step)
    assert change.item() == pytest.approx(2e-4 * gradient.norm().item(), rel=0.1)


def test_the_policy_sees_in_the_twin_what_it_sees_in_the_environment(env):
    seen, _ = env.reset(seed=5000)
    simulation = env.unwrapped.simulation
    worlds = Worlds(Twin(simulation), Patients.of_worlds(simulation.worlds))
    for step in range(len(TARGETS)):
        seen, *_ = env.step(np.tile(action_of(TARGETS[step]).astype(np.float32), (4, 1)))
        worlds.step(torch.tensor(np.tile(TARGETS[step], (4, 1))))
    rows = observation(worlds, 0.0, Parts()).numpy()
    assert rows.shape == seen.shape
    for name, within in {"pose": 0.2, "jaw": 0.15, "jaw_range": 1e-6, "motor_target": 0.05, "belief_sd": 0.3}.items():
        part = OBSERVATION_LAYOUT[name]
        assert np.abs(rows[:, part] - seen[:, part]).max() < within, name
    margins = OBSERVATION_LAYOUT["comfort_margin"]
    assert np.abs(rows - seen)[:, margins].mean() < 0.15
    forces = OBSERVATION_LAYOUT["force"]
    assert np.corrcoef(rows[:, forces].ravel(), seen[:, forces].ravel())[0, 1] > 0.9


@pytest.mark.parametrize("cohort", ["trismus", "one_sided"])
def test_the_twin_knows_what_the_filter_knows(cohort):
    result = agreement({"cohort": cohort}, 30, 5000)
    assert result.correlation() > 0.95
    assert abs((result.worst[1] - result.worst[0]).mean()) < 0.1
    assert "| all |" in result.table()


@pytest.mark.parametrize("budget", [None, 1.0 / 30.0])
def test_the_twins_discomfort_on_a_policys_own_path_is_the_environments(budget):
    result = agreement({"cohort": "one_sided", "comfort_budget_s": budget}, 24, 5100, "apg_anyone")
    felt, of_twin = result.discomfort_s.sum(-1)
    assert 0.6 < of_twin.mean() / felt.mean() < 2.0
    if budget is None:
        assert np.corrcoef(felt, of_twin)[0, 1] > 0.5
    else:  # little is left that differs from patient to patient
        assert (np.array([felt, of_twin]) <= budget).mean() >= 0.95
    assert 0.1 < result.shaking[COMFORT_LIMITS.index("speed")] < 0.25
    assert abs((result.worst[1] - result.worst[0]).mean()) < 0.15
    assert "speed 0." in result.table()


def test_the_fitted_shaking_is_what_was_felt():
    rng, sds = np.random.default_rng(0), np.array([0.05, 0.2])
    still = rng.uniform(-0.3, 0.1, (4000, 2))
    felt = np.maximum(still + sds * rng.standard_normal((200, 4000, 2)), 0.0).mean((0, 1))
    np.testing.assert_allclose(_shaking(still, felt), sds, rtol=0.03)
    assert np.isnan(_shaking(still, np.array([0.0, 1e-3]))).all()  # nothing felt, or more without any shaking


def test_a_budget_takes_the_same_discomfort_away_in_twin_and_environment():
    free, kept = (
        agreement({"cohort": "healthy", "comfort_budget_s": budget}, 12, 5200, "refined")
        for budget in (None, 1.0 / 30.0)
    )
    less = kept.discomfort_s.sum(-1).mean(1) / free.discomfort_s.sum(-1).mean(1)
    assert (less < 0.3).all()


def test_log_worst_bounds_the_largest_sd(env):
    simulation = env.unwrapped.simulation
    worlds = Worlds(Twin(simulation), Patients.of_worlds(simulation.worlds))
    largest = worlds.belief.covariance.diagonal(dim1=-2, dim2=-1)[:, :12].amax(-1).log() / 2.0
    assert ((log_worst(worlds) >= largest - 1e-9) & (log_worst(worlds) < largest + log(12.0) / 10.0)).all()
    assert sum(weights(50).values()) == pytest.approx(1.0)


def test_beliefs_begin_with_what_was_known_before(env):
    simulation = env.unwrapped.simulation
    worlds = Worlds(Twin(simulation), Patients.of_worlds(simulation.worlds))
    root = torch.randn(4, 12, 12, generator=torch.Generator().manual_seed(1), dtype=torch.float64)
    mean, precision = worlds.patients.theta + 0.1, 50.0 * torch.eye(12).double() + root @ root.mT
    worlds.belief.know(mean, precision)
    assert torch.allclose(worlds.belief.mean, mean, atol=1e-12)
    assert torch.allclose(torch.linalg.inv(worlds.belief.covariance[:, :12, :12]), precision)


def test_a_search_makes_the_mean_of_a_group_better(env):
    """Two groups of two patients: each gets targets of its own, and costs less with them than with the start's."""
    simulation = env.unwrapped.simulation
    twin, patients = Twin(simulation), Patients.of_worlds(simulation.worlds)
    start = np.tile(TARGETS, (2, 1, 1))
    found = searched(twin, patients, start, 3)
    assert found.shape == start.shape and np.abs(found[0] - found[1]).max() > 1e-3

    def cost(targets):
        worlds = Worlds(twin, patients)
        discomfort = sum(worlds.step(target) for target in torch.tensor(targets).repeat_interleave(2, 0).unbind(1))
        return (log_worst(worlds) + discomfort).detach().reshape(2, 2).mean(1)

    assert (cost(found) < cost(start)).all()
