"""True jaws that Python moves: the user's own mechanics, or pymunk's, which the same path serves."""

from __future__ import annotations

import copy
from collections.abc import Callable
from math import isfinite
from typing import Any, Protocol

import numpy as np
from gymnasium.error import ResetNeeded
from numpy.typing import NDArray

from jawenv.base.errors import InputError, shown
from jawenv.base.numeric_fields import real_number
from jawenv.device.device import TICK
from jawenv.envs.world.plant_kernel import (
    plant_begin,
    plant_clear,
    plant_end,
    plant_inform,
    plant_rest,
    plant_wrench,
)
from jawenv.envs.world.step_kernel import Shared, StepRows
from jawenv.mechanics.kinematics import contact_point
from jawenv.mechanics.plant import BodyMotion, PatientJaw, Six, body_motion, checked_motion, motion_at_mouthpiece

__all__ = ["HeldWrench", "MovedJaw", "MovedPlants", "WrenchOn"]

STEP = 0.5e-3  # s, of a plant that says nothing: servos, stops and brake answer within a tick

WrenchOn = Callable[[BodyMotion, float, float, float], Six]
"""``wrench_on(motion, since, middle, length)``: force and moment on the mouthpiece in body axes, for the time since the
tick began (s) at which the device answers, about which its answer acts, and for how long it does."""


class MovedJaw(Protocol):
    """A jaw that ``MovedPlants`` moves: a plant, whatever its way to take the wrench."""

    def begin(self, patient: PatientJaw, rng: np.random.Generator) -> BodyMotion:
        """Put a patient's jaw at rest."""

    def advance(self, duration: float, wrench_on: WrenchOn) -> BodyMotion:
        """Move the jaw through ``duration`` (s)."""

    def begin_step(self) -> None:
        """Forget what no copy could know."""

    def take_muscles(self, muscles: NDArray[np.float64]) -> None:
        """F_o and b (lines, 2) of the coming tick."""


class HeldWrench:
    """A plant of the user's, under a wrench that is held for ``step_s``.

    Args:
        plant: which is moved.
    """

    def __init__(self, plant: Any) -> None:
        """Read how long a wrench is held."""
        self.plant, self._name = plant, f"plant {type(plant).__name__}"
        step = real_number(getattr(plant, "step_s", STEP)) or np.nan
        parts = TICK / step
        if not (isfinite(parts) and parts > 0.5 and abs(parts - round(parts)) < 1e-6):
            raise InputError(f"{self._name}: step_s is {shown(plant.step_s)}; allowed: {TICK:g} over a whole number")
        self._steps = round(parts)

    def begin(self, patient: PatientJaw, rng: np.random.Generator) -> BodyMotion:
        """Put a patient's jaw at rest by the plant's ``reset``."""
        self._mouthpiece = patient.jaw["mouthpiece"].copy()
        return self._taken(self.plant.reset(patient, rng), "reset")

    def advance(self, duration: float, wrench_on: WrenchOn) -> BodyMotion:
        """Move the jaw through ``duration`` (s), in steps of a held wrench."""
        step = duration / self._steps
        for k in range(self._steps):
            wrench = np.array(wrench_on(self._motion, k * step, (k + 0.5) * step, step))
            self._taken(self.plant.advance(wrench, step), "advance")
        return self._motion

    def begin_step(self) -> None:
        """A plant of the user's is copied as a whole."""

    def take_muscles(self, muscles: NDArray[np.float64]) -> None:
        """Give F_o and b (lines, 2) of the coming tick to a plant that takes them."""
        if hasattr(self.plant, "take_muscles"):
            self.plant.take_muscles(muscles[:, 0].copy(), muscles[:, 1].copy())

    def _taken(self, value: object, method: str) -> BodyMotion:
        self._motion = body_motion(checked_motion(value, f"{self._name}: {method}"), self._mouthpiece)
        return self._motion


class MovedPlants:
    """The plants of N worlds.

    Args:
        plant: A ``MovedJaw``, of which every episode has a copy.
        line_names: Names of the lines' muscles.
        shared: Device, settings, and working memory of each world.
        models: The filter's jaws.
        worlds: The worlds.
        rows: What they have read, what was true then, and what is seen; filled where a world is moved.
    """

    def __init__(
        self, plant: MovedJaw, line_names: tuple[str, ...], shared: Shared, models: Any, worlds: Any, rows: StepRows
    ) -> None:
        """Keep the worlds; plants are copied when these are reset."""
        self._plant, self._line_names = plant, line_names
        self._shared, self._models, self._worlds, self._rows = shared, models, worlds, rows
        self.each: list[Any] = [None] * len(worlds)
        """(N,) the plants of the present episodes; None where none has begun, or where it has failed."""

    def reset(self, chosen: NDArray[np.bool_]) -> None:
        """Put the jaws of the chosen worlds at rest, and read them."""
        plants = list(self.each)
        for i in np.flatnonzero(chosen).tolist():
            plants[i] = copy.deepcopy(self._plant)
            self._rest(i, plants[i])
        self.each = plants

    def _rest(self, i: int, plant: MovedJaw) -> None:
        truth = self._worlds["truth"][i]
        rng = np.random.default_rng(truth["key"].tolist())
        motion = plant.begin(self._patient(truth), rng)
        device, settings, scratches = self._shared
        if not plant_rest(device, self._models, self._worlds, i, settings, scratches, motion):
            x, y, z = (1e3 * np.array(motion[0][:3])).tolist()
            raise InputError(
                f"the plant rests with the condyles' midpoint at ({x:.1f}, {y:.1f}, {z:.1f}) mm and opened by "
                f"{np.degrees(motion[0][3]):.1f} degrees; allowed: less than 35 mm open and 5 mm aside"
            )
        self._end_tick(i, motion)
        self._inform(i)

    def _patient(self, truth: Any) -> PatientJaw:
        x, y, *angles = truth["state"][:5].tolist()
        place = contact_point(truth["jaw"], (x, y, *angles))
        rest = motion_at_mouthpiece(((*place, *angles), (0.0,) * 6), truth["jaw"]["mouthpiece"])
        F_o, b = truth["muscles"].T.copy()
        return PatientJaw(truth["jaw"].copy(), self._line_names, F_o, b, rest)

    def advance(self, actions: NDArray[np.float64], active: NDArray[np.bool_]) -> None:
        """One control period of every active world with ``actions`` (N, 4).

        Raises:
            InputError: a plant that gives no motion.
            ResetNeeded: the plant of one of the worlds has failed since its reset.
        """
        numbers = np.flatnonzero(active).tolist()
        if any(self.each[i] is None for i in numbers):
            raise ResetNeeded("the plant has failed in this episode; call reset() before step()")
        for i in numbers:
            plant, self.each[i] = self.each[i], None
            self._advance_world(i, plant, actions)
            self.each[i] = plant

    def _advance_world(self, i: int, plant: MovedJaw, actions: NDArray[np.float64]) -> None:
        device, settings, scratches = self._shared
        worlds = self._worlds

        def wrench_on(motion: BodyMotion, since: float, middle: float, length: float) -> Six:
            times = since, middle, length
            wrench: Six = plant_wrench(device, worlds, i, settings, scratches, motion, times)
            return wrench

        plant.begin_step()
        plant_clear(worlds, i)
        for _ in range(int(settings["control"]["ticks_per_step"][0])):
            plant_begin(device, self._models, worlds, i, actions, settings, scratches)
            plant.take_muscles(scratches["effective"][i])
            self._end_tick(i, plant.advance(TICK, wrench_on))
        self._inform(i)

    def _end_tick(self, i: int, motion: BodyMotion) -> None:
        device, settings, scratches = self._shared
        plant_end(device, self._models, self._worlds, i, settings, scratches, self._rows, motion)

    def _inform(self, i: int) -> None:
        device, settings, scratches = self._shared
        plant_inform(device, self._models, self._worlds, i, settings, scratches, self._rows)
