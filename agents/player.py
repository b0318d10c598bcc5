"""Plays a maneuver: at each step the targets of its file become an action, within the patient's comfort."""

from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from agents.guard import comfortable_size
from agents.laws import Felt, ForceLaw, TrajectoryLaw, Wanted
from agents.maneuver import ROLL_FULL_SCALE_RAD, Maneuver, Targets
from agents.observed import Observed, read
from agents.protocol import Action, Array, Mask, Observation, State
from jawenv.device.comfort import SOFT_FORCE
from jawenv.errors import InputError

CONTROLS = ("force", "trajectory")


class Memory(NamedTuple):
    """What the player remembers, one row per world.

    Attributes:
        step: (N,) control steps since the episode began.
        size: (N, 4) what the targets of each channel are multiplied by, 0 to 1.
        integral: (N, 3) of the control law.
        rest_roll: (N,) roll at the start of the episode, rad.
    """

    step: NDArray[np.int64]
    size: Array
    integral: Array
    rest_roll: Array


class Player:
    """A maneuver as an agent, for either control mode.

    It works from the observation alone and keeps one memory per world. The memory is handed out as `state` and also
    kept, so a caller may pass it back or leave it out.

    Args:
        maneuver: the targets.
        control: control mode of the environment.
        control_hz: control steps per second of the environment.

    Raises:
        InputError: an unknown control mode or a rate that is not positive.
    """

    def __init__(
        self, maneuver: Maneuver, *, control: Literal["force", "trajectory"] = "force", control_hz: float = 20.0
    ) -> None:
        if control not in CONTROLS:
            raise InputError(f"control '{control}': allowed are {', '.join(CONTROLS)}")
        if not (np.isfinite(control_hz) and control_hz > 0):
            raise InputError(f"control_hz {control_hz}: must be a positive number")
        self.name = maneuver.name
        self.maneuver = maneuver
        holds_roll = maneuver.channels.roll is not None
        self._law = ForceLaw(holds_roll=holds_roll) if control == "force" else TrajectoryLaw()
        self._dt = 1.0 / control_hz
        self._memory: Memory | None = None

    def reset(self, num_envs: int, seed: int | None = None) -> None:
        """Forget all worlds; the next observations are taken as the start of their episodes."""
        self._memory = None

    def predict(
        self,
        observation: Observation,
        state: State = None,
        episode_start: Mask | None = None,
        deterministic: bool = True,
    ) -> tuple[Action, State]:
        """See `agents.protocol.Agent.predict`; a maneuver is always deterministic.

        Raises:
            InputError: an observation of the wrong size or not finite, or of another number of worlds than before.
        """
        rows = np.asarray(observation)
        single = rows.ndim == 1
        seen = read(rows[None] if single else rows)
        memory = self._recall(state, seen, episode_start)
        size = comfortable_size(memory.size, seen, self._dt)
        targets = self.maneuver.targets(self._dt * memory.step.astype(np.float64))
        targets = Targets(size * targets.value, size * targets.rate)
        wanted, felt = _wanted(targets, seen), _felt(seen, memory.rest_roll)
        action, integral = self._law.act(wanted, felt, memory.integral, self._dt)
        self._memory = Memory(memory.step + 1, size, integral, memory.rest_roll)
        single_precision = action.astype(np.float32)
        return (single_precision[0] if single else single_precision), self._memory

    def _recall(self, state: State, seen: Observed, episode_start: Mask | None) -> Memory:
        """The memory to go on from, blank for worlds that begin an episode."""
        worlds = len(seen.roll)
        blank = Memory(np.zeros(worlds, int), np.ones((worlds, 4)), np.zeros((worlds, 3)), seen.roll)
        memory = self._memory if state is None else Memory(*state)
        if memory is None or (episode_start is not None and np.all(episode_start)):
            return blank
        if len(memory.step) != worlds:
            raise InputError(
                f"observation of {worlds} worlds after {len(memory.step)} worlds: call reset({worlds}) first"
            )
        if episode_start is None:
            return memory
        starts = np.asarray(episode_start, dtype=bool).reshape(worlds)
        return Memory(
            *(
                np.where(starts.reshape(-1, *[1] * (old.ndim - 1)), new, old)
                for new, old in zip(blank, memory, strict=True)
            )
        )


def _wanted(targets: Targets, seen: Observed) -> Wanted:
    """Targets in physical units."""
    unit = np.column_stack([seen.range_mm[:, :2], np.full(len(seen.roll), ROLL_FULL_SCALE_RAD)])
    place, rate = targets.value[:, [0, 1, 3]] * unit, targets.rate[:, [0, 1, 3]] * unit
    return Wanted(place, rate, targets.value[:, 2] * SOFT_FORCE)


def _felt(seen: Observed, rest_roll: Array) -> Felt:
    """The observed place in the same units."""
    place = np.column_stack([seen.jaw[:, :2] * seen.range_mm[:, :2], seen.roll - rest_roll])
    return Felt(place, seen.forward_N, seen.down_N, seen.pitch, seen.jaw[:, 0])
