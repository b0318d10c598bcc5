"""The agent's observation: the place and scale of each part. ``world.observation`` fills it."""

from jawenv.envs.world.layout import (
    FORCE_SCALE,
    MOMENT_SCALE,
    OBSERVATION_BOUND,
    OBSERVATION_LAYOUT,
    OBSERVATION_REST,
    OBSERVATION_SIZE,
    POSE_SCALE,
    RANGE_SCALE,
    RATE_SCALE,
    TARGET_SCALE,
    layouts,
    observation_layout,
    observation_size,
    parameters_of,
)

__all__ = [
    "FORCE_SCALE",
    "MOMENT_SCALE",
    "OBSERVATION_BOUND",
    "OBSERVATION_LAYOUT",
    "OBSERVATION_REST",
    "OBSERVATION_SIZE",
    "POSE_SCALE",
    "RANGE_SCALE",
    "RATE_SCALE",
    "TARGET_SCALE",
    "layouts",
    "observation_layout",
    "observation_size",
    "parameters_of",
]
