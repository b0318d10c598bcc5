"""Target signals over time: what one channel of a maneuver asks for.

Each signal is a small validated model with a `value(t)` and its exact time derivative `rate(t)`, both for arrays of
any shape, t in seconds since the episode began, and with bounds of both that are computed, not sampled. Values are
dimensionless fractions; the maneuver says of what.
"""

from abc import ABC, abstractmethod
from functools import cached_property
from itertools import pairwise
from typing import Annotated, Literal

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field, model_validator
from scipy.interpolate import BPoly
from scipy.signal import max_len_seq

from jawenv.base.files import InputModel, Number
from jawenv.playing.agents import Array

LONGEST_S = 3600.0
"""For which time bounds hold, from the beginning of an episode, and the longest time that a file may name."""
SHORTEST_S = 1e-3
HIGHEST_HZ = 10.0
MOST_HARMONICS = 32
MOST_POINTS = 20_000

Seconds = Annotated[Number, Field(ge=SHORTEST_S, le=LONGEST_S)]
Hertz = Annotated[Number, Field(gt=0, le=HIGHEST_HZ)]
Bounds = tuple[float, float]

_PEAK_SPEED = 15.0 / 8.0  # of a minimum-jerk movement, over its mean speed


class Signal(InputModel, ABC):
    """A target over time."""

    @abstractmethod
    def value(self, t: ArrayLike) -> Array:
        """The target at times t (s), an array of t's shape."""

    @abstractmethod
    def rate(self, t: ArrayLike) -> Array:
        """The target's time derivative (1/s) at times t (s), an array of t's shape."""

    @abstractmethod
    def bounds(self) -> Bounds:
        """A lowest and a highest value that the target does not leave within `LONGEST_S`."""

    @abstractmethod
    def fastest(self) -> float:
        """The size of the rate (1/s), at most, within `LONGEST_S`."""


def _stairs(times: Array, values: Array, smooth: bool) -> BPoly:
    """Piecewise polynomial through the points, at rest at each of them if smooth.

    The smooth form is the quintic with zero speed and acceleration at both ends, which is the minimum-jerk movement
    between two points (Flash and Hogan 1985).
    """
    rest = [0.0, 0.0] if smooth else []
    return BPoly.from_derivatives(times, [[value, *rest] for value in values])


class KeyframePoint(InputModel):
    """One keyframe."""

    t_s: Annotated[Number, Field(ge=0, le=LONGEST_S)]
    value: Number


class Keyframes(Signal):
    """Points in time, joined by minimum-jerk movements (`smooth`) or straight lines (`linear`).

    Before the first point and after the last one their values hold; with `repeat` the points are played again and
    again, the last one at the time of the first.
    """

    kind: Literal["keyframes"]
    points: tuple[KeyframePoint, ...] = Field(min_length=1, max_length=MOST_POINTS)
    interpolation: Literal["smooth", "linear"] = "smooth"
    repeat: bool = False

    @model_validator(mode="after")
    def _ordered(self) -> "Keyframes":
        for earlier, later in pairwise(self.points):
            if later.t_s <= earlier.t_s:
                raise ValueError(f"points: t_s {later.t_s:g} follows {earlier.t_s:g}; allowed: times that increase")
            if later.t_s - earlier.t_s < 0.999 * SHORTEST_S:  # what decimals lose
                raise ValueError(
                    f"points: t_s {later.t_s:.15g} follows {earlier.t_s:.15g}; allowed: {SHORTEST_S:g} s later, or more"
                )
        if self.repeat and len(self.points) < 2:
            raise ValueError("repeat: there is one point; allowed: two or more")
        if self.repeat and self.points[0].value != self.points[-1].value:
            raise ValueError(
                f"repeat: the last value is {self.points[-1].value:g}; allowed: the first one, "
                f"{self.points[0].value:g}, as the target would jump"
            )
        return self

    @cached_property
    def _path(self) -> BPoly:
        times = np.array([point.t_s for point in self.points])
        values = np.array([point.value for point in self.points])
        if len(times) == 1:
            times, values = times + [0.0, 1.0], values.repeat(2)
        return _stairs(times, values, smooth=self.interpolation == "smooth")

    @cached_property
    def _slope(self) -> BPoly:
        return self._path.derivative()

    def _time(self, t: ArrayLike) -> Array:
        """The time on the path at time t."""
        first, last = float(self._path.x[0]), float(self._path.x[-1])
        seconds: Array = np.asarray(t, dtype=np.float64)
        if self.repeat:
            return np.where(seconds < first, first, first + np.mod(seconds - first, last - first))
        return seconds.clip(first, last)

    def value(self, t: ArrayLike) -> Array:
        """See `Signal.value`."""
        return np.asarray(self._path(self._time(t)))

    def rate(self, t: ArrayLike) -> Array:
        """See `Signal.rate`; zero where the first or last value holds."""
        t = np.asarray(t, dtype=float)
        moving = t >= self._path.x[0]
        if not self.repeat:
            moving &= t < self._path.x[-1]
        return np.where(moving, self._slope(self._time(t)), 0.0)

    def bounds(self) -> Bounds:
        """See `Signal.bounds`; between two points the target goes from one to the other without turning."""
        values = [point.value for point in self.points]
        return min(values), max(values)

    def fastest(self) -> float:
        """See `Signal.fastest`."""
        peak = _PEAK_SPEED if self.interpolation == "smooth" else 1.0
        pairs = pairwise(self.points)
        return max((peak * abs(b.value - a.value) / (b.t_s - a.t_s) for a, b in pairs), default=0.0)


class _Harmonic(InputModel):
    """One sine: amplitude sin(2 pi frequency t + phase). Say either its period or its frequency."""

    amplitude: Number
    period_s: Annotated[Number, Field(ge=1.0 / HIGHEST_HZ)] | None = None
    frequency_hz: Hertz | None = None
    phase_deg: Number = 0.0

    @model_validator(mode="after")
    def _one_of_two(self) -> "_Harmonic":
        if (self.period_s is None) == (self.frequency_hz is None):
            raise ValueError("give exactly one of period_s and frequency_hz")
        return self

    @property
    def angular_frequency(self) -> float:
        """Angular frequency, rad/s."""
        frequency = self.frequency_hz if self.frequency_hz is not None else 1.0 / (self.period_s or np.nan)
        return 2.0 * np.pi * frequency


class Harmonics(Signal):
    """An offset and a sum of sines: a swing, or a multisine.

    The phases that keep the peak of a multisine of K equal sines low are phase_k = -180 k (k - 1) / K degrees
    (Schroeder 1970, IEEE Trans. Inf. Theory 16:85).
    """

    kind: Literal["harmonics"]
    harmonics: tuple[_Harmonic, ...] = Field(min_length=1, max_length=MOST_HARMONICS)
    offset: Number = 0.0

    @cached_property
    def _table(self) -> tuple[Array, Array, Array]:
        """Amplitude, angular frequency and phase (rad), each (K,)."""
        rows = [(h.amplitude, h.angular_frequency, np.deg2rad(h.phase_deg)) for h in self.harmonics]
        amplitude, omega, phase = np.array(rows).T
        return amplitude, omega, phase

    def value(self, t: ArrayLike) -> Array:
        """See `Signal.value`."""
        amplitude, omega, phase = self._table
        return self.offset + np.sin(np.multiply.outer(t, omega) + phase) @ amplitude

    def rate(self, t: ArrayLike) -> Array:
        """See `Signal.rate`."""
        amplitude, omega, phase = self._table
        return np.cos(np.multiply.outer(t, omega) + phase) @ (amplitude * omega)

    def bounds(self) -> Bounds:
        """See `Signal.bounds`; exact to a millionth of the sum of the amplitudes."""
        low, high = _sampled_bounds(*self._table)
        return self.offset + low, self.offset + high

    def fastest(self) -> float:
        """See `Signal.fastest`; exact to a millionth of the sum of the sines' rates."""
        amplitude, omega, phase = self._table
        low, high = _sampled_bounds(amplitude * omega, omega, phase + 0.5 * np.pi)
        return max(-low, high)


class Chirp(Signal):
    """A sine whose frequency rises linearly `from_hz` `to_hz` in `duration_s`, then falls back as it rose, and so on.

    Value and rate stay continuous where the sweep turns.
    """

    kind: Literal["chirp"]
    amplitude: Number
    from_hz: Hertz
    to_hz: Hertz
    duration_s: Seconds
    offset: Number = 0.0

    def _phase(self, t: ArrayLike) -> tuple[Array, Array]:
        """Phase (rad) and its rate (rad/s)."""
        span = self.duration_s
        slope = (self.to_hz - self.from_hz) / span

        def cycles(s: Array) -> Array:
            return s * (self.from_hz + 0.5 * slope * s)

        sweeps, s = np.divmod(np.asarray(t, dtype=float), span)
        falling = np.mod(sweeps, 2.0) == 1.0
        whole = cycles(np.array(span))
        turned = np.where(falling, whole - cycles(span - s), cycles(s))
        frequency = self.from_hz + slope * np.where(falling, span - s, s)
        return 2.0 * np.pi * (sweeps * whole + turned), 2.0 * np.pi * frequency

    def value(self, t: ArrayLike) -> Array:
        """See `Signal.value`."""
        phase, _ = self._phase(t)
        return self.offset + self.amplitude * np.sin(phase)

    def rate(self, t: ArrayLike) -> Array:
        """See `Signal.rate`."""
        phase, omega = self._phase(t)
        return self.amplitude * omega * np.cos(phase)

    def bounds(self) -> Bounds:
        """See `Signal.bounds`; the sweeps go on until the sine has had its peaks."""
        return self.offset - abs(self.amplitude), self.offset + abs(self.amplitude)

    def fastest(self) -> float:
        """See `Signal.fastest`; the rate of a sine of the highest frequency."""
        return abs(self.amplitude) * 2.0 * np.pi * max(self.from_hz, self.to_hz)


class Prbs(Signal):
    """Pseudo-random binary sequence: offset plus or minus the amplitude, a maximum-length shift register's choice.

    Every `interval_s` the register decides anew. A change of sign is a minimum-jerk movement of `switch_s`, since a
    jaw cannot jump. The sequence repeats after (2^register_bits - 1) intervals.
    """

    kind: Literal["prbs"]
    amplitude: Number
    interval_s: Seconds
    switch_s: Seconds
    register_bits: Annotated[int, Field(ge=2, le=12)]
    seed: Annotated[int, Field(ge=1)] = 1
    offset: Number = 0.0

    @model_validator(mode="after")
    def _consistent(self) -> "Prbs":
        if self.seed >= 2**self.register_bits:
            raise ValueError(f"seed is {self.seed}; allowed: below 2^register_bits = {2**self.register_bits}")
        if self.switch_s > self.interval_s:
            raise ValueError(f"switch_s is {self.switch_s:g}; allowed: up to interval_s, {self.interval_s:g}")
        return self

    @cached_property
    def _path(self) -> BPoly:
        bits = self.register_bits
        register = [(self.seed >> k) & 1 for k in range(bits)]
        sequence, _ = max_len_seq(bits, state=register)
        level = self.offset + self.amplitude * (2.0 * sequence - 1.0)
        start = self.interval_s * np.arange(len(level) + 1, dtype=np.float64)
        if self.switch_s == self.interval_s:
            return _stairs(start, np.append(level[-1], level), smooth=True)
        times = np.column_stack([start, start + self.switch_s]).ravel()[:-1]
        values = np.append(level[-1], np.repeat(level, 2))
        return _stairs(times, values, smooth=True)

    @cached_property
    def _slope(self) -> BPoly:
        return self._path.derivative()

    def value(self, t: ArrayLike) -> Array:
        """See `Signal.value`."""
        return np.asarray(self._path(np.mod(t, self._path.x[-1])))

    def rate(self, t: ArrayLike) -> Array:
        """See `Signal.rate`."""
        return np.asarray(self._slope(np.mod(t, self._path.x[-1])))

    def bounds(self) -> Bounds:
        """See `Signal.bounds`; the register has both levels."""
        return self.offset - abs(self.amplitude), self.offset + abs(self.amplitude)

    def fastest(self) -> float:
        """See `Signal.fastest`."""
        return _PEAK_SPEED * 2.0 * abs(self.amplitude) / self.switch_s


def _sampled_bounds(amplitude: Array, omega: Array, phase: Array) -> Bounds:
    """Bounds of a sum of sines within `LONGEST_S`, about 1 % of the quickest one too narrow at most."""
    size = float(np.abs(amplitude).sum())
    if len(amplitude) == 1 or not 0.0 < size < np.inf:
        return -size, size
    moments = min(100_000, int(16.0 * LONGEST_S * max(1.0 / 60.0, float(omega.max()) / (2.0 * np.pi))))
    t: Array = np.linspace(0.0, LONGEST_S, moments)
    total: Array = np.zeros(moments)
    for a, w, p in zip(amplitude, omega, phase, strict=True):
        total += a * np.sin(w * t + p)
    return -_peak(-total), _peak(total)


def _peak(values: Array) -> float:
    """Peak of a parabola through the greatest of the values and its neighbours."""
    k = int(np.clip(values.argmax(), 1, len(values) - 2))
    before, at, after = values[k - 1 : k + 2].tolist()
    bend = before - 2.0 * at + after
    return float(max(values.max(), at - (before - after) ** 2 / (8.0 * bend)) if bend < 0.0 else values.max())


AnySignal = Annotated[Keyframes | Harmonics | Chirp | Prbs, Field(discriminator="kind")]
