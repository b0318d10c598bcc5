"""The environments' filter over records: the same to the bit, and honest where sensors fail."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from recorded import BODY, SWINGS, Waves, share

import jawenv
from agents import load_agent
from eval.thesis.methods.moment_balance import balance_of
from jawenv import Device, InputError, Knowledge, OnlineFilter
from jawenv.analysis.bound import bound_along
from jawenv.anatomy.knowledge import LEVELS
from jawenv.inference.likelihood import log_likelihood
from jawenv.metrics.calibration import nees_band
from jawenv.recordings.files import load_record, save_record
from jawenv.recordings.record_filter import TensionFilter
from jawenv.references.extended_kalman import ExtendedKalman

# As many columns as ``BODY`` has, and a mouthpiece that is turned.
TURNED = Knowledge(attachments=0.1, fossa=0.1, mass=0.1, head_tilt_deg=3.0, mouthpiece_deg=0.5, damping=0.2)
FAULTS = {"lost_share": 0.2, "frozen_share": 0.2}


@cache
def played(env_id, faulty, **more):
    kwargs = {"record": True, "control": "force", "episode_s": 3.0, "reality": FAULTS if faulty else None, **more}
    return jawenv.play(Waves(), patients=2, seed=5000, env_id=env_id, env_kwargs=kwargs)


@pytest.mark.parametrize("faulty", [False, True], ids=["sound", "faulty"])
def test_a_record_gives_the_environments_belief_to_the_bit(faulty):
    run = played("jawenv/Jaw-v3", faulty)
    for i, record in enumerate(run.records):
        estimate = TensionFilter().estimate(record)
        np.testing.assert_array_equal(estimate.mean, run.belief_mean[i])
        np.testing.assert_array_equal(estimate.cov, run.belief_cov[i])
        assert np.isnan(record.measured).any() == faulty


def test_a_record_of_one_point_gives_the_environments_belief_to_the_bit():
    run = played("jawenv/Jaw-v3", True, sensors="point", control="trajectory", control_hz=10)
    estimate = TensionFilter(every=10).estimate(run.records[0])
    np.testing.assert_array_equal(estimate.mean, run.belief_mean[0])
    np.testing.assert_array_equal(estimate.cov, run.belief_cov[0])


@pytest.mark.parametrize(
    "told",
    [
        {"knowledge": "imaged"},
        {"device": Device(unmodelled_time_s=0.5)},
        # slack where the jaw is pushed
        {"force_sensor": "straps", "device": Device(strap_pretension_N=0.0), "knowledge": Knowledge(**BODY)},
        {"force_sensor": "motors", "knowledge": TURNED},
    ],
    ids=["imaged", "memory", "straps", "motors"],
)
def test_a_file_says_what_is_known_within_sds_and_gives_the_environments_belief(told, tmp_path):
    """To the rounding of a file's numbers; another file has them from the caller."""
    run = played("jawenv/Jaw-v3", False, **told)
    record, path = run.records[0], tmp_path / "within_sds.csv"
    assert np.isnan(record.samples).any() == (told.get("force_sensor") == "straps")
    save_record(record, path)
    estimate = TensionFilter().estimate(load_record(path))
    np.testing.assert_allclose(estimate.mean, run.belief_mean[0], atol=2e-5)
    np.testing.assert_allclose(estimate.cov, run.belief_cov[0], atol=1e-6)
    save_record(replace(record, knowledge=Knowledge(), disturbance_time_s=0.0, force_sensor="cell"), path)
    told = {"device": Device(), **told}
    again = load_record(path, **told)
    np.testing.assert_allclose(TensionFilter().estimate(again).mean[-1], run.belief_mean[0, -1], atol=1e-6)


@pytest.mark.parametrize(
    "told",
    [{"knowledge": LEVELS["imaged"]}, {"disturbance_time_s": 0.5}, {"force_sensor": "straps", "device": Device()}],
)
@pytest.mark.parametrize(
    "estimate",
    [
        ExtendedKalman().estimate,
        balance_of,
        bound_along,
        lambda record: log_likelihood(record, record.truth),
    ],
)
def test_what_takes_all_as_exact_refuses_a_record_that_does_not(estimate, told):
    record = replace(played("jawenv/Jaw-v3", False).records[0], **told)
    with pytest.raises(InputError):
        estimate(record)


@pytest.mark.parametrize(
    "fields", [{"disturbance_time_s": -1.0}, {"disturbance_sd": np.full(6, np.nan)}, {"force_sensor": "spring"}]
)
def test_a_record_that_cannot_be_is_refused(fields):
    with pytest.raises(InputError):
        replace(played("jawenv/Jaw-v3", False).records[0], **fields)


def believing(record):
    """The record with what froze made a number that has changed: by its last bit, as far as a reading is precise."""
    measured, samples = record.measured.copy(), record.samples.copy()
    for k in range(1, len(measured)):
        same = measured[k] == measured[k - 1]
        measured[k, same] = np.nextafter(measured[k, same].astype(np.float32), np.float32(np.inf))
    last = np.full(6, np.nan)
    for rows in samples:
        for row in rows:
            same = row == last
            row[same] = np.nextafter(row[same].astype(np.float32), np.float32(np.inf))
            last = row
    return replace(record, measured=measured, samples=samples)


def at_end(record):
    estimate = TensionFilter().estimate(record)
    return share(record, estimate.mean[-1], estimate.cov[-1])


def test_what_failed_is_left_out_and_must_be():
    """A third of the readings. A component of the load cell that is held is doubted by no law of noise: wide enough."""
    kwargs = {"record": True, "episode_s": 10.0, "reality": FAULTS}
    run = jawenv.play(load_agent(SWINGS, control="force"), patients=8, seed=6100, env_kwargs=kwargs)
    assert not run.terminated.any()
    honest, naive = ([at_end(make(record)) for record in run.records] for make in (lambda record: record, believing))
    assert np.mean(honest) < nees_band(8, 12, 0.999)[1] / 12.0
    assert np.mean(naive) > 2.0 * np.mean(honest)


def test_a_sensor_that_dies_costs_information_alone():
    """An encoder of angles stops after 3 s; a filter that believes it is lost, or broken."""
    run = jawenv.play(
        load_agent(SWINGS, control="force"), patients=4, seed=6100, env_kwargs={"record": True, "episode_s": 10.0}
    )
    honest, naive = [], []
    for record in run.records:
        measured = record.measured.copy()
        measured[300:, 4] = measured[300, 4]
        dead = replace(record, measured=measured)
        honest.append(at_end(dead))
        naive.append(at_end(believing(dead)))
    assert np.median(honest) < nees_band(4, 12, 0.999)[1] / 12.0
    assert np.nan_to_num(naive, nan=np.inf).min() > 3.0 * max(honest)


def single(record):
    """One load-cell reading per row: a tick ends with the reading with which the next begins."""
    readings = np.concatenate([record.samples[:, 0], record.samples[-1:, 2]])
    middle = 0.5 * (readings[:-1] + readings[1:])
    return replace(record, samples=np.stack([readings[:-1], middle, readings[1:]], axis=1))


def stepped(record, cell_N=0.05, encoder=1e-4):
    """Readings in steps as large as their noise: 0.05 N, 0.1 mm and so on."""
    cell, steps = np.repeat([cell_N, 0.04 * cell_N], 3), encoder * np.repeat([1.0, 17.0, 10.0, 200.0], 3)
    measured = np.round(record.measured / steps) * steps
    return replace(record, measured=measured, samples=np.round(record.samples / cell) * cell)


def test_equal_neighbours_are_no_frozen_sensor():
    """Single readings, readings in steps and both leave hardly any out, and cost hardly any information."""
    kwargs = {"record": True, "episode_s": 8.0, "cohort": "healthy"}  # on the teeth all is equal
    (record,) = jawenv.play(load_agent(SWINGS), patients=1, seed=6100, env_kwargs=kwargs).records
    sd = TensionFilter().estimate(record).sd[-1]
    for changed in (single(record), stepped(record), stepped(single(record))):
        online, left_out = OnlineFilter.of_record(changed), 0
        for k, measured in enumerate(changed.measured):
            belief = online.update(measured, changed.samples[k - 1] if k else None)
            left_out += belief.left_out
        assert left_out < 0.01 * 18 * len(changed.measured)
        assert (belief.log_sd < 1.1 * sd).all()
        assert share(record, belief.log_mean, belief.log_cov) < 2.5 and belief.misfit < 1.0


def test_an_encoder_with_steps_that_dies_costs_information_alone():
    kwargs = {"record": True, "episode_s": 10.0, "cohort": "healthy"}
    for record in map(stepped, jawenv.play(load_agent(SWINGS), patients=2, seed=6100, env_kwargs=kwargs).records):
        measured = record.measured.copy()
        measured[300:, 4] = measured[300, 4]
        assert at_end(replace(record, measured=measured)) < 2.5
