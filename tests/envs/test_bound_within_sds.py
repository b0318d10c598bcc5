"""The bound where something is known only within an sd: written out in dense matrices by an independent model."""

import gymnasium as gym
import newton_euler
import numpy as np
import pytest
from numpy_model import measurement_with_derivative, step, step_with_derivative

import jawenv
from agents import load_agent
from jawenv.anatomy.knowledge import IMAGED
from jawenv.device.device import TICK
from jawenv.filter.nuisances.unknowns import changed_jaw, offset_of, turn_of

N, P = 10, 12  # motion and parameters
EPS = 1e-3  # sds
MEMORY = {"device": {"unmodelled_time_s": 0.5}}


def swings(**kwargs):
    """A world after one control period of 25 ticks, of which the bound has all rows."""
    env = gym.make("jawenv/Jaw-v3", control="targets", control_hz=4.0, track_bound=True, **kwargs)
    env.reset(seed=6022)
    _, _, _, _, info = env.step(np.array([0.6, 0.4, 0.3, -0.3], dtype=np.float32))
    return env.unwrapped.simulation, info


def drawn(simulation):
    """The drawn values, of the directions that the filter has."""
    truth, sds = simulation.worlds["truth"]["nuisances"][0], simulation.nuisance_sds
    return {name: sum(value * each[name] for value, each in zip(truth, sds, strict=True)) for name in sds[0]}


def changed(simulation):
    """For each nuisance the true jaw moved by ``EPS`` sds both ways, and how its device is off against the true one."""

    def moved(direction, share):
        values = {name: base + share * direction[name] for name, base in drawn(simulation).items()}
        jaw = changed_jaw(simulation.models[0], IMAGED, simulation.cohort.muscles, values)
        return jaw, share * turn_of(IMAGED, direction), share * offset_of(IMAGED, direction)[:6]

    return [(moved(direction, EPS), moved(direction, -EPS)) for direction in simulation.nuisance_sds]


def as_read(wrench, about, offset):
    """The wrench that a given reading stands for, where it would be turned and off by so much more."""
    turned = np.concatenate([np.cross(about, wrench[..., :3]), np.cross(about, wrench[..., 3:])], axis=-1)
    return wrench + turned - offset


def columns_of_step(worlds, mean, wrench, trend, dt):
    """(10, q) the motion after a tick by each nuisance, by central differences."""

    def after(jaw, about, offset):
        return step(jaw, mean, as_read(wrench, about, offset), trend, dt)

    return np.array([(after(*more) - after(*less)) / (2.0 * EPS) for more, less in worlds]).reshape(-1, N).T


def columns_of_readings(worlds, state):
    """(12, q) the readings by each nuisance."""

    def read(jaw, about, _):
        measured = np.array(newton_euler.measurement(jaw, state))
        measured[:3] -= jaw["zero"]
        for places in ([5, 3, 4], [9, 10, 11]):  # roll, pitch, yaw are about x, y, z
            measured[places] -= np.cross(about, measured[places])
        return measured

    return np.array([(read(*more) - read(*less)) / (2.0 * EPS) for more, less in worlds]).reshape(-1, 12).T


def dense_bound(simulation):
    """Covariance of the parameters by the Kalman filter in dense matrices, the gain error considered."""
    world, settings, worlds = simulation.worlds[0], simulation.settings[0], changed(simulation)
    known, rows, truth = settings["filter"], simulation.paths[0], world["truth"]
    theta, jaw, dt = truth["log_parameters"], truth["jaw"], TICK
    q, d = len(simulation.nuisance_sds), len(known["disturbance_variance"])
    size = N + d + q + P + 1
    covariance = np.diag(
        np.concatenate([known["start_sd"], np.ones(q), known["prior_sd"], [np.sqrt(known["gain_variance"])]]) ** 2
    )
    R, W = np.diag(known["measurement_variance"]), np.diag(settings["noise_variance"])
    first = N + d + q
    for tick in range(int(world["known"]["tick"]) + 1):
        state = rows["state"][tick]
        if tick > 0:
            before, wrench, trend = rows["state"][tick - 1], rows["wrench"][tick], rows["trend"][tick]
            mean = np.concatenate([before, theta, [0.0]])
            _, by_all = step_with_derivative(jaw, mean, wrench, trend, dt)
            F, G = np.eye(size), np.zeros((size, 12))
            F[:N, :N], F[:N, first:] = by_all[:, :N], by_all[:, N : N + P + 1]
            F[:N, N : N + d] = by_all[:, N + P + 1 :][:, :d]
            F[N : N + d, N : N + d] *= known["disturbance_decay"]
            F[:N, N + d : first] = columns_of_step(worlds, mean, wrench, trend, dt)
            G[:N] = by_all[:, N + P + 1 :]
            covariance = F @ covariance @ F.T + G @ W @ G.T
            covariance[N : N + d, N : N + d] += np.diag(known["disturbance_variance"])
        H = np.zeros((12, size))
        H[:, :N] = measurement_with_derivative(jaw, state)[1]
        H[:, N + d : first] = columns_of_readings(worlds, state)
        K = covariance @ H.T @ np.linalg.inv(H @ covariance @ H.T + R)
        K[-1] = 0.0
        rest = np.eye(size) - K @ H
        covariance = rest @ covariance @ rest.T + K @ R @ K.T
    return covariance[first:-1, first:-1]


# A nuisance acts half way through a tick, in which a jaw on its teeth swings by 1.9 rad.
@pytest.mark.parametrize(("kwargs", "close"), [(MEMORY, 1e-6), ({"knowledge": "imaged", **MEMORY}, 0.03)])
def test_it_is_that_of_dense_matrices(kwargs, close):
    simulation, info = swings(**kwargs)
    expected = dense_bound(simulation)
    np.testing.assert_allclose(info["bound_sd"], np.sqrt(np.diag(expected)), rtol=close)
    nats = np.log(simulation.cohort.prior.sd).sum() - 0.5 * np.linalg.slogdet(expected)[1]
    assert info["information_bound"] == pytest.approx(nats, rel=close) and nats > 1.0


def test_each_unknown_costs_and_a_rich_maneuver_says_how_much():
    """An analysis with derivatives of its own has the same: a worst of 5.6 % after 7 s."""
    agent, sds = load_agent("refined"), {}
    for name in ("exact", "imaged"):
        kwargs = {"knowledge": name, "track_bound": True, "episode_s": 7.0}
        sds[name] = jawenv.play(agent, patients=16, seed=6000, env_kwargs=kwargs).bound_sd[:, -1]
    assert (np.exp(np.log(sds["imaged"] / sds["exact"]).mean(axis=0)) > 1.2).all()
    worst, median = sds["imaged"].max(axis=1).mean(), np.median(sds["imaged"], axis=1).mean()
    assert worst == pytest.approx(0.056, rel=0.15) and 0.01 < median < 0.6 * worst
