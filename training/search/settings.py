"""Settings of the searches: each field once, with its default and the help of its option."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from dataclasses import MISSING, dataclass, field, fields
from functools import wraps
from typing import TYPE_CHECKING, Annotated, Any, Literal, get_args, get_origin, get_type_hints

import typer

from jawenv.base.errors import InputError, shown
from jawenv.controls import DEFAULT_CONTROL, Control
from jawenv.envs.configuration import configure
from jawenv.ladder import model_of_env

if TYPE_CHECKING:
    from jawenv.playing.maneuvers import Maneuver

MOST_WORLDS = 10_000  # that are played at once; each takes about a megabyte
Criterion = Literal["worst", "D", "A"]
Over = Literal["mean", "tail", "nominal"]


def option(help: str, metavar: str | None = None, default: Any = MISSING) -> Any:
    """A field of settings that is an option of a command."""
    return field(default=default, metadata={"help": help, "metavar": metavar})


def takes(kind: type) -> Callable[[Callable[..., int]], Callable[..., int]]:
    """Decorator of a command with a parameter ``settings``: it has an option for each field of a dataclass instead."""

    def decorated(command: Callable[..., int]) -> Callable[..., int]:
        stated = inspect.signature(command, eval_str=True).parameters
        types, options = get_type_hints(kind), {}
        for each in fields(kind):
            plain = str if get_origin(types[each.name]) is Literal else types[each.name]
            default = inspect.Parameter.empty if each.default is MISSING else each.default
            options[each.name] = inspect.Parameter(
                each.name,
                inspect.Parameter.KEYWORD_ONLY,
                default=default,
                annotation=Annotated[plain, typer.Option(**each.metadata)],
            )

        @wraps(command)
        def run(**arguments: Any) -> int:
            return command(settings=kind(**{name: arguments.pop(name) for name in options}), **arguments)

        own = {name: each.replace(kind=each.KEYWORD_ONLY) for name, each in stated.items() if name != "settings"}
        parameters = dict(list(own.items())[:1]) | options | own
        vars(run)["__signature__"] = inspect.Signature(list(parameters.values()))
        run.__annotations__ = {name: each.annotation for name, each in parameters.items()}
        return run

    return decorated


@dataclass(frozen=True)
class SearchSettings:
    """Methods that the settings of both searches share."""

    def about(self) -> dict[str, Any]:
        """All fields."""
        return {each.name: getattr(self, each.name) for each in fields(self)}

    def check_least(self, **least: int) -> None:
        """Make sure that fields are not below a number."""
        for name, number in least.items():
            if getattr(self, name) < number:
                raise InputError(f"{name} is {getattr(self, name)}; allowed: {number} or more")


@dataclass(frozen=True, kw_only=True)
class Refinement(SearchSettings):
    """Settings of the search by CMA-ES for offsets of a maneuver's targets."""

    refine: str = option("Maneuver (name or file) whose targets are varied.", "M")
    cohort: str = option("Population of the patients.", "NAME", "trismus")
    control: Control = option("force, trajectory or targets.", "NAME", DEFAULT_CONTROL)
    horizon_s: float = option("Length of an episode.", "S", 10.0)
    criterion: Criterion = option("worst (the largest sd), D (determinant) or A (trace).", default="worst")
    """Of the covariance: log of the largest sd, log-determinant over twice the number of parameters, or half the log
    of the mean variance.
    """
    over: Over = option("mean of the patients, tail (the worst third) or nominal.", default="mean")
    """The nominal patient has the medians of the cohort."""
    patients: int = option("Patients that each candidate is played with.", "N", 12)
    generations: int = option("Generations of CMA-ES.", "N", 120)
    population: int = option("Candidates in a generation.", "N", 14)
    sigma: float = option("First step size of the offsets.", default=0.12)
    seed: int = option("Of the search.", "N", 0)
    env: str = option("Environment: Jaw, JawImaged, ...", "NAME", "Jaw")

    def __post_init__(self) -> None:
        """Check every field."""
        for name, kind in {"criterion": Criterion, "over": Over}.items():
            if getattr(self, name) not in get_args(kind):
                raise InputError(f"{name} is {shown(getattr(self, name))}; allowed: {', '.join(get_args(kind))}")
        self.check_least(patients=1, generations=1, population=4, seed=0)
        if self.population * self.patients > MOST_WORLDS:
            size = f"population is {self.population} and patients {self.patients}"
            raise InputError(f"{size}; allowed: {MOST_WORLDS:,} worlds, population times patients, at most")
        if not 0.0 < self.sigma <= 1.0:
            raise InputError(f"sigma is {self.sigma:g}; allowed: above 0, at most 1")
        configure(self.env_kwargs | {"model": model_of_env(self.env).name})
        self.maneuver()

    @property
    def env_kwargs(self) -> dict[str, Any]:
        """Arguments of the environment."""
        return {"control": self.control, "cohort": self.cohort, "episode_s": self.horizon_s}

    def maneuver(self) -> Maneuver:
        """The one that is refined."""
        from jawenv.playing.maneuvers import Maneuver, maneuver_names

        return Maneuver.named(self.refine) if self.refine in maneuver_names() else Maneuver.load(self.refine)


@dataclass(frozen=True, kw_only=True)
class GradientSearch(SearchSettings):
    """Settings of the search by the twin's gradient."""

    refine: str = option("Maneuver (name or file) where the search begins.", "M")
    cohort: str = option("Population of the patients.", "NAME", "trismus")
    updates: int = option("Of the targets.", "N", 80)
    patients: int = option("New ones in each update.", "N", 64)
    horizon_s: float = option("Length of the maneuver.", "S", 10.0)

    def __post_init__(self) -> None:
        """Check the numbers."""
        self.check_least(updates=1, patients=1)
        if not self.horizon_s > 0.0:
            raise InputError(f"horizon_s is {self.horizon_s}; allowed: more than 0")
