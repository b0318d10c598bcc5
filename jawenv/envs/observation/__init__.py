"""The agent's observation: the place and scale of each part. ``world.observation`` fills it."""

from __future__ import annotations

from functools import cache
from itertools import product

from jawenv.base.errors import InputError
from jawenv.device.comfort import N_LIMITS
from jawenv.device.device import N_MOTORS
from jawenv.ladder import MODELS

OBSERVATION_BOUND = 10.0
_BELIEF = ("belief_mean", "belief_sd")  # (mean - prior mean) / prior sd; log10(sd / prior sd); each per parameter
_REST_SIZES = {
    "pose": 5,  # filtered x, y / 5 mm; theta / 0.25 rad; psi, alpha / 0.1 rad
    "rates": 5,  # filtered x', y' / 20 mm/s; omega / 0.5 rad/s
    "jaw": 3,  # opening, side, fore-aft: signed used fractions of the soft limits, 0 at rest
    "jaw_range": 3,  # soft limits: opening / 30 mm, side / 10 mm, fore-aft / 10 mm
    "force": 6,  # load cell, body axes: force / 24 N, moment / (24 N x 20 mm)
    "motor_thrust": N_MOTORS,  # / full scale
    # Trajectory control: each motor's target less its position / 10 mm. Targets control: the channels' targets now, as
    # the guard leaves them. Force control: 0.
    "motor_target": N_MOTORS,
    "comfort_margin": N_LIMITS,  # 1 - used fraction, of the estimate
    "time_left": 1,  # share of the episode
}
POSE_SCALE = (0.005, 0.005, 0.25, 0.1, 0.1)
RATE_SCALE = (0.02, 0.02, 0.5, 0.5, 0.5)
RANGE_SCALE = (0.03, 0.01, 0.01)
FORCE_SCALE = 24.0
MOMENT_SCALE = FORCE_SCALE * 0.02
TARGET_SCALE = 0.01


def observation_layout(
    n_parameters: int = 12, asked: bool = False, budget: bool = False, correlations: bool = False
) -> dict[str, slice]:
    """Slices of the parts of the flat observation, in a model with so many parameters: name -> slice.

    Where muscles are ``asked`` for, ``asked`` (1 or 0 for each) and ``discomfort`` (of the episode so far, s) follow;
    elsewhere, where the device keeps a ``budget`` of discomfort, ``spent`` (share of it, as the device takes it to be).
    Last are the belief's ``correlations``, where they are observed: row by row, above the diagonal.
    """
    layout, start = {}, 0
    end = {"asked": n_parameters // 2, "discomfort": 1} if asked else {"spent": 1} if budget else {}
    pairs = {"correlations": n_parameters * (n_parameters - 1) // 2} if correlations else {}
    for name, size in (dict.fromkeys(_BELIEF, n_parameters) | _REST_SIZES | end | pairs).items():
        layout[name] = slice(start, start + size)
        start += size
    return layout


def observation_size(n_parameters: int = 12, *ends: bool, **named: bool) -> int:
    """Length of the flat observation."""
    return sum(part.stop - part.start for part in observation_layout(n_parameters, *ends, **named).values())


@cache
def layouts() -> dict[int, tuple[int, bool, bool, bool]]:
    """Arguments of ``observation_layout`` by the length of an observation: those of the models."""
    numbers = {len(model.muscles.parameter_names) for model in MODELS.values()}
    ends = (False, False), (True, False), (False, True)
    kinds = [(number, *end, pairs) for number, end, pairs in product(numbers, ends, (False, True))]
    return {observation_size(*kind): kind for kind in kinds if kind[0] > 2 or not kind[-1]}


def parameters_of(size: int) -> int:
    """Number of parameters that an observation of this length belongs to."""
    if size not in layouts():
        raise InputError(f"an observation has {size} values; allowed: {', '.join(map(str, sorted(layouts())))}")
    return layouts()[size][0]


OBSERVATION_LAYOUT = observation_layout()
"""The layout of ``jawenv/Jaw-v3``, with its 12 parameters."""

OBSERVATION_REST = observation_layout(0)
"""The layout behind the belief, counted from the belief's end."""
