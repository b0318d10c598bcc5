"""The jaws, patients and motions of the items. The thesis names no geometry, noise or trajectory: these are ours.

Three degrees of freedom: the midline model held in the sagittal plane, where the condyle slides on the fossa and the
jaw turns. It is chosen over the ladder's ``JawSagittal-v3``, whose plant has contact and friction that no estimator
knows: the thesis tests its methods on data of the very model that they fit, and so do we. Fewer degrees of freedom
than the thesis counts are left, because the height of the condyle follows from the fossa in its model too.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

import numpy as np
from numpy.typing import NDArray

from eval.thesis.prescribed import SLIDE, PrescribedMotion, lead
from jawenv.anatomy import cohort
from jawenv.anatomy.muscles import MuscleSet, known_muscle_sets
from jawenv.device.device import Device
from jawenv.mechanics.building import ALL_FREE, build_jaw
from jawenv.recordings.record import Record

Array = NDArray[np.float64]
Keyframes = dict[str, tuple[Sequence[float], Sequence[float]]]

DEVICE = Device()
SENSORS = Device(unmodelled_force_N=0.0, unmodelled_moment_N_m=0.0)
"""The same without unmodelled forces: the thesis has noise of the measurement alone."""
TICK = 0.01
PLANE = (True, False, True, False, False)
REST = 3.0  # degrees of opening in which every motion begins and ends
THESIS_PLANE = ((0.25, 8.0), (0.25, 6.0), (0.4, 6.0))
"""F_o (N) and b of Fig. 6.4's three muscles; the second pair is printed the other way round, 6 and 0.25."""
PATIENT = 7  # seed of the patient of sections 7.1 and 7.3.2
STIFF, NORMAL = (3.0, 12.0), (0.4, 7.0)


def _logs(pairs: tuple[tuple[float, float], ...]) -> Array:
    """Log F_o and log b of each muscle in a row."""
    return np.log(np.array(pairs, dtype=np.float64)).ravel()


def opening(
    times: tuple[float, ...], degrees: tuple[float, ...], fore_aft_mm: tuple[float, ...] | None = None
) -> Keyframes:
    """Keyframes of an opening on which the condyle slides as in a healthy jaw, and off that by ``fore_aft_mm``."""
    theta = np.radians(degrees)
    off = np.zeros(len(times)) if fore_aft_mm is None else np.array(fore_aft_mm) / 1e3
    return {"theta": (times, tuple(theta)), "x": (times, tuple(SLIDE * theta + off))}


def _sideways(times: tuple[float, ...], yaw_deg: tuple[float, ...]) -> Keyframes:
    """Keyframes of swings to the side: yaw, and the condyles' midpoint 0.4 mm aside per degree."""
    yaw = np.radians(yaw_deg)
    return {"psi": (times, tuple(yaw)), "y": (times, tuple(0.4 * np.array(yaw_deg) / 1e3))}


@cache
def plane_record() -> Record:
    """Fig. 6.4: three muscles in the plane, opened twice, with the condyle led off its natural slide."""
    times = tuple(3.0 * k for k in range(11))
    degrees = (REST, 14, 25, 20, 8, REST, 10, 22, 25, 12, REST)
    motion = PrescribedMotion(opening(times, degrees, (0, 3, 1.5, -3, 2, 0, -2.5, 2.5, -3, 3, 0)))
    return _of_muscles(known_muscle_sets()["pairs"], _logs(THESIS_PLANE), motion, PLANE, "healthy")


@cache
def hinge_record() -> Record:
    """One muscle on a hinge, opened once."""
    motion = PrescribedMotion({"theta": ((0.0, 5.0, 10.0), tuple(np.radians((REST, 25.0, REST))))})
    free = (False, False, True, False, False)
    return _of_muscles(known_muscle_sets()["closers"], _logs(((0.9, 7.0),)), motion, free, "healthy")


@cache
def full_record() -> Record:
    """Six muscles, the left masseter stiff; opening, swings to the side, and the condyle led off its natural slide."""
    return _of_muscles(
        known_muscle_sets()["whole"], _logs((STIFF, *(NORMAL,) * 5)), _full_motion(20.0, True), ALL_FREE, "wide"
    )


@cache
def sampled_record(dt: float) -> Record:
    """The same motion of a patient of cohort ``trismus``, sampled every ``dt`` seconds."""
    truth = cohort("trismus").draw_log_parameters(np.random.default_rng(PATIENT))
    return _of_muscles(known_muscle_sets()["whole"], truth, _full_motion(20.0, True), ALL_FREE, "trismus", dt)


def _full_motion(degrees: float, to_the_side: bool) -> PrescribedMotion:
    """Up and down once, with three swings to each side at four degrees where asked for."""
    middle = 0.5 * (REST + degrees)
    keyframes = opening(
        (0.0, 4.0, 7.0, 10.0, 13.0, 16.0, 20.0),
        (REST, middle, degrees, degrees, degrees, middle, REST),
        (0.0, 0.8, 0.0, -0.8, 0.8, 0.0, 0.0),
    )
    if to_the_side:
        steps = tuple(np.linspace(0.0, 20.0, 9))
        keyframes |= _sideways(steps, (0.0, 4.0, -4.0, 4.0, -4.0, 4.0, -4.0, 0.0, 0.0))
    return PrescribedMotion(keyframes)


@cache
def maneuver_record(degrees: float, to_the_side: bool) -> Record:
    """Opening ``degrees`` beyond rest, with or without swings to the side; a patient of whom little is known.

    One patient of cohort ``trismus``, drawn once, and the prior of ``wide``, as there is no reliable guess.
    """
    motion = _full_motion(REST + degrees, to_the_side)
    truth = cohort("trismus").draw_log_parameters(np.random.default_rng(PATIENT))
    return _of_muscles(known_muscle_sets()["whole"], truth, motion, ALL_FREE, "wide")


@cache
def lowering_then_sideways() -> Record:
    """Fig. 6.1: the jaw is lowered, then led to the left, then closed."""
    times = (0.0, 4.0, 5.0, 8.0, 9.0, 12.0)
    keyframes = opening(times, (REST, 20, 20, 20, 20, REST)) | _sideways(times, (0, 0, 0, 5, 5, 0))
    truth = np.array(cohort("trismus").prior.mean)
    return _of_muscles(known_muscle_sets()["whole"], truth, PrescribedMotion(keyframes), ALL_FREE, "trismus")


def _of_muscles(
    muscles: MuscleSet, truth: Array, motion: PrescribedMotion, free: tuple[bool, ...], belief: str, dt: float = TICK
) -> Record:
    jaw = build_jaw(muscles, free=free)
    return lead(jaw, truth, muscles.parameter_names, cohort(belief, muscles).prior, motion, dt, DEVICE)
