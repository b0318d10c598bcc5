"""Target signals over time: what one channel of a maneuver asks for.

Each signal is a small validated model with a `value(t)` and its exact time derivative `rate(t)`, both for arrays of
any shape, t in seconds since the episode began. Values are dimensionless fractions; the maneuver says of what.
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

from jawenv.files import InputModel, Number
from jawenv.playing.protocol import Array

Positive = Annotated[Number, Field(gt=0)]


class Signal(InputModel, ABC):
    """A target over time."""

    @abstractmethod
    def value(self, t: ArrayLike) -> Array:
        """The target at times t (s), an array of t's shape."""

    @abstractmethod
    def rate(self, t: ArrayLike) -> Array:
        """The target's time derivative (1/s) at times t (s), an array of t's shape."""

    def bounds(self, duration_s: float = 120.0) -> tuple[float, float]:
        """Lowest and highest value within `duration_s`, sampled 100 times a second."""
        values = self.value(np.arange(0.0, duration_s, 0.01))
        return float(values.min()), float(values.max())


def _stairs(times: Array, values: Array, smooth: bool) -> BPoly:
    """Piecewise polynomial through the points, at rest at each of them if smooth.

    The smooth form is the quintic with zero speed and acceleration at both ends, which is the minimum-jerk movement
    between two points (Flash and Hogan 1985).
    """
    rest = [0.0, 0.0] if smooth else []
    return BPoly.from_derivatives(times, [[value, *rest] for value in values])


class KeyframePoint(InputModel):
    """One keyframe."""

    t_s: Annotated[Number, Field(ge=0)]
    value: Number


class Keyframes(Signal):
    """Points in time, joined by minimum-jerk movements (`smooth`) or straight lines (`linear`).

    Before the first point and after the last one their values hold; with `repeat` the points are played again and
    again, the last one at the time of the first.
    """

    kind: Literal["keyframes"]
    points: tuple[KeyframePoint, ...] = Field(min_length=1)
    interpolation: Literal["smooth", "linear"] = "smooth"
    repeat: bool = False

    @model_validator(mode="after")
    def _ordered(self) -> "Keyframes":
        for earlier, later in pairwise(self.points):
            if later.t_s <= earlier.t_s:
                raise ValueError(f"points: t_s {later.t_s:g} follows {earlier.t_s:g}, times must increase")
        if self.repeat and len(self.points) < 2:
            raise ValueError("repeat: needs at least two points")
        if self.repeat and self.points[0].value != self.points[-1].value:
            raise ValueError(
                f"repeat: the last value {self.points[-1].value:g} must equal the first "
                f"{self.points[0].value:g}, or the target would jump"
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


class Harmonic(InputModel):
    """One sine: amplitude sin(2 pi frequency t + phase). Say either its period or its frequency."""

    amplitude: Number
    period_s: Positive | None = None
    frequency_hz: Positive | None = None
    phase_deg: Number = 0.0

    @model_validator(mode="after")
    def _one_of_two(self) -> "Harmonic":
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
    harmonics: tuple[Harmonic, ...] = Field(min_length=1)
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


class Chirp(Signal):
    """A sine whose frequency rises linearly `from_hz` `to_hz` in `duration_s`, then falls back as it rose, and so on.

    Value and rate stay continuous where the sweep turns.
    """

    kind: Literal["chirp"]
    amplitude: Number
    from_hz: Positive
    to_hz: Positive
    duration_s: Positive
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


class Prbs(Signal):
    """Pseudo-random binary sequence: offset plus or minus the amplitude, a maximum-length shift register's choice.

    Every `interval_s` the register decides anew. A change of sign is a minimum-jerk movement of `switch_s`, since a
    jaw cannot jump. The sequence repeats after (2^register_bits - 1) intervals.
    """

    kind: Literal["prbs"]
    amplitude: Number
    interval_s: Positive
    switch_s: Positive
    register_bits: Annotated[int, Field(ge=2, le=12)]
    seed: Annotated[int, Field(ge=1)] = 1
    offset: Number = 0.0

    @model_validator(mode="after")
    def _consistent(self) -> "Prbs":
        if self.seed >= 2**self.register_bits:
            raise ValueError(f"seed {self.seed} must be below 2^register_bits = {2**self.register_bits}")
        if self.switch_s > self.interval_s:
            raise ValueError(f"switch_s {self.switch_s:g} must not exceed interval_s {self.interval_s:g}")
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


AnySignal = Annotated[Keyframes | Harmonics | Chirp | Prbs, Field(discriminator="kind")]
