"""Files as laboratories write them: one reading a row, a slow load cell, no velocities, no header."""

from functools import cache

import numpy as np
import pytest

import jawenv
from agents import load_agent
from jawenv.base.errors import InputError
from jawenv.commands.app import main
from jawenv.recordings.columns import READINGS
from jawenv.recordings.defaults import BENCH
from jawenv.recordings.files import load_record
from jawenv.recordings.plausibility import findings
from jawenv.recordings.untold.learnt import identified_with_errors
from research.anyone import lab_file


@cache
def played():
    world = {"record": True, "episode_s": 8.0, "cohort": "anyone", "knowledge": "imaged", "track_bound": False}
    return jawenv.play(load_agent("refined"), patients=1, seed=480_000, env_kwargs=world).records[0]


@pytest.mark.parametrize(("hz", "cell_hz"), [(60, 20), (120, 80), (240, 20)])
def test_a_slow_load_cell_is_read_on_lines(tmp_path, hz, cell_hz):
    lab_file(played(), hz, cell_hz, tmp_path / "lab.csv")
    record = load_record(tmp_path / "lab.csv", BENCH)
    assert np.isfinite(record.samples).all(axis=(1, 2)).mean() > 0.95
    found, _ = identified_with_errors(record)
    error, cov = found.estimate.mean[-1] - played().truth, found.estimate.cov[-1]
    assert found.believable, found.doubts
    assert error @ np.linalg.solve(cov, error) / 12 < 2.5 and found.estimate.sd[-1].max() < 0.4


def test_readings_that_are_held_and_forces_that_are_hardly_read_are_named(tmp_path):
    lab_file(played(), 100, 5, tmp_path / "lab.csv")
    (rare,) = (one for one in findings(load_record(tmp_path / "lab.csv", BENCH)) if not one.plausible)
    assert rare.value == "read in 0 % of the ticks" and "80 % or more" in rare.allowed
    lab_file(played(), 100, 20, tmp_path / "lab.csv")
    names, *rows = (line.split(",") for line in (tmp_path / "lab.csv").read_text(encoding="utf-8").splitlines())
    for before, row in zip(rows, rows[1:], strict=False):
        row[-6:] = before[-6:] if not row[-1] else [f"{float(value):.4f}" for value in row[-6:]]
    (tmp_path / "lab.csv").write_text("\n".join(map(",".join, [names, *rows])) + "\n", encoding="utf-8")
    (held,) = (one for one in findings(load_record(tmp_path / "lab.csv", BENCH)) if not one.plausible)
    assert "repeated readings in 80 %" in held.value and "leave the rows between empty" in held.allowed


def test_a_sensor_that_rounds_to_steps_repeats_no_reading(tmp_path):
    lab_file(played(), 100, 100, tmp_path / "lab.csv")
    record = load_record(tmp_path / "lab.csv", BENCH)
    record.measured[:] = np.round(record.measured, 3)
    record.samples[:] = np.round(record.samples, 1)
    assert all(one.plausible for one in findings(record))


SHORT = ["time_s", "mouthpiece_z_mm", *(column.name for column in READINGS)]


def table(tmp_path, rows, head="", names=SHORT):
    path = tmp_path / "bench.csv"
    lines = [",".join(row) for row in (names, *rows)]
    path.write_text(head + "\n".join(lines) + "\n", encoding="utf-8")
    return path


def test_readings_are_joined_up_to_a_tenth_of_a_second_also_of_two_clocks(tmp_path):
    times = np.arange(60) / 100.0
    force = [f"{t:.2f}" if k in (0, 10, 20, 40) else "" for k, t in enumerate(times)]
    rows = [[f"{t:.2f}", "-37", *[value] * 6] for t, value in zip(times, force, strict=True)]
    read = load_record(table(tmp_path, rows)).samples[:, 0, 0]
    np.testing.assert_allclose(read[:21], times[:21])
    assert np.isnan(read[21:40]).all() and read[40] == 0.4 and np.isnan(read[41:]).all()
    places = [[f"{t:.4f}", f"{-37 - t:.4f}", *[""] * 6] for t in np.arange(0, 0.5, 1 / 60)]
    cells = [[f"{t + 0.001:.4f}", "", *[f"{t + 0.001:.4f}"] * 6] for t in np.arange(0, 0.5, 1 / 80)]
    merged = load_record(table(tmp_path, sorted(places + cells, key=lambda row: float(row[0]))), resample_hz=100.0)
    np.testing.assert_allclose(merged.samples[1:40, 0, 0], merged.time[1:40], atol=1e-3)
    np.testing.assert_allclose(1e3 * merged.measured[:40, 2], -37 - merged.time[:40], atol=1e-3)


def test_rows_before_the_tracker_starts_are_cut(tmp_path):
    rows = [[f"{k / 100:.2f}", "" if k < 3 else "-37", *["0.1"] * 6] for k in range(9)]
    record = load_record(table(tmp_path, rows))
    assert len(record.time) == 6 and record.time[0] == 0.0
    with pytest.raises(InputError, match="no encoder was read; allowed"):
        load_record(table(tmp_path, [[row[0], "", *row[2:]] for row in rows]))


def test_comments_of_other_programs_are_passed_over_and_a_title_row_is_named(tmp_path):
    rows = [[f"{k / 100:.2f}", "-37", *["0.1"] * 6] for k in range(9)]
    assert len(load_record(table(tmp_path, rows, "% exported 2025\n// rate 100 Hz\n")).time) == 9
    with pytest.raises(InputError, match="row 2 has 8 values; allowed: 2, one per column, the first row holds"):
        load_record(table(tmp_path, rows, "Patient,7\n"))


@pytest.mark.parametrize("sign", ",.")
def test_separators_of_thousands_are_refused(tmp_path, sign):
    rows = [[str(k), f'"-37{sign}{k}00"', *[f'"{1 + k}{sign}234"' if k > 1 else "999"] * 6] for k in range(1, 5)]
    with pytest.raises(InputError, match="numbers as 1,234 alone; allowed: numbers without separators of thousands"):
        load_record(table(tmp_path, rows))


@pytest.mark.parametrize("gap", [-0.03, 0.5])
def test_what_resampling_cannot_mend_does_not_name_it(tmp_path, gap):
    rows = [[f"{k / 100 + gap * (k > 4):.2f}", "-37", *["0.1"] * 6] for k in range(9)]
    with pytest.raises(InputError, match="one take: cut the file before this row"):
        load_record(table(tmp_path, rows))


def spoilt(values, rng):
    """A table of numbers (T, n), whose first column is the time, with one to three faults."""
    values = values.copy()
    for kind in rng.integers(10, size=int(rng.integers(1, 4))):
        column, start = int(rng.integers(1, values.shape[1])), int(rng.integers(len(values) - 2))
        part, size = values[start : start + int(rng.integers(2, 300))], 10.0 ** rng.uniform(-2.0, 2.0)
        if kind == 0:
            values[start:, column] += size
        elif kind == 1:
            values[:, column] += size * np.linspace(0.0, 1.0, len(values))
        elif kind == 2:
            part[:, rng.random(values.shape[1]) < 0.5] = np.nan
            values[:, 0] = np.linspace(0.0, values[0, 0] + 0.01 * (len(values) - 1), len(values))
        elif kind == 3:
            values[:, column] *= rng.choice([-1.0, 0.0, 10.0, 1e3])
        elif kind == 4:
            part[:, column] = part[0, column]
        elif kind == 5:
            values[:, column] = np.round(values[:, column] / size) * size
        elif kind == 6:
            values[:, 1:] += 0.1 * size * rng.standard_normal(values[:, 1:].shape)
        elif kind == 7:
            part[:, column] = rng.choice([0.0, 1e5, -9999.0, 1e30])
        elif kind == 8:
            values[:, column] = np.roll(values[:, column], int(rng.integers(-50, 50)))
        else:
            part[:, 1:] = part[::-1, 1:].copy()
    return values


def test_no_spoilt_recording_ends_in_a_traceback(tmp_path, capsys):
    lab_file(played().until(4.0), 100, 100, tmp_path / "lab.csv")
    names, *lines = (line.split(",") for line in (tmp_path / "lab.csv").read_text(encoding="utf-8").splitlines())
    values = np.array(lines, dtype=np.float64)
    for seed in range(10):
        changed = spoilt(values, np.random.default_rng([7, seed]))
        rows = [["" if np.isnan(value) else f"{value:.9g}" for value in row] for row in changed]
        (tmp_path / "lab.csv").write_text("\n".join(map(",".join, [names, *rows])) + "\n", encoding="utf-8")
        code = main(["identify", str(tmp_path / "lab.csv"), "--json", str(tmp_path / "answer.json")])
        assert code in (0, 2, 3), seed
        assert code == 2 or "nan" not in capsys.readouterr().out, seed
