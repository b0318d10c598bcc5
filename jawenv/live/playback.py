"""A recording, moment by moment: the jaw as the encoders felt it, and what the filter learned."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from jawenv.live.outcome import KNOWN, DriveOutcome
from jawenv.live.session import Shown
from jawenv.mechanics.forces import muscle_pull
from jawenv.mechanics.kinematics import rotation
from jawenv.metrics.precision import time_to
from jawenv.metrics.standing import standing
from jawenv.playing.agents import Array
from jawenv.recordings.record import Record
from jawenv.recordings.record_filter import TensionFilter
from jawenv.rendering.scene import Scene

FRAMES_PER_S = 20.0


class Playback:
    """The moments of a recording, ``FRAMES_PER_S`` a second; the filter runs over all of it first.

    Tensions are those of the believed muscles, since a recording of a device knows no others.

    Args:
        record: what a device has measured.
        name: of the recording.
    """

    def __init__(self, record: Record, name: str) -> None:
        self._record, self._name = record, name
        self._every = max(1, round(1.0 / (record.dt * FRAMES_PER_S)))
        self._estimate = TensionFilter(every=self._every).estimate(record)
        self._measured = _filled(record.measured)
        self._forces = _filled(record.samples[:, -1, :3])

    def __len__(self) -> int:
        """Number of moments."""
        return len(self._estimate.time)

    @property
    def period_s(self) -> float:
        """Time from one moment to the next, s."""
        return self._every * self._record.dt

    def shown(self, index: int) -> Shown:
        """Moment ``index``, 0 to ``len(self) - 1``."""
        estimate, time = self._estimate, float(self._estimate.time[index])
        sds = estimate.sd[: index + 1]
        ten, five = (float(time_to(sds[None], estimate.time[: index + 1], threshold)[0]) for threshold in KNOWN)
        reached = DriveOutcome(self._name, (ten, five), float(sds[-1].max()), 0.0, time, False)
        last = index == len(self) - 1
        why = "the recording is over" if last else ""
        return Shown(self._scene(index), np.zeros(4), self._name, reached, 0.0, self._stands(index), (), last, why)

    def _stands(self, index: int) -> NDArray[np.bool_]:
        return standing(self._estimate.mean[index], self._estimate.cov[index], self._record.prior.sd)

    def _scene(self, index: int) -> Scene:
        record, tick = self._record, index * self._every
        jaw, mean, cov = record.jaw, self._estimate.mean[index], self._estimate.cov[index]
        position, angles = self._measured[tick, :3], self._measured[tick, 3:6]
        turn = rotation((0.0, 0.0, *angles.tolist()))
        body_to_head = np.array(turn)
        contact = position - body_to_head @ jaw["mouthpiece"]
        muscles = np.exp(mean.reshape(-1, 2))[jaw["muscle"]]
        tensions = [muscle_pull(jaw, muscles, i, tuple(contact), turn)[3] for i in range(len(muscles))]
        rest = self._measured[0, :3]
        return Scene(
            muscle_names=tuple(_muscles(record)[i] for i in jaw["muscle"]),
            muscle_origin_m=jaw["origin"].copy(),
            muscle_insertion_m=contact + jaw["insertion"] @ body_to_head.T,
            muscle_tension_N=np.array(tensions),
            contact_m=contact,
            rotation=body_to_head,
            plant="midline",
            slides=bool(record.start_sd[0] > 0.0),
            condyle_half_width_m=float(jaw["condyle_half_width"]),
            fossa_drop_m=float(jaw["fossa_drop"]),
            fossa_frequency=float(jaw["fossa_frequency"]),
            mouthpiece_m=position,
            mouthpiece_force_N=body_to_head @ self._forces[max(tick - 1, 0)],
            parameter_names=record.parameter_names,
            belief_mean=mean,
            belief_cov=cov,
            prior_mean=np.asarray(record.prior.mean),
            prior_sd=np.asarray(record.prior.sd),
            truth=record.truth,
            time_s=float(self._estimate.time[index]),
            episode_s=float(record.time[-1]),
            opening_mm=1e3 * float(jaw["mouthpiece"][2] - position[2]),
            opening_limits_mm=np.array([40.0, 50.0]),
            excursion_mm=1e3 * np.array([position[1] - rest[1], 0.0]),
            excursion_soft_mm=np.array([10.0, 10.0]),
            information_nats=float(np.log(record.prior.sd).sum() - 0.5 * np.linalg.slogdet(cov)[1]),
            title=self._name,
        )


def _muscles(record: Record) -> tuple[str, ...]:
    """Names of the muscles in the order of their parameters."""
    return tuple(dict.fromkeys(name.partition("/")[2] for name in record.parameter_names))


def _filled(values: Array) -> Array:
    """Values (T, K) where what was not read is as it was before; 0 before the first reading."""
    filled = values.copy()
    for row in range(len(filled)):
        missing = ~np.isfinite(filled[row])
        filled[row, missing] = filled[row - 1, missing] if row else 0.0
    return filled
