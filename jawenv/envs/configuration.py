"""The arguments of the environments, checked."""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from typing import Any, Literal, TypedDict, TypeVar, cast, get_args

import numpy as np

from jawenv.anatomy import Anatomy, Cohort, MuscleSet, anatomy_of, cohort
from jawenv.anatomy.knowledge import Knowledge, knowledge
from jawenv.checks import real_number
from jawenv.controls import CONTROLS, DEFAULT_CONTROL, Control, ControlMode
from jawenv.device.comfort_settings import Comfort, comfort_of
from jawenv.device.device import Device, device_of
from jawenv.device.force_sensor import ForceSensor
from jawenv.envs.own_estimators import OwnEstimator, is_own_estimator
from jawenv.envs.world.plants import TICK
from jawenv.envs.world.tracking import LAW_TICKS
from jawenv.errors import InputError, UnknownArgumentError, meant, not_among, shown
from jawenv.files import Source
from jawenv.ladder import Estimator, model_named
from jawenv.reality import Reality, check_reality

Sensors = Literal["pose", "point"]
Reward = Literal["uncertainty", "bound", "score", "worst", "mixed"]

Initialise = TypeVar("Initialise", bound=Callable[..., None])

NO_ESTIMATOR = "none"  # the argument ``estimator`` of who does not read the belief

LARGEST = 1e6  # of the numeric arguments


class Arguments(TypedDict, total=False):
    """What the environments are made with, as keyword arguments; ``Configuration`` has defaults and checks."""

    control: Control
    sensors: Sensors
    reward: Reward
    cohort: str | Cohort | Source
    episode_s: float
    control_hz: float | None
    comfort_weight: float
    track_bound: bool
    record: bool
    device: Device | Source | None
    reality: Reality | Source | None
    model: str
    estimator: Estimator | Literal["none"] | OwnEstimator | None
    knowledge: str | Knowledge | Source | None
    force_sensor: ForceSensor
    comfort: Comfort | Source | None
    anatomy: Anatomy | Source | None


@dataclass(frozen=True)
class Configuration:
    """The arguments that ``gymnasium.make`` passes on, checked.

    Numbers become Python's own; cohort, device, reality, comfort and anatomy become objects: a file is read once.
    """

    control: Control = DEFAULT_CONTROL
    sensors: Sensors = "pose"
    reward: Reward = "uncertainty"
    cohort: str | Cohort | Source = "trismus"
    episode_s: float = 30.0
    control_hz: float | None = None
    comfort_weight: float = 0.0
    track_bound: bool = False
    record: bool = False
    device: Device | Source | None = None
    reality: Reality | Source | None = None
    model: str = "jaw"
    estimator: Estimator | Literal["none"] | OwnEstimator | None = None
    knowledge: str | Knowledge | Source | None = None
    force_sensor: ForceSensor = "cell"
    comfort: Comfort | Source | None = None
    anatomy: Anatomy | Source | None = None

    def __post_init__(self) -> None:
        """Check every field.

        Raises:
            InputError: a field has a value that is not allowed.
        """
        kinds = ("control", Control), ("sensors", Sensors), ("reward", Reward), ("force_sensor", ForceSensor)
        for name, kind in kinds:
            value = getattr(self, name)
            if not isinstance(value, str) or value not in get_args(kind):
                raise not_among(name, value, get_args(kind))
        self._set("episode_s", _checked_number("episode_s", self.episode_s))
        hz = self.mode.steps_per_s
        if self.control_hz is not None:
            hz = _checked_number("control_hz", self.control_hz)
        self._set("control_hz", hz)
        self._set("comfort_weight", _checked_number("comfort_weight", self.comfort_weight, or_zero=True))
        model = model_named(self.model)
        names = (*model.estimators, NO_ESTIMATOR)
        if self.estimator is not None and self._estimator_name() not in names and self.own_estimator is None:
            allowed = ", ".join(names)
            raise InputError(
                f"estimator is {shown(self.estimator)}; allowed in {model.title}: {allowed}, or an object with the "
                "methods reset(start) and update(measured, samples)"
            )
        least = LAW_TICKS if self.mode.takes_targets else 1
        periods = 1.0 / hz / TICK / least
        if not math.isfinite(periods) or abs(periods - round(periods)) > 1e-9 or periods < 1.0:
            highest = 1.0 / (least * TICK)
            raise InputError(f"control_hz is {hz:g}; allowed: {highest:g} divided by a whole number")
        if self.steps < 1:
            raise InputError(f"episode_s is {self.episode_s:g}; allowed: at least one control period")
        for name in ("track_bound", "record"):
            if not isinstance(getattr(self, name), bool | np.bool_):
                raise InputError(f"{name} is {shown(getattr(self, name))}; allowed: true or false")
            self._set(name, bool(getattr(self, name)))
        self._set("comfort", comfort_of(self.comfort))
        if self.anatomy is not None:
            self._set("anatomy", anatomy_of(self.anatomy))
        self._set("cohort", cohort(self.cohort, self.muscles))
        self._set("device", device_of(self.device))
        self._set("reality", check_reality(self.reality))
        self._set("knowledge", knowledge(self.knowledge))
        if (self.filter_model == "bilateral" or model.plant == "contact") and not self.build_knowledge().exact:
            why = "its contacts are" if model.plant == "contact" else "its filter has two condyles, and is"
            raise InputError(f"knowledge is not exact; allowed in {model.title}: exact, as {why} of known anatomy")
        self._check_force_sensor()

    def _check_force_sensor(self) -> None:
        """A force without a load cell is for one reference point.

        Raises:
            InputError: it is asked for together with what does not know it.
        """
        if self.force_sensor == "cell":
            return
        model = model_named(self.model)
        if self.filter_model == "bilateral" or model.plant == "contact":
            raise InputError(f"force_sensor is {self.force_sensor!r}; allowed in {model.title}: 'cell'")

    def _set(self, name: str, value: object) -> None:
        object.__setattr__(self, name, value)

    @property
    def mode(self) -> ControlMode:
        """What its control mode is."""
        return CONTROLS[self.control]

    @property
    def filter_model(self) -> Estimator:
        """The mechanics that the filter believes in."""
        name = self._estimator_name()
        return model_named(self.model).estimator if name is None or name == "none" else name

    def _estimator_name(self) -> Estimator | Literal["none"] | None:
        return self.estimator if isinstance(self.estimator, str) else None

    @property
    def own_estimator(self) -> OwnEstimator | None:
        """The user's estimator, which every world has a copy of."""
        return cast(OwnEstimator, self.estimator) if is_own_estimator(self.estimator) else None

    @property
    def steps_per_s(self) -> float:
        """Control periods per second: ``control_hz`` once it is checked."""
        assert self.control_hz is not None
        return self.control_hz

    @property
    def needs_bound(self) -> bool:
        """Whether the bound's recursion runs beside the filter's."""
        return self.track_bound or self.reward == "bound"

    @property
    def ticks_per_step(self) -> int:
        """Sensor and filter ticks in one control period."""
        return round(1.0 / (self.steps_per_s * TICK))

    @property
    def steps(self) -> int:
        """Control periods in an episode."""
        return round(self.episode_s * self.steps_per_s)

    def build_anatomy(self) -> Anatomy:
        """Attachments, mandible and fossa that the filter believes in; those of the truth unless something errs."""
        return anatomy_of(self.anatomy)

    @property
    def muscles(self) -> MuscleSet:
        """The muscles of the model with their lines of action."""
        model = model_named(self.model)
        return model.muscles if self.anatomy is None else self.build_anatomy().muscle_sets()[model.muscle_set]

    def build_comfort(self) -> Comfort:
        """What is allowed of patients, with the fields that the user changed."""
        return comfort_of(self.comfort)

    def build_cohort(self) -> Cohort:
        """Whom ``reset`` draws, with the muscles of the model."""
        return cohort(self.cohort)

    def build_device(self) -> Device:
        """The device with the fields that the user changed."""
        return device_of(self.device)

    def build_knowledge(self) -> Knowledge:
        """What the filter knows within an sd, and the truth is drawn from."""
        return knowledge(self.knowledge)

    def build_reality(self) -> Reality:
        """What the filter does not know, with the fields that the user changed."""
        return check_reality(self.reality)


def _checked_number(name: str, value: object, or_zero: bool = False) -> float:
    """A number more than 0, or also 0, and at most ``LARGEST``."""
    number = real_number(value)
    if number is None or not 0.0 <= number <= LARGEST or (number == 0.0 and not or_zero):
        low = "0 or more" if or_zero else "more than 0"
        raise InputError(f"{name} is {shown(value)}; allowed: a number, {low}, at most {LARGEST:g}")
    return number


def configure(arguments: Mapping[str, object], owner: type = Configuration) -> Configuration:
    """Configuration from keyword arguments.

    Args:
        arguments: By name.
        owner: The class that got them, for the message.

    Raises:
        UnknownArgumentError: an argument is unknown; both an ``InputError`` and a ``TypeError``, in Python's words.
        InputError: an argument has a value that is not allowed.
    """
    names = [field.name for field in fields(Configuration)]
    for name in arguments:
        if name not in names:
            raise UnknownArgumentError(
                f"{owner.__name__}.__init__() got an unexpected keyword argument {shown(name)}; "
                f"{meant(name, names)}allowed: {', '.join(names)}"
            )
    return Configuration(**cast(Any, arguments))


def takes_arguments(initialise: Initialise) -> Initialise:
    """Decorator of an ``__init__`` with ``**arguments: Unpack[Arguments]``; its signature names each, with defaults."""
    stated = inspect.signature(initialise)
    own = [one for one in stated.parameters.values() if one.kind is not one.VAR_KEYWORD]
    listed = [
        inspect.Parameter(one.name, inspect.Parameter.KEYWORD_ONLY, default=one.default, annotation=one.type)
        for one in fields(Configuration)
    ]
    before = [one for one in own if one.kind is not one.KEYWORD_ONLY]
    after = [one for one in own if one.kind is one.KEYWORD_ONLY]
    vars(initialise)["__signature__"] = stated.replace(parameters=[*before, *listed, *after])
    return initialise
