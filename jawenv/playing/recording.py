"""The recording of played episodes: arrays over worlds, times and parameters."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from jawenv.base.errors import InputError, shown

if TYPE_CHECKING:
    from jawenv.recordings.record import Record

Array = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]

# N worlds, T + 1 times (the reset is time 0), P parameters, L comfort limits.
_SHAPES: dict[str, tuple[str, ...]] = {
    "time": ("T",),
    "belief_mean": ("N", "T", "P"),
    "belief_cov": ("N", "T", "P", "P"),
    "truth": ("N", "P"),
    "prior_mean": ("P",),
    "prior_sd": ("P",),
    "bound_sd": ("N", "T", "P"),
    "information_claimed": ("N", "T"),
    "information_true": ("N", "T"),
    "information_bound": ("N", "T"),
    "cost": ("N", "T"),
    "comfort": ("N", "T", "L"),
    "governor": ("N", "T"),
    "violation": ("N", "T"),
    "misfit": ("N", "T"),
    "settled": ("N", "T"),
    "valid": ("N", "T"),
    "terminated": ("N",),
    "asked": ("N", "P"),
}
_MAY_BE_NAN = {"bound_sd", "information_bound", "misfit"}


@dataclass(frozen=True)
class Recording:
    """N episodes of one agent, as arrays over worlds (N), times (T + 1) and parameters (P).

    Parameters are natural logs. After a world has ended (`valid` False) its arrays hold their last value, and
    its cost and governor share are 0.
    """

    time: Array  # (T+1,) s since the start of the episode; time 0 is the reset
    belief_mean: Array  # (N, T+1, P) the filter's mean
    belief_cov: Array  # (N, T+1, P, P) the filter's covariance
    truth: Array  # (N, P) the patient's parameters
    prior_mean: Array  # (P,) mean of the filter's prior
    prior_sd: Array  # (P,) standard deviation of the filter's prior
    bound_sd: Array  # (N, T+1, P) posterior Cramer-Rao bound, NaN where it was not tracked
    information_claimed: Array  # (N, T+1) nats, as the environment reports them
    information_true: Array  # (N, T+1) nats by the log score, as the environment reports them
    information_bound: Array  # (N, T+1) nats, NaN where it was not tracked
    cost: Array  # (N, T+1) discomfort in the step that ends at that time, >= 0
    comfort: Array  # (N, T+1, L) used fraction of each soft limit
    governor: Array  # (N, T+1) share of the device ticks of that step in which the governor acted
    violation: Mask  # (N, T+1) bool, a hard limit was crossed in that step
    misfit: Array  # (N, T+1) the filter's alarm, judged anew where readings are filtered again; it rings above 1
    settled: Mask  # (N, T+1) bool, the belief may be acted on, see `info["settled"]`
    valid: Mask  # (N, T+1) bool, False after the episode has ended
    terminated: Mask  # (N,) bool, the episode ended before its time limit
    asked: Mask  # (N, P) bool, the parameters of the muscles that are asked for: all by default
    parameter_names: tuple[str, ...]  # P names, `log_F_o/<muscle>` and `log_b/<muscle>`
    comfort_names: tuple[str, ...]  # L names of the comfort limits
    records: tuple[Record, ...] | None = None
    """N records of what the devices measured, with `record=True` among the environment's arguments."""

    def __post_init__(self) -> None:
        """Check every array against the sizes that `truth`, `time` and the names state."""
        if np.ndim(self.truth) != 2 or np.ndim(self.time) != 1:
            raise InputError(
                f"recording: truth has shape {np.shape(self.truth)} and time {np.shape(self.time)}; "
                "allowed: (N, P) and (T+1,)"
            )
        sizes = {
            "N": len(self.truth),
            "T": len(self.time),
            "P": len(self.parameter_names),
            "L": len(self.comfort_names),
        }
        for field, axes in _SHAPES.items():
            value = getattr(self, field)
            allowed = tuple(sizes[axis] for axis in axes)
            if np.shape(value) != allowed:
                raise InputError(f"recording: {field} has shape {np.shape(value)}; allowed: {allowed}")
            if field not in _MAY_BE_NAN and not np.isfinite(value).all():
                raise InputError(f"recording: {field} holds a value that is not finite; allowed: finite numbers")
        if (np.diff(self.time) <= 0.0).any() or len(self.time) < 2:
            raise InputError(f"recording: time is {shown(self.time.tolist())}; allowed: two or more values that grow")
        if not self.valid[:, 0].all() or (self.valid[:, 1:] > self.valid[:, :-1]).any():
            raise InputError(
                "recording: valid is True after False; allowed: True at first, then at most one change to False"
            )

    @property
    def num_worlds(self) -> int:
        """N, the number of episodes."""
        return len(self.truth)

    @property
    def counts(self) -> Mask:
        """(N, T+1) when a belief counts where the question is whether something is known: settled, and not ended."""
        return self.settled & self.valid

    @property
    def last(self) -> npt.NDArray[np.intp]:
        """(N,) index of the last valid time of each world."""
        index: npt.NDArray[np.intp] = self.valid.sum(axis=1) - 1
        return index

    @property
    def belief_sd(self) -> Array:
        """(N, T+1, P) standard deviations that the filter claims (natural log: 0.05 is 5 %)."""
        return np.sqrt(np.diagonal(self.belief_cov, axis1=-2, axis2=-1))

    def of_asked(self, values: Array) -> Array:
        """Values (N, ..., P) of the parameters, none below 0, with 0 for parameters outside the question."""
        shape = (self.num_worlds, *(1,) * (np.ndim(values) - 2), values.shape[-1])
        return values * self.asked.reshape(shape)

    def at_end(self, values: npt.NDArray[Any]) -> npt.NDArray[Any]:
        """Pick each world's value at its last valid time.

        Args:
            values: (N, T+1, ...).

        Returns:
            (N, ...).
        """
        picked: npt.NDArray[Any] = values[np.arange(self.num_worlds), self.last]
        return picked
