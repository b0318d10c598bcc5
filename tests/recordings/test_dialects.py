"""Files as people have them give what the project's own file gives, or one line."""

import numpy as np
import pytest

from jawenv.base.errors import InputError
from jawenv.recordings.columns import READINGS
from jawenv.recordings.dialects import read_sheet
from jawenv.recordings.files import load_record

NAMES = ["time_s", "mouthpiece_x_mm", "pitch_deg", *(column.name for column in READINGS)]
ROWS = [
    ["0", "80.5", "0", "1", "2", "3", "0.1", "0.2", "0.3"],
    ["0.01", "81", "", "2", "2", "3", "0.1", "0.2", "0.3"],
    ["0.02", "82", "2.25", "3", "2", "3", "0.1", "0.2", "0.3"],
]


def written(tmp_path, rows=ROWS, names=NAMES, sep=",", head="", encoding="utf-8", end="\n"):
    path = tmp_path / "bench.csv"
    path.write_bytes((head + end.join(sep.join(row) for row in (names, *rows)) + end).encode(encoding))
    return path


def commas(rows):
    return [[cell.replace(".", ",") for cell in row] for row in rows]


@pytest.mark.parametrize(
    "said",
    [
        {"sep": ";"},
        {"sep": "\t"},
        {"sep": ";", "rows": commas(ROWS)},
        {"rows": [[f'"{cell}"' for cell in row] for row in commas(ROWS)]},
        {"sep": ";", "head": "sep=;\n"},
        {"encoding": "utf-16"},
        {"encoding": "utf-8-sig"},
        {"encoding": "latin-1", "head": "# Winkel in °, Müller\n"},
        {"end": "\r\n"},
        {"end": "\r"},
        {"sep": ", "},
        {"names": [f'"{name}"' for name in NAMES]},
        {"names": [*NAMES, ""], "rows": [[*row, ""] for row in ROWS]},
        {"names": ["", *NAMES], "rows": [[str(i), *row] for i, row in enumerate(ROWS)]},
        {"rows": [["# a maneuver"], *ROWS, ["# its end"]]},
        {"rows": [["s", "mm", "[deg]", *3 * ["N"], "N·m", "Nm", ""], *ROWS]},
        {"rows": [ROWS[0], [cell or "n/a" for cell in ROWS[1]], ROWS[2]]},
    ],
)
def test_every_dialect_is_the_same_table(tmp_path, said):
    record = load_record(written(tmp_path, **said))
    np.testing.assert_allclose(record.measured[:, 0], [0.0805, 0.081, 0.082])
    np.testing.assert_allclose(record.measured[:, 3], np.radians([0.0, np.nan, 2.25]))
    np.testing.assert_allclose(record.samples[:, 0, 0], [1.0, 2.0])


@pytest.mark.parametrize(
    ("said", "told"),
    [
        ({"rows": [["s", "m", "deg", *6 * [""]], *ROWS]}, "mouthpiece_x_mm is in 'm'; allowed: mm, or a mapping file"),
        ({"sep": ";", "rows": [*ROWS[:2], *commas(ROWS[2:])]}, "has decimal points and decimal commas"),
        ({"rows": commas(ROWS)}, "row 2 has 13 values"),
        ({"rows": [ROWS[0], ["0.01", "1_000", *ROWS[1][2:]], ROWS[2]]}, "mouthpiece_x_mm in row 3 is '1_000'"),
        ({"rows": [ROWS[0], ["0.01", "١٢", *ROWS[1][2:]], ROWS[2]]}, "mouthpiece_x_mm in row 3 is"),
        ({"rows": [*ROWS, NAMES]}, "time_s in row 5 is 'time_s'"),
        ({"head": '"'}, "a quotation mark is not closed"),
    ],
)
def test_what_is_no_dialect_is_one_line(tmp_path, said, told):
    with pytest.raises(InputError) as caught:
        load_record(written(tmp_path, **said))
    assert told in str(caught.value) and "\n" not in str(caught.value)


MAP = """
time_s = {name = "t", unit = "ms"}
mouthpiece_x_mm = {name = "Z", unit = "m", sign = -1}
pitch_deg = {name = "gape", unit = "rad"}
"""
FOREIGN = ["t", "Z", "gape", *NAMES[3:], "note"]
FOREIGN_ROWS = [[str(10 * i), f"-0.08{i}", "0.1", *row[3:], "7"] for i, row in enumerate(ROWS)]


def test_a_mapping_file_says_names_units_signs_and_axes(tmp_path):
    (tmp_path / "map.toml").write_text(MAP)
    record = load_record(written(tmp_path, FOREIGN_ROWS, FOREIGN), columns=tmp_path / "map.toml")
    np.testing.assert_allclose(record.time, [0.0, 0.01, 0.02])
    np.testing.assert_allclose(record.measured[:, 0], [0.080, 0.081, 0.082])
    np.testing.assert_allclose(record.measured[:, 3], 0.1)


@pytest.mark.parametrize(
    ("mapping", "told"),
    [
        ('pitch = {name = "gape"}', "did you mean pitch_deg?"),
        ('pitch_deg = {name = "gap"}', "column 'gap' for pitch_deg is missing; did you mean gape?"),
        ('pitch_deg = {name = "gape", unit = "mm"}', "pitch_deg has unit 'mm'; allowed: deg, rad, mrad"),
        ('pitch_deg = {name = "gape", sign = 2}', "sign"),
        ('pitch_deg = "gape"', "pitch_deg"),
    ],
)
def test_a_wrong_mapping_is_one_line(tmp_path, mapping, told):
    (tmp_path / "map.toml").write_text(f"{MAP.replace('pitch', '# pitch')}\n{mapping}\n")
    with pytest.raises(InputError) as caught:
        load_record(written(tmp_path, FOREIGN_ROWS, FOREIGN), columns=tmp_path / "map.toml")
    assert told in str(caught.value) and "\n" not in str(caught.value)


def timed(times):
    return [[repr(float(t)), repr(80.0 + 100.0 * float(t)), "1", *ROWS[0][3:]] for t in times]


def test_uneven_times_are_resampled_when_asked_for(tmp_path):
    path = written(tmp_path, timed([0.0, 0.011, 0.018, 0.031, 0.04]))
    with pytest.raises(InputError, match="or --resample HZ"):
        load_record(path)
    record = load_record(path, resample_hz=100.0)
    np.testing.assert_allclose(record.time, [0.0, 0.01, 0.02, 0.03, 0.04])
    np.testing.assert_allclose(record.measured[:, 0], [0.080, 0.081, 0.082, 0.083, 0.084])
    for bad in (0.0, np.nan, 1e6):
        with pytest.raises(InputError, match="resample is .* Hz; allowed: 10 to 10000"):
            load_record(path, resample_hz=bad)
    with pytest.raises(InputError, match="row 4 is 0.51, 0.5 s after the row before"):
        load_record(written(tmp_path, timed([0.0, 0.01, 0.51])), resample_hz=100.0)


def test_unix_times_are_even(tmp_path):
    record = load_record(written(tmp_path, timed(1.7e9 + np.arange(500) / 100.0)))
    assert record.dt == pytest.approx(0.01, rel=1e-6) and record.time[0] == 0.0


@pytest.mark.parametrize("hz", [60.0, 75.0, 100.0, 120.0, 150.0, 240.0, 300.0, 500.0, 1000.0])
@pytest.mark.parametrize("stamp", [np.round, lambda times: np.floor(times + 1e-6), lambda times: np.ceil(times - 1e-6)])
def test_stamps_in_milliseconds_are_even(tmp_path, hz, stamp):
    times = stamp(1e3 * (0.4 + np.arange(3000) / hz)) / 1e3
    assert load_record(written(tmp_path, timed(times))).dt == pytest.approx(1.0 / hz, rel=1e-3)
    six_digits = [float(f"{time:.6g}") for time in 95.0 + np.arange(3000) / hz]
    assert load_record(written(tmp_path, timed(six_digits))).dt == pytest.approx(1.0 / hz, rel=1e-3)
    for gone in (1, 1500, 2998):
        with pytest.raises(InputError, match="even steps.*or --resample HZ"):
            load_record(written(tmp_path, timed(np.delete(times, gone))))


def test_a_clock_that_speeds_up_is_not_even(tmp_path):
    steps = np.linspace(0.0098, 0.0102, 1000)
    with pytest.raises(InputError, match="even steps, 0.01.* s in most rows"):
        load_record(written(tmp_path, timed(np.cumsum(steps))))


@pytest.mark.parametrize(
    ("word", "told"),
    [
        ("measurement_sd: [1e-4]", "a list of 12 finite numbers"),
        ("measurement_sd: 0.1", "a list of 12 finite numbers"),
        ("wrench_sd: [[1, 1, 1, 1, 1, 1]]", "a list of 6 finite numbers"),
        ("start_sd: [1, 1, 1, 1, 1, 1, 1, 1, 1, -1]", "a list of 10 finite numbers from 0"),
        ("start_mean: [1, [2]]", "a list of 10 finite numbers"),
        ("gain_sd: -1", "a finite number from 0 to 1"),
        ("gain_sd: [0.1]", "a finite number"),
        ("gain_sd: true", "a finite number"),
        ("head_tilt_deg: 1e6", "from -90 to 90"),
        ("disturbance_time_s: NaN", "a finite number"),
        ("prior_mean: [0]", "without prior_sd"),
        (f"prior_mean: {[0] * 12}\n# prior_sd: {[1e300] * 12}", "prior_sd is"),
        ("truth: [0.1]", "a list of 12"),
        ("cohort: 7", "a name in quotation marks"),
    ],
)
def test_a_word_of_wrong_shape_kind_or_size_is_one_line(tmp_path, word, told):
    with pytest.raises(InputError) as caught:
        load_record(written(tmp_path, head=f"# {word}\n"))
    assert told in str(caught.value) and "\n" not in str(caught.value)


def test_a_row_has_a_bounded_length(tmp_path):
    (tmp_path / "long.csv").write_text("time_s," * 10_000 + "\n0\n")
    with pytest.raises(InputError, match="row 1 has 70,000 characters; allowed: 65,536"):
        read_sheet(tmp_path / "long.csv", 2**20)
