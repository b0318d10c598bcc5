"""The filter's steps for nuisances: they do nothing, and ``changes`` is not loaded, where a belief has none."""

from __future__ import annotations

from functools import cache
from typing import Annotated

import numpy as np

from jawenv.device.device import N_ERRORS, N_MOTORS
from jawenv.filter.belief.state import Belief, FilterSettings, Nuisances
from jawenv.filter.model.encoders import N_MEASUREMENTS
from jawenv.kernels.compiled import where
from jawenv.kernels.records import Array, record_dtype
from jawenv.mechanics.jaw import Jaw, jaw_dtype

_CHANGES = "jawenv.filter.nuisances.changes"


class NuisanceScratch:
    """Working memory of what nuisances change."""

    jaw: Jaw
    expected: Annotated[Array, N_MEASUREMENTS]
    changed: Annotated[Array, N_MEASUREMENTS]
    motor_errors: Annotated[Array, N_MOTORS, N_ERRORS]
    friction_share: Annotated[Array, N_MOTORS]  # half way through the tick


@cache
def nuisance_scratch_dtype(n_lines: int, n: int) -> np.dtype[np.void]:
    """Dtype of ``NuisanceScratch``."""
    return record_dtype(NuisanceScratch, jaw=jaw_dtype(n_lines if n else 1))


def no_nuisances(belief):
    """Whether the muscles alone are unknown, by the belief's type."""
    return not belief.typeof("nuisances").shape[0]


@where(no_nuisances, otherwise=f"{_CHANGES}.begin_jaw")
def begin_jaw(jaw: Jaw, belief: Belief):
    """The filter's own model begins as ``jaw``."""


@where(no_nuisances, otherwise=f"{_CHANGES}.set_nuisance_wrenches")
def set_nuisance_wrenches(jaw: Jaw, muscles, belief: Belief, pose, settings: FilterSettings, scratch):
    """The wrench of one sd of each nuisance, into its column."""


@where(no_nuisances, otherwise=f"{_CHANGES}.add_nuisance_readings")
def add_nuisance_readings(jaw: Jaw, belief: Belief, settings: FilterSettings, used, scratch):
    """The change of the readings by one sd of each nuisance, into its column."""


@where(no_nuisances, otherwise=f"{_CHANGES}.correct_samples")
def correct_samples(jaw: Jaw, belief: Belief, settings: FilterSettings, samples, scratch):
    """Correct the ``samples`` (3, 6) of the force by the nuisances' means."""


@where(no_nuisances, otherwise=f"{_CHANGES}.correct_readings")
def correct_readings(belief: Belief, nuisances: Nuisances, measured, corrected):
    """``corrected`` (12) = ``measured`` turned back, as far as the belief knows."""
    corrected[:] = measured


@where(no_nuisances, otherwise=f"{_CHANGES}.follow_friction")
def follow_friction(jaw: Jaw, belief: Belief, settings: FilterSettings, scratch):
    """The shares of the motors' friction at the end of a tick, from the motion."""


@where(no_nuisances, otherwise=f"{_CHANGES}.move_nuisances")
def move_nuisances(belief: Belief, settings: FilterSettings, row, first):
    """Move the nuisances and the filter's model by the steps that ``row`` has from ``first`` on."""
