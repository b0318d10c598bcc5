"""The agent's observation: the place and scale of each part. ``world.observation`` is where it is made."""

from jawenv.envs.world.observation import (
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
    bounded,
    filtered_motion,
    observation_layout,
    observation_size,
    observe_world,
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
    "bounded",
    "filtered_motion",
    "observation_layout",
    "observation_size",
    "observe_world",
    "parameters_of",
]
