"""The arguments of the environments, checked."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from typing import TYPE_CHECKING, Any, Literal, cast, get_args

from jawenv.anatomy import (
    COHORTS,
    Cohort,
    Fossa,
    Mandible,
    MuscleSet,
    cohort,
    default_fossa,
    default_mandible,
)
from jawenv.anatomy.knowledge import Knowledge, knowledge
from jawenv.base.errors import InputError, UnknownArgumentError, meant, shown
from jawenv.base.files import Source
from jawenv.base.numeric_fields import NumericFields
from jawenv.controls import CONTROLS, DEFAULT_CONTROL, Control, ControlMode
from jawenv.device.comfort_settings import Comfort, comfort_of
from jawenv.device.device import TICK, Device, device_of
from jawenv.device.force_sensor import ForceSensor
from jawenv.envs.argument_checks import check_choice, checked_flag, checked_number, checked_rate
from jawenv.envs.observation import Parts
from jawenv.envs.registration import IMAGED
from jawenv.envs.rewards import POTENTIALS
from jawenv.ladder import DEFAULT_ENV, KNOWN_WITHIN_SDS, env_id_of, model_named, model_of_env
from jawenv.reality import Reality, check_reality

if TYPE_CHECKING:
    from jawenv.anatomy.description import Anatomy
    from jawenv.envs.own_estimators import OwnEstimator
    from jawenv.mechanics.plant import Plant

Sensors = Literal["pose", "point"]
Info = Literal["full", "light"]

NO_ESTIMATOR = "none"  # the argument ``estimator`` of who does not read the belief


def _argument(default: Any, help: str, metavar: str = "", option: str = "") -> Any:
    """A field of ``Configuration``.

    Args:
        default: its default.
        help: a sentence for tables and command lines.
        metavar: what stands for its value there.
        option: how an option of command lines takes it: "value", "number", "fields" (FIELD=VALUE, repeated, or a
            file); where it is empty, the argument is given by ``--set NAME=VALUE``.
    """
    return field(default=default, metadata={"help": help, "metavar": metavar, "option": option})


@dataclass(frozen=True)
class Configuration:
    """A world to be played: the arguments that ``gymnasium.make`` passes on, checked.

    Environments, studies, trainings, cards and command lines hand this on whole; tables of arguments and options of
    commands are made of its fields. Numbers become Python's own; cohort, device, reality, knowledge, comfort and
    anatomy become objects: a file is read once.
    """

    control: Control = _argument(
        DEFAULT_CONTROL, "What an action commands: targets, force or trajectory.", "NAME", "value"
    )
    sensors: Sensors = _argument("pose", "What the encoders measure: pose, or one point.")
    reward: str = _argument("uncertainty", f"What is paid for: {', '.join(POTENTIALS)}.")
    cohort: str | Cohort | Source = _argument(
        "trismus",
        "Population the patients are drawn from: a name of `jawenv list cohorts`, or a file.",
        "NAME",
        "value",
    )
    episode_s: float = _argument(30.0, "Length of every episode, s.", "S", "number")
    control_hz: float | None = _argument(None, "Control steps per second; the control mode's own by default.")
    comfort_weight: float = _argument(0.0, "What a second of discomfort of 1 takes from the reward, nats.")
    comfort_limit_s: float = _argument(0.0, "Discomfort of an episode, s, up to which `comfort_weight` takes nothing.")
    comfort_budget_s: float | None = _argument(
        None, "Discomfort of an episode, s, that the device keeps in targets control; none by default.", "S", "number"
    )
    track_bound: bool = _argument(False, "Whether `info` has the bound as well.")
    info: Info = _argument("full", "Which keys `info` has: full for all, light for those of belief, cost and time.")
    record: bool = _argument(False, "Whether what the device measures is kept.")
    device: Device | Source | None = _argument(
        None, "Another value of a field of the device, as cell_force_N=0.2, or a file of them.", "FIELD=VALUE", "fields"
    )
    reality: Reality | Source | None = _argument(
        None, "Effect that the filter does not know, as creep_share=0.3, or a file of them.", "FIELD=VALUE", "fields"
    )
    model: str = _argument("jaw", "Model of the jaw, which an environment's id names.")
    estimator: Literal["none"] | OwnEstimator | None = _argument(
        None, "An estimator of the user's own, or none where nobody reads the belief; the filter by default."
    )
    knowledge: str | Knowledge | Source | None = _argument(
        None, "What the filter knows of anatomy and device: exact, imaged, bench, or a file of sds.", "NAME", "value"
    )
    force_sensor: ForceSensor = _argument("cell", "How the device knows its force: cell, motors or straps.")
    comfort: Comfort | Source | None = _argument(None, "File of comfort limits that differ from the default's.")
    anatomy: Anatomy | Source | None = _argument(
        None, "File of attachments, mandible and fossa that differ from the default's."
    )
    plant: str | Plant | None = _argument(
        None, "Mechanics of the true jaw that are the user's own, a class as my_module:MyJaw."
    )
    asked: str | None = _argument(
        None,
        "Muscles that are asked for: one by its name, random for one drawn at reset, or a word of several, as left.",
    )

    def __post_init__(self) -> None:
        """Check every field, in this order: a cohort has the anatomy's muscles, an episode whole steps of the rate."""
        kinds = {"control": Control, "sensors": Sensors, "info": Info, "force_sensor": ForceSensor}
        choices = {name: get_args(kind) for name, kind in kinds.items()} | {"reward": tuple(POTENTIALS)}
        for name, allowed in choices.items():
            check_choice(name, getattr(self, name), allowed)
        self._set("episode_s", checked_number("episode_s", self.episode_s))
        given = self.control_hz
        self._set("control_hz", checked_rate(self.mode.steps_per_s if given is None else given, self.mode))
        for name in ("comfort_weight", "comfort_limit_s"):
            self._set(name, checked_number(name, getattr(self, name), or_zero=True))
        self._check_budget()
        self._check_estimator()
        if self.steps < 1:
            raise InputError(f"episode_s is {self.episode_s:g}; allowed: at least one control period")
        for name in ("track_bound", "record"):
            self._set(name, checked_flag(name, getattr(self, name)))
        self._set("comfort", comfort_of(self.comfort))
        if self.anatomy is not None:
            from jawenv.anatomy.description import anatomy_of

            self._set("anatomy", anatomy_of(self.anatomy))
        self._set("cohort", cohort(self.cohort, self.muscles))
        if self.asked is not None:
            from jawenv.envs.asked import checked_asked

            self._set("asked", checked_asked(self.asked, self.muscles.names))
        self._set("device", device_of(self.device))
        self._set("reality", check_reality(self.reality))
        self._set("knowledge", knowledge(self.knowledge))
        self._check_exactness()
        if self.plant is not None:
            self._check_plant(self.plant)

    @staticmethod
    def _check_plant(plant: str | Plant) -> None:
        """A plant that is named is not imported before it is to move."""
        from jawenv.base.named_objects import is_named
        from jawenv.mechanics.plant import plant_of

        if not (isinstance(plant, str) and is_named(plant)):
            plant_of(plant)

    def _check_budget(self) -> None:
        if self.comfort_budget_s is None:
            return
        self._set("comfort_budget_s", checked_number("comfort_budget_s", self.comfort_budget_s))
        if not self.mode.takes_targets:
            why = f"allowed in {self.control} control: none, as targets keep it"
            raise InputError(f"comfort_budget_s is {self.comfort_budget_s:g}; {why}")

    def _check_estimator(self) -> None:
        """The estimator is the filter, the user's own or none."""
        if self.estimator is not None and self.motion_only == (self.own_estimator is not None):
            allowed = f"{NO_ESTIMATOR}, or an object with the methods reset(start) and update(measured, samples)"
            raise InputError(f"estimator is {shown(self.estimator)}; allowed: {allowed}")

    def _check_exactness(self) -> None:
        """Contacts are of known anatomy and have a load cell."""
        model = model_named(self.model)
        if model.plant != "contact":
            return
        if not self.build_knowledge().exact:
            why = "as its contacts are of known anatomy"
            raise InputError(f"knowledge is not exact; allowed in {model.title}: exact, {why}")
        if self.force_sensor != "cell":
            raise InputError(f"force_sensor is {self.force_sensor!r}; allowed in {model.title}: 'cell'")

    def _set(self, name: str, value: object) -> None:
        object.__setattr__(self, name, value)

    @classmethod
    def from_mapping(cls, mapping: Mapping[str, Any]) -> Configuration:
        """A configuration from a mapping: ``env``, as `jawenv.ladder.env_id_of` takes it, and arguments."""
        env_id = env_id_of(mapping.get("env", DEFAULT_ENV))
        return configure(_registered_arguments(env_id) | {key: value for key, value in mapping.items() if key != "env"})

    def to_mapping(self) -> dict[str, Any]:
        """The id of its environment as ``env``, and ``arguments``."""
        return {"env": self.env_id, **self.arguments}

    @property
    def env_id(self) -> str:
        """Gymnasium's id of the environment, whose own arguments are the defaults of ``arguments``."""
        imaged = configure(_registered_arguments(KNOWN_WITHIN_SDS))
        alike = self.model == imaged.model and self.knowledge == imaged.knowledge and self.device == imaged.device
        return KNOWN_WITHIN_SDS if alike else model_named(self.model).env_id

    @property
    def arguments(self) -> dict[str, Any]:
        """Plain arguments with which ``gymnasium.make`` makes the same of the id: all that differ from its own.

        Control, sensors, cohort and length are always there.
        """
        own = configure({"control": self.control} | _registered_arguments(self.env_id))
        changed = [
            argument.name
            for argument in fields(self)
            if argument.name in STATED or getattr(self, argument.name) != getattr(own, argument.name)
        ]
        return {name: _plain(name, getattr(self, name)) for name in changed if name != "model"}

    @property
    def digest(self) -> str:
        """Sixteen hexadecimal digits that change with anything that is played; cohorts count with their numbers."""
        whole = {**self.to_mapping(), "cohort": self.build_cohort().to_dict()}
        return hashlib.sha256(json.dumps(whole, sort_keys=True).encode()).hexdigest()[:16]

    def differences(self, other: Configuration) -> tuple[str, ...]:
        """Names of the arguments in which another one is not the same."""
        return tuple(
            argument.name for argument in fields(self) if getattr(self, argument.name) != getattr(other, argument.name)
        )

    @property
    def mode(self) -> ControlMode:
        """Its control mode."""
        return CONTROLS[self.control]

    @property
    def parts(self) -> Parts:
        """Parts of the observation."""
        return Parts(len(self.muscles.parameter_names), self.asked is not None, self.comfort_budget_s is not None)

    @property
    def motion_only(self) -> bool:
        """Whether the filter follows the motion alone, since nobody reads the belief."""
        return isinstance(self.estimator, str) and self.estimator == NO_ESTIMATOR

    @property
    def own_estimator(self) -> OwnEstimator | None:
        """The user's estimator, which every world has a copy of; ``belief`` may appear with its first reset."""
        value: Any = self.estimator
        calls = [callable(getattr(value, name, None)) for name in ("reset", "update")]
        return value if all(calls) and not isinstance(value, type) else None

    @property
    def own_plant(self) -> Plant | None:
        """The user's plant, of which every episode has a copy; where it is named, its module is imported."""
        if self.plant is None:
            return None
        from jawenv.mechanics.plant import plant_of

        plant = plant_of(self.plant)
        reality = self.build_reality()
        if (reality.creep_share or reality.reflex_gain or reality.straight_share) and not hasattr(
            plant, "take_muscles"
        ):
            name = type(plant).__name__
            raise InputError(
                f"plant {name} has no take_muscles; allowed: creep_share, reflex_gain, straight_share of 0"
            )
        return plant

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

    @property
    def _own_anatomy(self) -> Anatomy | None:
        return cast("Anatomy | None", self.anatomy)

    @property
    def mandible(self) -> Mandible:
        """The mandible that the filter believes in; that of the truth unless something errs."""
        return default_mandible() if self._own_anatomy is None else self._own_anatomy.mandible

    @property
    def fossa(self) -> Fossa:
        """The condylar path that the filter believes in."""
        return default_fossa() if self._own_anatomy is None else self._own_anatomy.fossa

    @property
    def muscles(self) -> MuscleSet:
        """The muscles of the model with their lines of action."""
        model = model_named(self.model)
        own = self._own_anatomy
        return model.muscles if own is None else own.muscle_sets()[model.muscle_set]

    def build_comfort(self) -> Comfort:
        """The comfort limits, with the user's changes."""
        return comfort_of(self.comfort)

    def build_cohort(self) -> Cohort:
        """Whom ``reset`` draws, with the muscles of the model."""
        return cohort(self.cohort)

    def build_device(self) -> Device:
        """The device with the fields that the user changed."""
        return device_of(self.device)

    def build_knowledge(self) -> Knowledge:
        """The sds of anatomy and mounting, for the filter and for the draw of the truth."""
        return knowledge(self.knowledge)

    def build_reality(self) -> Reality:
        """The effects of reality that the filter lacks, with the user's changes."""
        return check_reality(self.reality)


STATED = ("control", "sensors", "cohort", "episode_s")
"""Arguments that results and cards name whether they are the defaults or not."""


def _registered_arguments(env_id: str) -> dict[str, Any]:
    """The arguments with which an id is registered."""
    return dict(IMAGED) if env_id == KNOWN_WITHIN_SDS else {"model": model_of_env(env_id).name}


def described() -> str:
    """All arguments, a line each: name, default and meaning."""
    listed = fields(Configuration)
    return "\n".join(
        f"* ``{argument.name}`` ({argument.default!r}): {argument.metadata['help']}" for argument in listed
    )


def plain_value(name: str, value: object) -> Any:
    """An argument as text, numbers and mappings: of a file its content."""
    return _plain(name, getattr(configure({name: value}), name))


def _plain(name: str, value: object) -> Any:
    if isinstance(value, Cohort):
        shipped = COHORTS.get(value.name)
        return value.name if shipped is not None and shipped.groups == value.groups else value.to_dict()
    if isinstance(value, NumericFields):
        return value.changes()
    if name == "anatomy" and value is not None:
        return cast("Anatomy", value).to_dict()
    if not (value is None or isinstance(value, str | bool | int | float)):
        raise InputError(
            f"{name} is {shown(value)}; allowed where a configuration is kept: a name, a number, a mapping"
        )
    return value


def configure(
    arguments: Mapping[str, object], owner: type = Configuration, base: Configuration | None = None
) -> Configuration:
    """Configuration from keyword arguments.

    Args:
        arguments: By name.
        owner: The class that got them, for the message.
        base: Another one, which has the arguments that are not given; their defaults without it.

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
    return Configuration(**cast(Any, arguments)) if base is None else replace(base, **cast(Any, arguments))
