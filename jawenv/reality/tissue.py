"""Muscle tissue that creeps, and that is excited when it is stretched: the tension of each line for the coming tick.

Creep. The lengthening c xi l_o of a line, c the creep's share, is taken off its length:

    T = F_o exp(b (l / l_o - 1 - c xi)),    creep_time xi' = max(0, l - l_rest) / l_o - xi.

So log T relaxes as the stress of a standard linear solid does: after a stretch by the strain e above rest it rises by
b e and falls with the creep's time constant to b e (1 - c). For small c xi the tension is T (1 - b c xi). It is
also F_o that is multiplied by exp(-b c xi), the form in which the kernels of the mechanics take it. A second element
with a share and a time of its own lengthens beside it.

A law of another shape. A share s of the tension is that of a straight line in the length, through F_o and the law's own
tension at the strain 0.2; the line's tension ends at 0.

Reflex. The passive tension's rate while it rises, delayed by the latency, excites an active tension A that leaks away
with the lag of muscle:

    A' = gain max(0, T')(t - latency) - A / lag.

A stretch that is quick against the lag adds A = gain times the passive rise of tension, a steady one gain lag T', and
a held one nothing. Guarding is the active tension that stays: beyond its onset A goes, with the same lag, to
guarding_gain F_o b times the strain above rest less the onset. A swallow adds half a sine wave to all muscles.

All are held for a tick at their value at its start. Where a line is excited, or its law is another, its F_o and b of
the tick are those of the law that has the tension T + A and the slope of T at the length at the start of the tick: the
active tension neither stiffens the muscle nor follows its length. Sampling and holding delay by one tick in the mean;
what the latency exceeds it by is taken from the delay line.
"""

from __future__ import annotations

from math import exp, pi, sin

from jawenv.kernels.compiled import njit
from jawenv.kernels.vec3 import add, apply, cross, dot, row3
from jawenv.mechanics.forces import muscle_pull
from jawenv.mechanics.jaw import Jaw
from jawenv.mechanics.kinematics import contact_point, fossa, rotation
from jawenv.reality.options import RealityRecord
from jawenv.reality.state import RealityState

SWALLOW_TIME = 1.0  # s
LEAST_TENSION, STEEPEST = 1e-6, 50.0  # N, and the b of a tick of a muscle that has less: a straight law ends at 0
STRAIGHT_TO = 0.2  # strain at which a straight law has the tension of the exponential one


@njit
def update_tissue(reality: RealityRecord, state: RealityState, jaw: Jaw, muscles, motion, dt, effective):
    """(F_o, b) of each line for the coming ``dt`` seconds, into ``effective`` (lines, 2); advances ``state`` by dt.

    Args:
        reality: Record of dtype ``REALITY``.
        state: Record of dtype ``reality_state_dtype``; changed.
        jaw: The truth's record.
        muscles: (lines, 2) F_o and b of the truth.
        motion: (q, u, lift) at the start of the tick: coordinates (x, y, theta, psi, alpha), speeds (x', y', omega),
            and how far the condyles' midpoint is above its path (m) with its rate (m/s): zero in the midline plant.
        dt: Length of a tick (s).
        effective: (lines, 2); written. Equal to ``muscles`` to the bit where no effect of this module acts.
    """
    q, u, lift = motion
    for i in range(muscles.shape[0]):
        effective[i, 0], effective[i, 1] = muscles[i, 0], muscles[i, 1]
    creeps = reality.creep_share > 0.0 or reality.creep_slow_share > 0.0
    reacts = reality.reflex_gain > 0.0 or reality.guarding_gain > 0.0
    if not (creeps or reacts or reality.swallow_force > 0.0 or reality.straight_share > 0.0):
        return
    keep, keep_slow = 1.0 - exp(-dt / reality.creep_time), 1.0 - exp(-dt / reality.creep_slow_time)
    swallowed = swallow(reality, state, dt)
    body_to_head = rotation(q)
    contact = add(contact_point(jaw, q), (0.0, 0.0, lift[0]))
    _, slope, _, _ = fossa(jaw, q[0])
    velocity = (u[0], u[1], slope * u[0] + lift[1])
    omega = (u[2], u[3], u[4])
    for i in range(muscles.shape[0]):
        F_o, b, lengthened = muscles[i, 0], muscles[i, 1], 0.0
        if creeps:
            lengthened = reality.creep_share * state.creep[i] + reality.creep_slow_share * state.slow_creep[i]
            effective[i, 0] = F_o * exp(-b * lengthened)
        _, direction, length, tension = muscle_pull(jaw, effective, i, contact, body_to_head)
        stretch = max(0.0, length - state.rest_length[i]) / jaw.l_o[i]
        state.creep[i] += keep * (stretch - state.creep[i])
        state.slow_creep[i] += keep_slow * (stretch - state.slow_creep[i])
        strain, steepness = length / jaw.l_o[i] - 1.0, b * tension
        if reality.straight_share > 0.0:
            tension, steepness = straightened(reality.straight_share, F_o, b, strain - lengthened)
        active = state.activation[i] + swallowed
        if active > 0.0 or reality.straight_share > 0.0:
            total = max(tension + active, LEAST_TENSION)
            effective[i, 1] = min(steepness / total, max(b, STEEPEST))
            effective[i, 0] = total * exp(-effective[i, 1] * strain)
        if reacts:
            end = add(velocity, apply(body_to_head, cross(omega, row3(jaw.insertion, i))))
            rise = max(0.0, -steepness / jaw.l_o[i] * dot(direction, end))
            held = reality.guarding_gain * F_o * b * max(0.0, stretch - reality.guarding_onset)
            _excite(reality, state, i, rise, held, dt)


@njit
def straightened(share, F_o, b, strain):
    """Tension (N) of a law of which a share is a straight line, and its growth with the strain."""
    slope = F_o * (exp(b * STRAIGHT_TO) - 1.0) / STRAIGHT_TO
    tension, line = F_o * exp(b * strain), max(0.0, F_o + slope * strain)
    straight = share * slope if line > 0.0 else 0.0
    return share * line + (1.0 - share) * tension, straight + (1.0 - share) * b * tension


@njit
def swallow(reality: RealityRecord, state: RealityState, dt):
    """Active tension (N) of a swallow in the coming ``dt``; advances its clock."""
    if reality.swallow_force == 0.0:
        return 0.0
    if state.swallow_clock >= reality.swallow_every:
        state.swallow_clock -= reality.swallow_every
    since = state.swallow_clock
    state.swallow_clock += dt
    return reality.swallow_force * sin(pi * since / SWALLOW_TIME) if since < SWALLOW_TIME else 0.0


@njit
def _excite(reality: RealityRecord, state: RealityState, i, rise, held, dt):
    """Advance the active tension of line i by ``dt``, the passive tension rising by ``rise`` N/s; shifts its delay.

    ``held`` (N) is what guarding goes to.
    """
    last = state.delay.shape[0]
    late = min(max(round(reality.reflex_latency / dt) - 1, 0), last)
    excitation = rise if late == 0 else state.delay[late - 1, i]
    for tick in range(last - 1, 0, -1):
        state.delay[tick, i] = state.delay[tick - 1, i]
    state.delay[0, i] = rise
    level = reality.reflex_gain * reality.reflex_lag * excitation + held
    state.activation[i] += (1.0 - exp(-dt / reality.reflex_lag)) * (level - state.activation[i])
