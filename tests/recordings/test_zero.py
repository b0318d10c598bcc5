"""A zero that drifts: seen where a recording ends as it began, and learnt where it does not."""

from dataclasses import replace

import numpy as np
import pytest

import jawenv
from agents import load_agent
from jawenv.commands.app import main
from jawenv.recordings.doctor.examination import examined
from jawenv.recordings.plausibility import findings
from jawenv.recordings.untold.learnt import identified_with_errors
from jawenv.recordings.zero import change_of_zero
from tests.recordings.several.test_together import played, saved


def closing(drift_N):
    """A recording that begins and ends with half a second of closed teeth, whose zero of z drifts."""
    record = played(0, "slow_opening")
    measured, samples = record.measured, record.samples
    rest, slack = np.repeat(measured[:1], 50, axis=0), np.zeros((50, 3, 6))
    noise = 1e-4 * np.random.default_rng(0).standard_normal((2, 50, 12))
    measured = np.concatenate([rest + noise[0], measured, rest + noise[1]])
    samples = np.concatenate([slack, samples, slack])
    samples[..., 2] += drift_N * np.linspace(0.0, 1.0, len(samples))[:, None]
    measured[:, 6:] = np.nan
    time = np.arange(len(measured)) * record.dt
    return replace(record, time=time, measured=measured, samples=samples, states=None, wrenches=None)


@pytest.mark.parametrize(("drift_N", "plausible"), [(0.0, True), (1.5, False)])
def test_a_zero_that_differs_between_the_ends_is_not_believed(drift_N, plausible, tmp_path, capsys):
    record = closing(drift_N)
    assert change_of_zero(record) == pytest.approx(drift_N, abs=0.4)
    zero = next(finding for finding in findings(record) if finding.columns.startswith("zero"))
    assert zero.plausible == plausible
    check = next(check for check in examined(record) if check.what == "zero")
    assert check.fine == plausible and "at the end" in check.value
    if not plausible:
        assert main(["identify", saved(record, tmp_path / "one.csv")]) == 3
        assert "- zero of force_*_N: differs by" in capsys.readouterr().out


def test_a_recording_that_ends_open_shows_no_drift():
    record = played(0, "slow_opening")
    assert change_of_zero(record) is None
    check = next(check for check in examined(record) if check.what == "zero")
    assert "a drift cannot be seen: end as you began" in check.value


def test_a_drift_in_a_slow_movement_is_learnt():
    """Without the size of a drift NEES/12 is 4.8, and it is believed."""
    world = {"record": True, "episode_s": 20.0, "cohort": "one_sided", "knowledge": "bench", "estimator": "none"}
    record = jawenv.play(load_agent("slow_opening"), patients=1, seed=410_000, env_kwargs=world).records[0]
    samples = record.samples.copy()
    samples[..., 2] += 2.0 * (1.0 - np.exp(-np.linspace(0.0, 4.0, len(samples))))[:, None]
    found, last = identified_with_errors(replace(record, samples=samples))
    error, cov = found.estimate.mean[-1] - record.truth, found.estimate.cov[-1]
    assert last.sizes["drift"] > 0.0 and error @ np.linalg.solve(cov, error) / 12 < 3.0
