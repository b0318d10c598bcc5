"""One step of the filter's model on two condyles, as ``motion_step`` has it for one point."""

from __future__ import annotations

from jawenv.filter.model.joint_step import between_samples, stage_share, step_parts
from jawenv.filter.model.motion_step import Step, append_part, set_part
from jawenv.kernels.compiled import njit_within
from jawenv.kernels.runge_kutta import runge_kutta_step, set_state
from jawenv.mechanics.bilateral import bilateral_rate
from jawenv.mechanics.dynamics import linearised_rate
from jawenv.mechanics.jaw import Jaw
from jawenv.mechanics.kinematics import split_body


@njit_within
def body_rate(q, u, stage, h, arguments):
    """(q', u') of the jaw with two condyles; half way through each part also the Jacobian, into ``scratch``."""
    jaw, samples, part, parts, derive, scratch = arguments
    sample = between_samples(samples, stage_share(part, stage, parts))
    if stage != 2 or not derive:
        return bilateral_rate(jaw, scratch.muscles, q, u, sample)
    return linearised_rate(jaw, scratch.muscles, q, u, sample, scratch.linear)


@njit_within
def body_step(jaw: Jaw, motion, samples, dt, derive, scratch: Step):
    """Move ``motion`` (12) of the jaw with two condyles through a step; ``derive``: its derivative, into ``total``.

    On the stiff discs the Jacobian changes within a step: it is frozen half way through each part.
    """
    parts = step_parts(jaw, scratch.muscles, motion, dt, scratch.linear)
    h = dt / parts
    for part in range(parts):
        q, u = split_body(motion)
        q, u = runge_kutta_step(body_rate, q, u, h, (jaw, samples, part, parts, derive, scratch))
        set_state(motion, q, u)
        if derive:
            set_part(h, scratch)
            append_part(part == 0, scratch)
