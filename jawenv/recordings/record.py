"""The device's readings of one episode, tick by tick: the input of every estimator."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from jawenv.anatomy import Prior
from jawenv.anatomy.knowledge import Knowledge
from jawenv.base.errors import InputError
from jawenv.controls import CONTROLS, Control
from jawenv.device.device import Device
from jawenv.device.force_sensor import FORCE_SENSORS, ForceSensor
from jawenv.filter.model.encoders import N_MEASUREMENTS
from jawenv.filter.model.motion_step import N_SAMPLES
from jawenv.mechanics.dynamics import N_STATES, N_WRENCH

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Record:
    """One episode as the device saw it, T ticks long, and what it knew before; SI units, p parameters, n states.

    Tick k leads from ``time[k]`` to ``time[k + 1]``. A value that was not read is NaN.
    """

    time: Array  # (T + 1,) s; even spacing
    measured: Array
    """(T + 1, 12) encoders at those times: mouthpiece position (m, head axes), Euler angles theta, psi, alpha (rad),
    mouthpiece velocity (m/s), angular velocity (rad/s, body axes).
    """
    samples: Array
    """(T, 3, 6) load cell at start, middle and end of each tick: force (N) and moment (N m) of the device on the
    mouthpiece, body axes; of the parabola that fits the tick best (``load_cell``).
    """
    start_mean: Array  # (n,) believed motion (q, u) before the first measurement
    start_sd: Array  # (n,) its sd; 0 for a coordinate that cannot move
    measurement_sd: Array  # (12,) noise of the encoders
    wrench_sd: Array
    """(6,) sd of the wrench not known, constant over a tick and new in each: what no model explains, and the noise
    of the mean of a tick's load-cell samples. Of a disturbance with memory the latter alone.
    """
    cell_sd: Array  # (6,) sd of the latter alone
    gain_sd: float  # sd of the load cell's relative gain error, one value for the record
    jaw: Any  # geometry and mass as the estimator believes them, a record of dtype ``jaw_dtype``
    prior: Prior  # belief about the parameters before the record
    parameter_names: tuple[str, ...]  # p names
    knowledge: Knowledge = Knowledge()  # within which sds geometry, mass, mounting and load cell are known
    disturbance_time_s: float = 0.0  # time constant of the memory of the unmodelled wrench; 0 for none
    disturbance_sd: Array = field(default_factory=lambda: np.zeros(N_WRENCH))  # (6,) its sd where it has memory
    force_sensor: ForceSensor = "cell"  # how the device knows its force: what ``samples`` are of
    device: Device | None = None
    """The device, None if unknown; read only where no load cell reads the force, for its sds."""
    control: Control = "force"  # of its motors, "force", "trajectory" or "targets"; no estimator reads it
    truth: Array | None = None  # (p,) the patient's natural-log parameters; None if unknown. For evaluation only
    states: Array | None = None  # (T + 1, n) true motion; None if unknown. For evaluation only
    wrenches: Array | None = None  # (T, 3, 6) what ``samples`` would be without the load cell's errors; likewise

    def __post_init__(self) -> None:
        """Check shapes, spacing and signs."""
        ticks, parameters = len(self.time) - 1, len(self.parameter_names)
        shapes = {
            "measured": (ticks + 1, N_MEASUREMENTS),
            "samples": (ticks, N_SAMPLES, N_WRENCH),
            "start_mean": (N_STATES,),
            "start_sd": (N_STATES,),
            "measurement_sd": (N_MEASUREMENTS,),
            "wrench_sd": (N_WRENCH,),
            "cell_sd": (N_WRENCH,),
            "disturbance_sd": (N_WRENCH,),
            "truth": (parameters,),
            "states": (ticks + 1, N_STATES),
            "wrenches": (ticks, N_SAMPLES, N_WRENCH),
        }
        for name, shape in shapes.items():
            value = getattr(self, name)
            if value is not None and np.shape(value) != shape:
                raise InputError(f"record: {name} has shape {np.shape(value)}; allowed: {shape}")
        if self.control not in CONTROLS:
            raise InputError(f"record: control is {self.control!r}; allowed: {', '.join(CONTROLS)}")
        steps = np.diff(self.time)
        if ticks < 1 or not (steps > 0.0).all() or np.ptp(steps) > 1e-6 * steps.mean():
            raise InputError("record: time is uneven; allowed: two or more values, finite, growing and evenly spaced")
        for name in ("measurement_sd", "wrench_sd"):
            if not (getattr(self, name) > 0.0).all():
                raise InputError(f"record: {name} is {getattr(self, name)}; allowed: numbers above 0")
        if not ((self.cell_sd >= 0.0) & (self.cell_sd <= self.wrench_sd)).all():
            raise InputError(f"record: cell_sd is {self.cell_sd}; allowed: numbers from 0 to wrench_sd")
        if not (0.0 <= self.disturbance_time_s < np.inf and (self.disturbance_sd >= 0.0).all()):
            raise InputError(
                f"record: disturbance_time_s is {self.disturbance_time_s}, disturbance_sd {self.disturbance_sd}; "
                "allowed: numbers from 0 on"
            )
        self._check_force_sensor()

    def _check_force_sensor(self) -> None:
        """A force without a load cell needs the device's sds."""
        if self.force_sensor not in FORCE_SENSORS:
            raise InputError(f"record: force_sensor is {self.force_sensor!r}; allowed: {', '.join(FORCE_SENSORS)}")
        if self.force_sensor != "cell" and self.device is None:
            raise InputError(f"record: force_sensor is {self.force_sensor!r}, allowed without a device is 'cell'")

    @property
    def dt(self) -> float:
        """Length of a tick, s."""
        return float(self.time[-1] - self.time[0]) / (len(self.time) - 1)

    @property
    def exact(self) -> bool:
        """Whether a load cell reads the force at all times, all else is known exactly, no disturbance has memory."""
        known = self.knowledge.exact and self.disturbance_time_s == 0.0 and self.force_sensor == "cell"
        return known and bool(np.isfinite(self.samples).all())

    def require_exact(self, method: str) -> None:
        """Check that ``method`` can be used, which integrates nothing out but the load cell's gain error."""
        if not self.exact:
            has = (
                (not self.knowledge.exact, "knowledge that is not exact"),
                (self.force_sensor != "cell", "a force that no load cell reads"),
                (self.disturbance_time_s > 0.0, "a disturbance with memory"),
                (True, "times without a reading of the load cell"),
            )
            extra = next(what for there, what in has if there)
            raise InputError(f"{method}: the record has {extra}; allowed: none, or TensionFilter and OnlineFilter")

    @property
    def noise_variance(self) -> Array:
        """(12,) variance of the wrench not known, as ``joint_step`` has it: constant over a tick, and tilting."""
        return np.concatenate([self.wrench_sd**2, self.cell_sd**2])

    def until(self, seconds: float) -> Record:
        """The record of its first ``seconds``."""
        ticks = round(seconds / self.dt)
        if not 1 <= ticks < len(self.time):
            raise InputError(f"until is {seconds} s; allowed: {self.dt:g} to {self.time[-1]:g} s")
        return replace(
            self,
            time=self.time[: ticks + 1],
            measured=self.measured[: ticks + 1],
            samples=self.samples[:ticks],
            states=None if self.states is None else self.states[: ticks + 1],
            wrenches=None if self.wrenches is None else self.wrenches[:ticks],
        )
