"""A log is read from three columns or refused in one line, and cut from a played episode."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from jawenv.answers.identify import _is_log
from jawenv.base.errors import InputError
from jawenv.recordings.stretcher.log import COLUMNS, log_of_table, windows
from jawenv.recordings.table import read_table
from jawenv.recordings.words import WORDS
from tests.stretched_logs import log_of, patient, written


@cache
def log():
    return log_of(patient())


def but_in_row_6(name, value):
    """The log's numbers of this name, another one in the sixth row of its file."""
    return lambda: {name: np.where(np.arange(300) == 4, value, getattr(log(), name))}


def times(factor, name):
    return lambda: {name: factor * getattr(log(), name)}


def table(given, path, **kwargs):
    written(given, path, **kwargs)
    return read_table(path, WORDS)


def test_three_columns_are_a_log(tmp_path):
    read = log_of_table(table(log(), tmp_path / "log.csv"))
    np.testing.assert_allclose([read.opening, read.force], [log().opening, log().force], atol=1e-4)


def test_a_mapping_says_names_and_units(tmp_path):
    columns = tmp_path / "map.toml"
    columns.write_text(
        'time_s = {name = "t", unit = "ms"}\nopening_mm = {name = "o", unit = "cm"}\n'
        'force_N = {name = "f", sign = -1}\n',
        encoding="utf-8",
    )
    given = table(log(), tmp_path / "log.csv", names=("t", "o", "f"), factors=(1e3, 0.1, -1.0))
    assert _is_log(given, columns) and not _is_log(given, None)
    read = log_of_table(given, columns)
    np.testing.assert_allclose([read.opening, read.force], [log().opening, log().force], atol=1e-3)


def test_rows_with_a_blank_are_left_out_and_equal_stamps_are_spread(tmp_path):
    blank = np.where(np.arange(300) == 4, np.nan, log().opening)
    read = log_of_table(table(replace(log(), opening=blank), tmp_path / "log.csv"))
    assert len(read.time) == 299 and not np.isnan(read.opening).any()
    whole = np.floor(log().time)
    read = log_of_table(table(replace(log(), time=whole), tmp_path / "log.csv"))
    assert (np.diff(read.time) > 0.0).all() and np.abs(read.time - whole).max() <= 1.0


@pytest.mark.parametrize(
    ("changed", "names", "told"),
    [
        (dict, ("time_s", "opening_mm", "Fz"), "column force_N is missing; allowed: time_s, opening_mm, force_N"),
        (but_in_row_6("opening", 99.0), COLUMNS, "opening_mm in row 6 is 99; allowed: -10 to 80"),
        (times(20.0, "force"), COLUMNS, "allowed: -20 to 100"),
        (times(-1.0, "force"), COLUMNS, "the force that opens the jaw (else sign = -1 in --columns FILE)"),
        (times(1e-3, "opening"), COLUMNS, "opening_mm changes by 0.0"),
        (times(0.0, "force"), COLUMNS, "force_N changes by 0; allowed: 2 or more"),
        (but_in_row_6("time", 0.0), COLUMNS, "time_s in row 6 is 0; allowed: growing times"),
    ],
)
def test_what_is_no_log_is_refused_in_one_line(tmp_path, changed, names, told):
    with pytest.raises(InputError) as refused:
        log_of_table(table(replace(log(), **changed()), tmp_path / "log.csv", names=names))
    assert told in str(refused.value)


def test_too_few_rows_are_refused(tmp_path):
    few = replace(log(), time=log().time[:59], opening=log().opening[:59], force=log().force[:59])
    with pytest.raises(InputError, match="has 59 rows; allowed: 60 or more"):
        log_of_table(table(few, tmp_path / "log.csv"))


def test_windows_find_the_noise_of_the_rows():
    seen = windows(log())
    factor = seen.opening_sd[3] / seen.force_sd[3]
    assert factor == pytest.approx(0.5 / 0.3, rel=0.2)
    assert seen.opening_sd[3] == pytest.approx(0.5 * np.sqrt(9.0 / 4.0 / 10.0), rel=0.15)  # of a parabola's middle
    assert 14 <= seen.loading.sum() <= 17
