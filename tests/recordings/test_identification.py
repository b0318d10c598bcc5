"""Whether what is found in a recording is to be believed, and what the command says of it."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import jawenv
from agents import load_agent
from jawenv.base.errors import InputError
from jawenv.commands.app import main
from jawenv.metrics.verdicts import NOT_MEASURED, verdicts
from jawenv.recordings.files import load_record, save_record
from jawenv.recordings.identification import identified
from jawenv.recordings.online import OnlineFilter
from jawenv.recordings.plausibility import findings
from jawenv.recordings.record_filter import TensionFilter
from jawenv.references.extended_kalman import ExtendedKalman
from tests.recordings.spoilt import RATES, spoilings, spoilt


@cache
def record():
    agent = load_agent("opening_with_swings_and_fore_aft")
    (played,) = jawenv.play(agent, patients=1, seed=5000, env_kwargs={"record": True, "episode_s": 10.0}).records
    return played


def spoilt_record(name):
    return dict(spoilt(record(), 1.0))[name]


def test_a_sound_recording_is_believed():
    found, estimate = identified(record()), TensionFilter().estimate(record())
    assert found.believable and found.doubts == [] and found.misfit < 1.0
    assert (found.rows, found.refused, found.left_out) == (1001, 0, 0)
    assert found.numbers == 1001 * 12 + 1000 * 6
    np.testing.assert_array_equal(found.estimate.mean, estimate.mean)
    np.testing.assert_array_equal(found.estimate.cov, estimate.cov)
    assert len(findings(record())) == 9


@pytest.mark.parametrize("name", [name for name in (*spoilings(np.zeros(3)), *RATES) if "gain" not in name])
def test_a_spoilt_recording_is_not(name):
    """But for the gain of the cell, which stiff muscles would explain as well: calibrate it (docs/recordings.md)."""
    bad = spoilt_record(name)
    assert not (findings(bad)[0].plausible if name in RATES else identified(bad).believable)


def test_what_was_lost_is_no_doubt():
    measured, samples = record().measured.copy(), record().samples.copy()
    measured[1::3], samples[::20, 1, 2] = np.nan, np.nan
    found = identified(replace(record(), measured=measured, samples=samples))
    assert found.left_out == 0 and found.rows == 667 and found.believable


def test_bursts_without_a_load_cell_reading_are_missing_readings(tmp_path):
    """The online filter has the same bits; a recording keeps them as empty cells."""
    samples = record().samples.copy()
    for start in range(100, 900, 200):
        samples[start : start + 8] = np.nan
    lost = replace(record(), samples=samples)
    save_record(lost, tmp_path / "lost.csv")
    read = load_record(tmp_path / "lost.csv")
    np.testing.assert_array_equal(np.isnan(read.samples), np.isnan(samples))
    found, online = identified(read), OnlineFilter.of_record(read)
    beliefs = [online.update(row, read.samples[k - 1] if k else None) for k, row in enumerate(read.measured)]
    np.testing.assert_array_equal(found.estimate.mean[-1], beliefs[-1].log_mean)
    np.testing.assert_array_equal(TensionFilter().estimate(read).mean, found.estimate.mean)
    assert found.believable and found.left_out == 0
    with pytest.raises(InputError, match="times without a reading of the load cell; allowed: none"):
        ExtendedKalman().estimate(read)


def test_a_few_readings_that_are_far_off_are_no_doubt():
    measured, samples = record().measured.copy(), record().samples.copy()
    measured[50:54, 3], samples[100:103, :, 3] = -9999.0, 1e5
    found = identified(replace(record(), measured=measured, samples=samples))
    assert found.left_out == 7 and found.believable, found.doubts


@pytest.mark.parametrize("column", ["pitch", "place", "velocity"])
def test_only_what_was_read_is_judged(column):
    measured = record().measured.copy()
    measured[:, {"pitch": slice(3, 6), "place": slice(0, 3), "velocity": slice(6, 9)}[column]] = np.nan
    found = findings(replace(record(), measured=measured))
    assert all(each.plausible for each in found) and len(found) == {"pitch": 8, "place": 7, "velocity": 9}[column]


def test_radians_and_too_few_rows_are_told():
    measured = record().measured.copy()
    measured[:, 3:6] = np.radians(measured[:, 3:6])
    (told,) = [finding for finding in findings(replace(record(), measured=measured)) if not finding.plausible]
    assert told.columns == "pitch_deg" and "no radians" in told.allowed
    few = replace(
        record(),
        **{name: getattr(record(), name)[:3] for name in ("time", "measured")},
        samples=record().samples[:2],
        states=None,
        wrenches=None,
    )
    short, still = [finding for finding in findings(few) if not finding.plausible]
    assert short.value == "0.02 s, 3 rows" and "too short to judge" in short.allowed
    assert still.columns == "motion" and "tells nothing" in still.allowed


def test_a_jaw_that_was_not_moved_gets_no_verdict(tmp_path, capsys):
    """Its prior is that of stiff patients: the words are the data's or none."""
    (held,) = jawenv.play(
        load_agent("hold_still"), patients=1, seed=5000, env_kwargs={"record": True, "episode_s": 4.0}
    ).records
    assert main(["identify", saved(tmp_path, held)]) == 3
    out = capsys.readouterr().out
    assert "motion: " in out and "tells nothing" in out and out.count("no verdict") == 6
    found = identified(held)
    mean, cov = found.estimate.mean[-1], found.estimate.cov[-1]
    assert {verdict.word for verdict in verdicts(mean, cov, held.prior.sd)} == {NOT_MEASURED}


def saved(tmp_path, record, truth=False):
    path = tmp_path / "one.csv"
    save_record(record if truth else replace(record, truth=None, states=None, wrenches=None), path)
    return str(path)


def test_the_command_says_how_much_fitted_and_what_each_muscle_is(tmp_path, capsys):
    assert main(["identify", saved(tmp_path, record())]) == 0
    out = capsys.readouterr().out
    assert "1,001 read, 1,001 fitted, 0 refused" in out and "alarm:   silent" in out and "truth" not in out
    assert "F_o, N" in out and "left : right" in out and "NOT TO BE BELIEVED" not in out
    assert out.count("F_o/") == out.count("b/") == 6


def test_the_command_ends_with_3_and_what_to_look_at(tmp_path, capsys):
    path = saved(tmp_path, spoilt_record("forces of the jaw on the device"))
    assert main(["identify", path]) == 3
    out = capsys.readouterr().out
    assert "NOT TO BE BELIEVED" in out and "force x velocity" in out and "no verdict" in out and "Look at signs" in out


def test_an_impossible_rate_is_one_line(tmp_path, capsys):
    path = saved(tmp_path, spoilt_record("ms as s"))
    assert main(["identify", path]) == 2
    assert "time_s makes 0.1 Hz; allowed: 20 to 1000 Hz" in capsys.readouterr().err
    assert main(["doctor", path]) == 3


@pytest.mark.parametrize("name", [None, "forces of the jaw on the device"])
def test_a_page_of_a_recording(tmp_path, capsys, name):
    path = saved(tmp_path, record() if name is None else spoilt_record(name))
    assert main(["identify", path, "--page", str(tmp_path / "page.html")]) == (0 if name is None else 3)
    page = (tmp_path / "page.html").read_text(encoding="utf-8")
    assert "Recording “one”" in page and "10 s at 100 Hz" in page and "simulated." not in page.split("<footer>")[0]
    assert ("No verdict" in page) == (name is not None)


def test_a_page_needs_a_clone(tmp_path, capsys, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "eval.patient.recordings", None)
    assert main(["identify", saved(tmp_path, record()), "--page", str(tmp_path / "page.html")]) == 2
    said = capsys.readouterr()
    assert "a clone of the project" in said.err and said.err.count("\n") == 1 and said.out == ""


def test_a_page_does_not_take_the_place_of_its_recording(tmp_path, capsys):
    path = saved(tmp_path, record())
    (tmp_path / "page.html").symlink_to(path)
    before = (tmp_path / "page.html").read_bytes()
    assert main(["identify", path, "--page", str(tmp_path / "page.html")]) == 2
    assert "allowed: an output that is no input" in capsys.readouterr().err
    assert (tmp_path / "page.html").read_bytes() == before
