"""What errors take from the score later: the kernel's forecast against what a record's future truly takes."""

import newton_euler as twin
import numpy as np
import pytest
from running import Running

import jawenv
from agents import load_agent
from jawenv.estimation.aftermath import MOST_TICKS, limit_aftermath
from jawenv.estimation.thinning import divided, thinned


def along(record, ticks):
    """The kernel's M at the end of each tick, before its readings; and that of the record's own future, from its end.

    The future's is by matrices: T becomes A T A^T in a step and (I - K H) T (I - K H)^T in an update, and each reading
    takes h T h^T / S from the score.
    """
    running = Running(record, record.truth)
    running.update(0)
    rules, forecast = [], []
    for k in range(ticks):
        running.predict(k)
        forecast.append(running.belief["aftermath"].copy())
        A, P = running.scratch["total"][:, : running.size].copy(), running.belief["motion_cov"].copy()
        path, read = running.belief["motion"].copy(), np.isfinite(record.measured[k + 1]).all()
        rest, taken = np.eye(running.size), np.zeros_like(P)
        if read:
            rows = twin.derivative(lambda s: twin.measurement(record.jaw, s), path)
            for h, r in zip(rows, running.variances, strict=True):
                S = h @ P @ h + r
                taken += rest.T @ np.outer(h, h) @ rest / S
                one = np.eye(running.size) - np.outer(P @ h, h) / S
                P, rest = one @ P, one @ rest
        rules.append((A, rest, taken))
        running.update(k + 1, np.full(12, read, dtype=np.uint8))
    truth, M = [], np.zeros((running.size, running.size))
    for A, rest, taken in reversed(rules):
        M = rest.T @ M @ rest + taken
        truth.append(M)
        M = A.T @ M @ A
    return np.array(forecast), np.array(truth[::-1]), running


def slow_record(every):
    """Of a jaw held still, whose coming ticks are like the past ones but for the noise."""
    played = jawenv.play(
        load_agent("hold_still"), patients=1, seed=10_000, env_kwargs={"record": True, "episode_s": 6.0}
    )
    return divided(thinned(played.records[0], every), every)


@pytest.mark.parametrize("every", [1, 5, 20])
def test_the_forecast_is_what_the_future_takes(every):
    """Far from the ends of the record, in every tick between two readings; in sds of the motion's errors."""
    record = slow_record(every)
    forecast, truth, running = along(record, 560)
    sd = np.sqrt(np.diag(running.belief["motion_cov"]))
    middle = slice(240, 400)
    found, expected = (M[middle] * np.outer(sd, sd) for M in (forecast, truth))
    off = np.linalg.norm(found - expected, axis=(1, 2)) / np.linalg.norm(expected, axis=(1, 2))
    assert np.median(off) < 0.05
    if every > 1:
        # M of a tick is not that of another tick: taken a third of the time between readings too late it is far off.
        late = np.roll(expected, every // 3 + 1, axis=0)
        assert np.median(np.linalg.norm(late - expected, axis=(1, 2)) / np.linalg.norm(expected, axis=(1, 2))) > 0.3


def test_readings_farther_apart_than_are_told_apart_are_forecast_from_the_first_of_them():
    """The ticks beyond are one long step: M after the reading is as exact as ever."""
    record = slow_record(20)
    apart = MOST_TICKS + 20
    record.measured[np.arange(len(record.measured)) % apart != 0] = np.nan
    forecast, truth, running = along(record, 9 * apart)
    sd = np.sqrt(np.diag(running.belief["motion_cov"]))
    first = np.arange(4 * apart, 6 * apart, apart)
    found, expected = (M[first] * np.outer(sd, sd) for M in (forecast, truth))
    np.testing.assert_allclose(found, expected, atol=0.1 * np.abs(expected).max())


def test_innovations_say_no_more_of_an_error_than_there_is_to_know(rng):
    """M <= P^-1, so that trace(M P) is n at most; a smaller one stays as it is."""
    factor = rng.normal(size=(10, 14))
    P = factor @ factor.T
    small = 0.5 * np.linalg.inv(P)
    M = small.copy()
    limit_aftermath(M, P)
    np.testing.assert_array_equal(M, small)
    M = 40.0 * np.linalg.inv(P)
    limit_aftermath(M, P)
    np.testing.assert_allclose(M, np.linalg.inv(P), rtol=1e-9, atol=1e-12)
