"""How messages show a value: in one short line, whatever it is."""

import shutil

import numpy as np
import pytest

from jawenv.base.errors import LONGEST_SHOWN_VALUE, InputError, not_among, reason_of, shown
from jawenv.base.numeric_fields import real_number, whole_number


@pytest.mark.parametrize(
    "value", [object(), np.zeros((50, 50)), "a" * 500, "a\nb", list(range(1000)), {i: "x" * 100 for i in range(50)}]
)
def test_any_value_is_shown_in_one_short_line(value):
    text = shown(value)
    assert 0 < len(text) <= LONGEST_SHOWN_VALUE
    assert "\n" not in text


def test_an_integer_that_python_does_not_write_out():
    assert shown(10**5000) == "an integer too long to show"


@pytest.mark.parametrize(
    "error", [OSError("symbolic link"), OSError(28, "No space left"), shutil.Error(), ValueError("null character")]
)
def test_no_message_ends_in_none(error):
    assert reason_of(error) in {"symbolic link", "No space left", "Error", "null character"}


def test_short_values_are_shown_as_they_are():
    for value in (3, 0.1, "cats", None, [1, 2], {"a": 1}, (30 + 0j), 10**24):
        assert shown(value) == repr(value)


@pytest.mark.parametrize(
    ("value", "number"),
    [
        (3, 3.0),
        (np.int8(3), 3.0),
        (np.float32(0.5), 0.5),
        (True, None),
        (np.bool_(True), None),
        (1j, None),
        (np.complex128(1), None),
        ("1", None),
        (float("nan"), None),
        (np.float64("inf"), None),
        (10**400, None),
        (np.array(3), None),
    ],
)
def test_real_numbers(value, number):
    assert real_number(value) == number


@pytest.mark.parametrize(
    ("value", "number"), [(3, 3), (np.uint8(3), 3), (10**30, 10**30), (3.0, None), (True, None), ("3", None)]
)
def test_whole_numbers(value, number):
    assert whole_number(value) == number
    assert number is None or type(whole_number(value)) is int


@pytest.mark.parametrize("message", ["a\x1b[2Jb", "two\nlines", "tab\tbell\a", "turned \u202e round", "\u2028"])
def test_a_message_is_one_line_that_steers_no_terminal(message: str) -> None:
    told = str(InputError(f"key {message}: unknown"))
    assert told.isprintable() and told.startswith("key ")


def test_a_message_has_a_bounded_length() -> None:
    assert len(str(InputError("x" * 10**6))) == 800


def test_a_name_that_is_not_among_those_allowed_is_told_with_what_may_have_been_meant() -> None:
    told = str(not_among("cohort", "onesided", ["one_sided", "wide"], ", or a file"))
    assert told == "cohort is 'onesided'; did you mean one_sided? allowed: one_sided, wide, or a file"
