"""The iterated smoother against dense least squares on an independent model, and a filter where all is linear."""

from dataclasses import replace

import newton_euler as twin
import numpy as np
import pytest
from joint_belief import model_step
from recorded import SWINGS, held, opening, recording, share

import jawenv
from agents import load_agent
from jawenv.filter.model.encoders import measure
from jawenv.metrics.calibration import nees_band
from jawenv.recordings.estimate import Estimate
from jawenv.recordings.thinning import divided, thinned
from jawenv.references import smoother
from jawenv.references.extended_kalman import ExtendedKalman
from jawenv.references.mode_search import integrate_out
from jawenv.references.smoother import IteratedSmoother

TILT = np.array([-1.0, 0.0, 1.0])[:, None]  # of a tick's three samples


@pytest.fixture(scope="module")
def record():
    # Soft muscles and no teeth: the model never divides its steps, which would make the cost jump.
    return recording(cohort="healthy").records[0]


class Dense:
    """All residuals of a record, in sds, as a function of all unknowns; complex-safe.

    Unknowns: first motion (10), log-parameters (12), wrench of every tick (12 each), and last the gain error.
    """

    def __init__(self, record):
        self.record, self.ticks = record, len(record.samples)
        mean = np.einsum("i,tik->tk", [1 / 6, 4 / 6, 1 / 6], record.samples)
        follow = 1.0 - np.exp(-record.dt / 0.05)
        self.trends = np.zeros((self.ticks, 6))
        for k in range(1, self.ticks):
            self.trends[k] = self.trends[k - 1] + follow * (mean[k - 1] - self.trends[k - 1])
        constant = np.sqrt(record.wrench_sd**2 + (record.gain_sd * (mean - self.trends)) ** 2)
        self.wrench_sd = np.hstack([constant, np.tile(record.cell_sd, (self.ticks, 1))])

    def residuals(self, unknowns):
        record = self.record
        motion, parameters, gain = unknowns[:10], unknowns[10:22], unknowns[-1]
        wrenches = unknowns[22:-1].reshape(self.ticks, 12)
        parts = [(motion - record.start_mean) / record.start_sd, (parameters - record.prior.mean) / record.prior.sd]
        parts.append((wrenches / self.wrench_sd).ravel())
        for k in range(self.ticks + 1):
            parts.append((twin.measurement(record.jaw, motion) - record.measured[k]) / record.measurement_sd)
            if k < self.ticks:
                mean = np.concatenate([motion, parameters, [gain]])
                motion = model_step(record.jaw, mean, record.samples[k], self.trends[k], wrenches[k])
        return np.concatenate(parts)

    def at(self, path):
        return np.concatenate([path.states[0], path.parameters, path.wrenches.ravel(), [0.0]])


def test_the_solution_is_the_minimum_of_the_independent_cost_and_its_covariance_that_of_dense_least_squares(record):
    short = replace(record.until(0.09), gain_sd=0.05)
    result = IteratedSmoother(tolerance=1e-6).find_path(short)
    dense = Dense(short)
    unknowns = dense.at(result.path)
    residuals = dense.residuals(unknowns).real
    assert result.converged
    assert result.path.cost == pytest.approx(0.5 * residuals @ residuals, rel=1e-9)
    jacobian = twin.derivative(dense.residuals, unknowns)
    by_unknowns, by_gain = jacobian[:, :-1], jacobian[:, -1]
    inverse = np.linalg.inv(by_unknowns.T @ by_unknowns)
    # In posterior sds: how much the cost would change, and how far the minimum of the tangent problem is.
    gradient, sd = by_unknowns.T @ residuals, np.sqrt(np.diag(inverse))
    assert np.abs(gradient * sd).max() < 1e-4
    first = dense.at(smoother._Problem(short).first_path())
    by_motion = twin.derivative(lambda motion: dense.residuals(np.concatenate([motion, first[10:]])), first[:10])
    away = by_motion.T @ dense.residuals(first).real
    assert np.abs(away * sd[:10]).max() > 1.0, "the start is not the minimum"
    considered = -inverse @ by_unknowns.T @ by_gain
    cov = (inverse + 0.05**2 * np.outer(considered, considered))[10:22, 10:22]
    sd = np.sqrt(np.diag(cov))
    assert np.abs((result.path_cov - cov) / np.outer(sd, sd)).max() < 1e-5
    assert (sd < 0.999 * short.prior.sd).any(), "the record teaches something"


def test_readings_that_are_missing_do_not_count(record, rng):
    measured = np.where(rng.random((16, 12)) < 0.4, np.nan, record.measured[:16])
    holey = replace(record.until(0.15), measured=measured)
    result, dense = IteratedSmoother(tolerance=1e-6).find_path(holey), Dense(holey)
    values = dense.residuals(dense.at(result.path)).real
    assert np.isnan(values).sum() == np.isnan(measured).sum() > 50
    assert result.path.cost == pytest.approx(0.5 * np.nansum(values**2), rel=1e-9)


def test_the_cost_falls_with_every_step_and_the_start_does_not_matter(monkeypatch):
    """From the filter's end and from the prior alone: the same minimum, to what other divisions of the steps change.

    The steps stay divided as finely as any path on the way has asked for. Where both ways ask for the same, the minima
    agree to 1e-6 sds.
    """
    for record in opening("healthy").records[:3]:
        record = record.until(10.0)
        near = IteratedSmoother().find_path(record)
        with monkeypatch.context() as patched:
            prior = Estimate("prior", np.zeros(1), record.prior.mean[None], np.diag(record.prior.sd**2)[None])
            patched.setattr(ExtendedKalman, "estimate", lambda self, record, prior=prior: prior)
            far = IteratedSmoother().find_path(record)
        for result in (near, far):
            assert result.converged
            assert (np.diff(result.costs) < 0.0).all()
        assert far.costs[0] > near.costs[0]
        assert (np.abs(far.path.parameters - near.path.parameters) < 2e-2 * np.sqrt(np.diag(near.path_cov))).all()


def as_the_model_has_it(record, rng):
    """The record of a jaw that moves exactly as the smoother believes, all uncertainty a hundredth of the usual."""
    path = IteratedSmoother().find_path(record).path
    measured, rows, expected = np.empty_like(record.measured), np.empty((12, 10)), np.empty(12)
    for k, state in enumerate(path.states):
        measure(record.jaw, state, rows, expected)
        measured[k] = expected + 0.01 * record.measurement_sd * rng.normal(size=12)
    sd = 0.01 * record.start_sd
    return replace(
        record,
        measured=measured,
        samples=record.samples + path.wrenches[:, None, :6] + TILT * path.wrenches[:, None, 6:],
        start_mean=path.states[0] + sd * rng.normal(size=10),
        start_sd=sd,
        measurement_sd=0.01 * record.measurement_sd,
        wrench_sd=0.01 * record.wrench_sd,
        cell_sd=0.01 * record.cell_sd,
        gain_sd=0.0,
        prior=replace(record.prior, mean=path.parameters + 2e-3 * rng.normal(size=12), sd=np.full(12, 2e-3)),
    )


def test_where_all_is_linear_the_filter_ends_where_the_smoother_does(monkeypatch):
    """Uncertainty so small that tangents hold; the record still moves every belief by much. Every tick teaches."""
    monkeypatch.setattr("jawenv.filter.settings.rough_change", lambda cell_sd, dt: np.full(3, np.inf))
    monkeypatch.setattr("jawenv.filter.settings.LASTING", 0.0)
    record = as_the_model_has_it(opening("healthy").records[0], np.random.default_rng(3))  # off the teeth
    filtered = ExtendedKalman(parameter_rate=0.0).estimate(record)
    smoothed = IteratedSmoother().smooth(record)
    sd = np.sqrt(np.diag(smoothed.cov))
    assert np.median(sd) < 0.5 * 2e-3
    assert (np.abs(smoothed.mean - record.prior.mean) / sd).max() > 1.0
    assert (np.abs(smoothed.path.parameters - filtered.mean[-1]) / sd).max() < 0.05
    # The result has what the gain error makes of inertia as a number of its own, the extended filter has not.
    assert (np.abs(smoothed.mean - filtered.mean[-1]) / sd).max() < 0.15
    np.testing.assert_allclose(filtered.cov[-1] / np.outer(sd, sd), smoothed.cov / np.outer(sd, sd), atol=0.02)


def test_the_record_is_linearised_about_what_is_found(record):
    """Begun at the result, the search stays; the path's parameters are something else."""
    short = record.until(2.0)
    result = IteratedSmoother().smooth(short)
    sd = np.sqrt(np.diag(result.cov))
    again, cov = integrate_out(short, result.mean)
    assert np.abs((again - result.mean) / sd).max() < 0.02
    np.testing.assert_allclose(cov / np.outer(sd, sd), result.cov / np.outer(sd, sd), atol=0.02)
    assert np.abs((result.mean - result.path.parameters) / sd).max() > 0.02


def test_several_beliefs_that_stay_are_found():
    """One point's readings, 10 s."""
    kwargs = {"record": True, "episode_s": 10.0, "sensors": "point", "track_bound": False}
    for record in jawenv.play(load_agent(SWINGS, control="force"), patients=2, seed=5021, env_kwargs=kwargs).records:
        estimate = IteratedSmoother().estimate(record)
        assert share(record, estimate.mean[-1], estimate.cov[-1]) < 2.5


def test_it_is_honest_of_slow_recordings():
    """Encoders read at 10 Hz, four patients, 10 s."""
    kwargs = {"record": True, "episode_s": 10.0, "track_bound": False}
    played = jawenv.play(load_agent(SWINGS, control="force"), patients=4, seed=5000, env_kwargs=kwargs)
    shares = []
    for record in played.records:
        estimate = IteratedSmoother().estimate(divided(thinned(record, 10), 10))
        shares.append(share(record, estimate.mean[-1], estimate.cov[-1]))
    low, high = np.array(nees_band(4, 12, 0.999)) / 12.0
    assert low < np.mean(shares) < high


def test_the_most_probable_parameters_are_better_than_those_of_the_most_probable_path():
    """Eight patients who are moved quickly: errors of both in the same sds, and the claims of one of them."""
    kwargs = {"record": True, "episode_s": 20.0, "track_bound": False, "cohort": "healthy"}
    played = jawenv.play(load_agent("chirp", control="force"), patients=8, seed=6500, env_kwargs=kwargs)
    of_path, of_mean, shares = [], [], []
    for record in played.records:
        result = IteratedSmoother().smooth(record)
        sd = np.sqrt(np.diag(result.cov))
        of_path.append((result.path.parameters - record.truth) / sd)
        of_mean.append((result.mean - record.truth) / sd)
        shares.append(share(record, result.mean, result.cov))
    assert np.mean(np.square(of_path)) > 1.1 * np.mean(np.square(of_mean))
    low, high = np.array(nees_band(8, 12, 0.999)) / 12.0
    assert low < np.mean(shares) < high


def test_errors_are_as_large_as_claimed_and_close_to_the_bound():
    """Eight patients, 30 s: the ratio of errors to the bound has an sd of 0.07."""
    played, method = opening(), IteratedSmoother()
    estimates = [method.estimate(record) for record in played.records]
    errors = np.array([estimate.mean[-1] for estimate in estimates]) - played.truth
    nees = [error @ np.linalg.solve(estimate.cov[-1], error) for error, estimate in zip(errors, estimates, strict=True)]
    low, high = nees_band(8, 12, 0.999)
    assert low < np.mean(nees) < high
    assert 0.8 < np.sqrt(np.mean((errors / played.bound_sd[:, -1]) ** 2)) < 1.3


def test_two_condyles():
    """Twelve states on stiff discs. One that a condyle has left pushes no more: the search may end in such a kink."""
    record = recording("bilateral", patients=1, seconds=0.5).records[0]
    result = IteratedSmoother().smooth(record)
    assert result.converged or result.step < 0.2
    assert (np.diff(result.costs) < 0.0).all()
    assert (np.sqrt(np.diag(result.cov)) < record.prior.sd).all()


def test_coordinates_that_are_held_are_known_and_stay(record):
    """A jaw that cannot leave its plane."""
    short = held(record.until(0.5))
    result = IteratedSmoother().smooth(short)
    assert result.converged and (np.diff(result.costs) < 0.0).all()
    fixed = short.start_sd == 0.0
    assert fixed.sum() == 6
    np.testing.assert_array_equal(result.path.states[:, fixed], 0.0)
    assert np.ptp(result.path.states[:, ~fixed], axis=0).min() > 0.0
    assert (np.sqrt(np.diag(result.cov)) < record.prior.sd).all()


def test_each_time_has_the_estimate_of_the_record_until_then(record):
    both = IteratedSmoother(times=(0.5, 1.0)).estimate(record)
    np.testing.assert_allclose(both.time, [0.5, 1.0])
    for i, seconds in enumerate((0.5, 1.0)):
        alone = IteratedSmoother().estimate(record.until(seconds))
        np.testing.assert_array_equal(both.mean[i], alone.mean[0])
        np.testing.assert_array_equal(both.cov[i], alone.cov[0])


def test_the_truth_is_not_read(record):
    blind = replace(record.until(0.5), truth=None, states=None, wrenches=None)
    seeing = IteratedSmoother().estimate(record.until(0.5))
    np.testing.assert_array_equal(IteratedSmoother().estimate(blind).mean, seeing.mean)
