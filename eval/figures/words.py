"""Figures in words: the same in the terminal, in the report and in captions."""

from __future__ import annotations

import math

from eval.figures.statistics import Interval

NOTHING = "–"


def number(value: float, digits: int = 1) -> str:
    """A number, `never` if it is infinite, a dash if there is none; no digits behind the point from 1000 on."""
    if math.isnan(value):
        return NOTHING
    if math.isinf(value):
        return "never"
    written = f"{value:.{digits if abs(value) < 1000.0 else 0}f}"
    if float(written) == 0.0:
        written = written.removeprefix("-")
    return written.replace("-", "\N{MINUS SIGN}")


def percent(value: float, digits: int = 1) -> str:
    """A share as a percentage, without its sign."""
    return number(100.0 * value, digits)


def raw(value: float) -> str:
    """A number for programs, as JavaScript reads it."""
    return "Infinity" if math.isinf(value) else f"{value:.6g}".replace("nan", "NaN")


def interval(estimate: Interval, digits: int = 1) -> str:
    """The ends of an interval, or nothing where there is none or all patients agree."""
    if not estimate.exists or estimate.low == estimate.high:
        return ""
    return f"{number(estimate.low, digits)} … {number(estimate.high, digits)}"


def with_interval(estimate: Interval, digits: int = 1, unit: str = "") -> str:
    """A figure with the ends of its interval: `1.2 % (0.9 … 1.3)`, without brackets where there is none."""
    ends = interval(estimate, digits)
    return f"{number(estimate.value, digits)}{unit}" + (f" ({ends})" if ends else "")


def scaled(estimate: Interval, factor: float) -> Interval:
    """An interval in another unit."""
    return Interval(factor * estimate.value, factor * estimate.low, factor * estimate.high)


def muscle(parameter: str) -> str:
    """`log_b/medial_pterygoid_left` as `medial pterygoid left`."""
    return parameter.split("/", 1)[1].replace("_", " ")


def parameter(name: str) -> str:
    """`log_b/medial_pterygoid_left` as `b of medial pterygoid left`."""
    return f"{name.split('/', 1)[0].removeprefix('log_')} of {muscle(name)}"


def label(entry: str) -> str:
    """An entry's name for people: spaces for underscores."""
    return entry.replace("_", " ")
