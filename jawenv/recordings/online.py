"""The environments' own filter as an object that a device's loop calls once per tick."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from jawenv.base.errors import InputError, shown
from jawenv.base.numeric_fields import whole_number
from jawenv.envs.configuration import Configuration, configure
from jawenv.envs.world.kept_ticks import keep_reading
from jawenv.filter.belief.state import FilterSettings, belief_dtype, filter_settings_dtype
from jawenv.filter.learn import conclude
from jawenv.filter.model.encoders import N_MEASUREMENTS
from jawenv.filter.model.motion_step import N_SAMPLES
from jawenv.filter.settled import settled
from jawenv.filter.tick import (
    LAST_WINDOW,
    ROW,
    FilterScratch,
    begin_filter,
    filter_scratch_dtype,
    filter_tick,
)
from jawenv.kernels.compiled import njit
from jawenv.kernels.records import record_zeros
from jawenv.mechanics.dynamics import N_WRENCH
from jawenv.mechanics.jaw import Jaw
from jawenv.recordings import defaults
from jawenv.recordings.filter_settings import settings_of_configuration, settings_of_record
from jawenv.recordings.online_belief import OnlineBelief
from jawenv.recordings.record import Record
from jawenv.recordings.resolved import unread

Array = NDArray[np.float64]

EVERY = 5  # ticks from one belief to the next, where nothing says otherwise


class OnlineFilter:
    """The filter of the environments, fed by a device at 100 Hz.

    All memory is allocated and all kernels are compiled or loaded before the constructor returns. Readings are filtered
    again where the belief has moved far, at the latest after 20,480 ticks: such an update filters all readings before
    it, so a loop must be able to queue some (measured: 0.06 ms for most updates, and 0.007 ms more for each reading
    filtered again, 0.045 ms with ``knowledge="imaged"``).

    Args:
        configuration: An environment's, as its attribute ``configuration``; the default environment's without it,
            and the cohort anyone.
        head_tilt_deg: Pitch of the head, positive looking down.
        jaw: A geometry of one's own with that model's muscles, from ``jawenv.mechanics.build_jaw``, which has the tilt;
            sds of mass and inertia are relative to the environment's mandible.
        every: Ticks from one belief to the next; by default those of the configuration's control step, or 5 without it.
        **settings: Arguments of the environments by name, which come before the configuration: ``model``, ``cohort``
            (whose prior is the first belief), ``device`` (with its noise), ``sensors``, ``knowledge``, ``anatomy``,
            ``force_sensor`` (the samples are those of the load cell, or the wrench that the motors' or straps' readings
            make along their believed directions).

    Raises:
        InputError: an argument has a value that is not allowed.
    """

    names: tuple[str, ...]
    """Names of the parameters."""
    tick_s: float
    """S from one update to the next."""

    def __init__(
        self,
        configuration: Configuration | None = None,
        *,
        head_tilt_deg: float = 0.0,
        jaw: Any | None = None,
        every: int | None = None,
        **settings: Any,
    ) -> None:
        """Check the arguments, allocate and compile."""
        world = configure(settings, type(self), configuration or defaults.UNLABELLED)
        own = defaults.geometry_of(world, head_tilt_deg)
        if jaw is not None:
            if len(jaw["l_o"]) != len(own["l_o"]) or head_tilt_deg != 0.0:
                raise InputError(
                    f"jaw has {len(jaw['l_o'])} lines, head_tilt_deg is {head_tilt_deg:g}; "
                    f"allowed with model {world.model!r}: {len(own['l_o'])} lines, tilt 0"
                )
            own = jaw
        if every is None:
            every = EVERY if configuration is None else configuration.ticks_per_step
        self._start: tuple[Array, Array] | None = None
        self._unread = unread(world, own)
        self._prepare(own, settings_of_configuration(world, own), self._unread.parameter_names, every)

    @classmethod
    def of_record(cls, record: Record, *, every: int = EVERY) -> OnlineFilter:
        """The filter with a record's geometry, knowledge, noise, prior, length of a tick, and motion at the start."""
        online = cls.__new__(cls)
        online._start, online._unread = (record.start_mean, record.start_sd), record
        online._prepare(record.jaw, settings_of_record(record), record.parameter_names, every)
        return online

    def _prepare(self, jaw: Any, settings: Any, names: tuple[str, ...], every: int) -> None:
        """Allocate, and run every kernel once: no update waits for a compilation."""
        whole = whole_number(every)
        if whole is None or whole < 1:
            raise InputError(f"every is {shown(every)}; allowed: a whole number, 1 or more")
        muscles, lines = len(names) // 2, len(jaw["l_o"])
        nuisances, disturbance = len(settings["nuisances"]["mass"]), len(settings["disturbance_variance"])
        states = len(settings["start_sd"]) - disturbance
        own_lines = lines if nuisances else 1  # one type of settings, whatever they were made for
        sizes = nuisances, disturbance
        self._settings: Any = record_zeros(1, filter_settings_dtype(muscles, states, own_lines, *sizes))[0]
        for name in self._settings.dtype.names:
            if name != "nuisances" or nuisances:
                self._settings[name] = settings[name]
        self._jaw, self._every, self._states = jaw.copy(), whole, states
        self._belief, self._kept = record_zeros(2, belief_dtype(muscles, states, lines, *sizes))
        self._rows: Any = record_zeros(LAST_WINDOW + 1, ROW)
        self._scratch: Any = record_zeros(1, filter_scratch_dtype(muscles, lines, states, *sizes))[0]
        self._start_sd = self._settings["start_sd"][:states].copy()
        self._measured, self._samples = np.empty(N_MEASUREMENTS), np.empty((N_SAMPLES, N_WRENCH))
        self._used = self._settings["used"].astype(bool)
        self.names, self.tick_s = names, float(self._settings["dt"])
        self._run_once()
        self.reset()

    def _run_once(self) -> None:
        """Run every kernel, so that it is compiled or loaded."""
        self._measured.fill(np.nan)
        self._samples.fill(np.nan)
        self._begin(
            defaults.motion_of_reading(self._jaw, np.zeros(N_MEASUREMENTS), np.ones(N_MEASUREMENTS)), self._start_sd
        )
        self._tick = 0
        self._take()

    def reset(self, start_mean: ArrayLike | None = None) -> None:
        """Forget all readings; the next update is the first.

        Args:
            start_mean: (n,) motion (q, u) of the jaw before the first reading, within 1 mm, 1 degree, 1 mm/s and 0.01
                rad/s (sds). None for that of the record that the filter was made from, or else for what explains the
                first reading best, with an sd so wide that the reading decides.

        Raises:
            InputError: an array has the wrong shape or holds what it must not.
        """
        begun = self._start
        if start_mean is not None:
            begun = _numbers("start_mean", start_mean, (self._states,)), self._start_sd
            if not np.isfinite(begun[0]).all():
                raise InputError("start_mean holds what is not allowed: finite numbers")
        self._tick = -1
        self._waiting = begun is None
        if begun is not None:
            self._begin(*begun)

    def update(self, measured: ArrayLike, samples: ArrayLike | None = None) -> OnlineBelief:
        """Take the readings of one tick. The first update is the start, at which the encoders alone are read.

        Args:
            measured: (12,) encoders at the tick's end: mouthpiece position (m, head axes), Euler angles theta, psi,
                alpha (rad), mouthpiece velocity (m/s), angular velocity (rad/s, body axes); NaN where not read.
            samples: (3, 6) load cell at start, middle and end of the tick: force (N) and moment (N m) of the device on
                the mouthpiece, body axes; NaN where not read. The first update ignores them.

        Returns:
            What is believed now, in arrays of its own.

        Raises:
            InputError: an array has the wrong shape, or nothing is known of where the jaw starts. The filter is as
                it was.
        """
        reading = _numbers("measured", measured, (N_MEASUREMENTS,))
        if self._tick < 0:
            if self._waiting:
                self._begin_at(reading)
            self._samples.fill(np.nan)
        elif samples is None:
            raise InputError("samples is None; allowed after the first update: shape (3, 6), NaN where not read")
        else:
            self._samples[:] = _numbers("samples", samples, (N_SAMPLES, N_WRENCH))
        self._measured[:] = reading
        self._tick += 1
        return self._present_belief(self._take())

    def record(self) -> Record:
        """What was read so far as a recording: at most 20,480 ticks. ``untold.learnt`` learns sizes of errors from it.

        Raises:
            InputError: fewer than two updates.
        """
        if self._tick < 1:
            raise InputError(f"{self._tick + 1} updates were made; allowed: 2 or more")
        rows = self._rows[: self._tick + 1]
        return replace(
            self._unread,
            time=self.tick_s * np.arange(len(rows), dtype=np.float64),
            measured=rows["measured"].astype(np.float64),
            samples=rows["samples"][1:].astype(np.float64),
            start_mean=self._belief["began"].copy(),
            start_sd=self._settings["start_sd"][: self._states].copy(),
            states=None,
            wrenches=None,
        )

    def _begin_at(self, measured: Array) -> None:
        """Begin with the motion that explains the first reading best."""
        read = np.where(self._used & np.isfinite(measured), measured, np.nan)
        if np.isnan(read).all():
            raise InputError("measured holds no reading at the first update; allowed: one number or more")
        sd = np.sqrt(self._settings["measurement_variance"])
        self._begin(defaults.motion_of_reading(self._jaw, read, sd), defaults.start_sd(self._jaw))
        self._waiting = False

    def _begin(self, mean: Array, sd: Array) -> None:
        """Begin with the prior of the parameters, and mean and sd (n) of the motion."""
        self._settings["start_sd"][: self._states] = sd
        begin_filter(self._jaw, self._belief, mean, self._settings)
        self._gated = 0

    def _take(self) -> int:
        """Filter the readings in ``_measured`` and ``_samples``; returns how many were left out."""
        beliefs, clock = (self._belief, self._kept), (self._tick, self._every)
        read = self._measured, self._samples
        left_out, refused = take_tick(self._jaw, beliefs, self._rows, clock, *read, self._settings, self._scratch)
        self._gated += int(refused)
        return int(left_out)

    def _present_belief(self, left_out: int) -> OnlineBelief:
        """A copy of the present belief."""
        belief = self._belief
        moved, sd = belief["mean"] - belief["replayed_at"], np.sqrt(np.diagonal(belief["cov"]))
        return OnlineBelief(
            self.names,
            self._tick * self.tick_s,
            belief["mean"].copy(),
            belief["cov"].copy(),
            float(belief["misfit"]),
            self._gated,
            left_out,
            int(belief["readings"]),
            bool(settled(moved, sd, belief["readings"] * self.tick_s)),
        )


def _numbers(name: str, value: ArrayLike, shape: tuple[int, ...]) -> Array:
    """``value`` as an array of real numbers of that shape."""
    try:
        array: Array = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError):
        raise InputError(f"{name} is {shown(value)}; allowed: numbers of shape {shape}, NaN where not read") from None
    if array.shape != shape:
        raise InputError(f"{name} has shape {array.shape}; allowed: {shape}")
    return array


@njit
def take_tick(jaw: Jaw, beliefs, rows, clock, measured, samples, settings: FilterSettings, scratch: FilterScratch):
    """One tick as in an environment; ``clock`` is its number and the ticks from one belief to the next."""
    tick, every = clock
    keep_reading(tick, measured, samples, settings.used, rows)
    left_out, refused = filter_tick(jaw, beliefs, rows, tick, measured, samples, settings, scratch)
    if tick > 0 and tick % every == 0:
        conclude(beliefs[0], settings, scratch.belief)
    return left_out, refused
