"""Named populations of simulated patients, each with the prior that a filter starts from.

A cohort is defined once, as one or more equally likely groups of independent log-normal parameters, each
truncated at 2 sd. Its prior is computed from that definition: the mean and the sd of the draws. So

- the NEES of the 12 parameters at the prior is 12 on average: the prior is as honest as a normal one can be;
- truncation at 2 sd leaves 0.88 of a group's sd: 44 % of F_o where the group is said to have 50 %;
- in `one_sided` the truth is a mixture of two groups, which no normal prior can equal: mean and sd of each
  parameter match, the correlation of the muscles of a side, all stiff or none, is left out.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from types import MappingProxyType
from typing import Annotated, Any, cast

import numpy as np
from numpy.typing import NDArray
from pydantic import Field
from scipy.special import ndtr, ndtri

from jawenv.anatomy.muscles import MuscleSet, muscle_set
from jawenv.anatomy.patient import LARGEST_B, LARGEST_F_O_N, Patient
from jawenv.anatomy.prior import Prior, Stiffness
from jawenv.base.errors import InputError, not_among, shown
from jawenv.base.files import FILE_TYPES, InputModel, Number, Source, Text, instance_of, read_into, validate
from jawenv.base.numeric_fields import whole_number

Positive = Annotated[Number, Field(gt=0)]


class _StiffnessFields(InputModel):
    """The fields of `Stiffness`."""

    F_o_N: Positive
    F_o_sd: Positive
    b: Positive
    b_sd: Positive


class _GroupFields(InputModel):
    """Stiffness of every whole muscle on each side."""

    left: _StiffnessFields
    right: _StiffnessFields


class _CohortFields(InputModel):
    """Equally likely groups, and what tables call the cohort."""

    name: Text = Field(default="cohort", min_length=1)
    description: Text = ""
    basis: str = ""
    groups: list[_GroupFields] = Field(min_length=1)


__all__ = ["COHORTS", "TRUNCATION_SD", "Cohort", "cohort"]

TRUNCATION_SD = 2.0
"""No parameter is drawn further than this many sd from its median."""

LARGEST_SD = 1.5
"""Widest prior sd of the natural log of F_o and b; from wider ones the environments' filter does not start reliably."""

MOST_DRAWS = 200
"""Per patient of a sample that accepts only some."""

_TAIL = float(ndtr(-TRUNCATION_SD))

TRUNCATED_VARIANCE = 1.0 - 2.0 * TRUNCATION_SD * math.exp(-0.5 * TRUNCATION_SD**2) / (
    math.sqrt(2.0 * math.pi) * (1.0 - 2.0 * _TAIL)
)
"""Variance that truncation at so many sd leaves of 1."""


@dataclass(frozen=True, eq=False)
class Cohort:
    """A population of patients."""

    name: str
    """Name that the environment's argument `cohort` takes."""
    description: str
    """Who they are, for tables."""
    basis: str
    """Source of the numbers, with their grade."""
    groups: tuple[tuple[Stiffness, Stiffness], ...]
    """Equally likely groups, each (left, right) stiffness of every whole muscle on that side."""
    muscles: MuscleSet = field(default_factory=muscle_set, repr=False)
    """The muscles that its patients have; a line that stands for several whole muscles, or for a part of one, has
    that multiple of F_o.
    """
    mean: NDArray[np.float64] = field(init=False, repr=False)
    """(groups, p) mean of the natural-log parameters of each group, 12 by default."""
    sd: NDArray[np.float64] = field(init=False, repr=False)
    """(groups, p) their sd before truncation."""
    prior: Prior = field(init=False, repr=False)
    """The filter's prior."""

    def __post_init__(self) -> None:
        """Arrays and prior follow from the groups.

        Raises:
            InputError: no group, one that is no pair of `Stiffness`, or patients whom no `Patient` can describe.
        """
        self._check_groups()
        rows = [[self._muscle_stiffness(name, group) for name in self.muscles.names] for group in self.groups]
        mean = np.array([[value for stiffness in row for value in stiffness.log_mean()] for row in rows])
        sd = np.array([[value for stiffness in row for value in stiffness.log_sd()] for row in rows])
        mean.setflags(write=False)
        sd.setflags(write=False)
        variance = TRUNCATED_VARIANCE * np.mean(sd**2, axis=0) + np.var(mean, axis=0)
        object.__setattr__(self, "mean", mean)
        object.__setattr__(self, "sd", sd)
        object.__setattr__(self, "prior", Prior(mean.mean(axis=0), np.sqrt(variance)))

    def _check_groups(self) -> None:
        pairs = isinstance(self.groups, tuple) and all(
            isinstance(group, tuple) and len(group) == 2 and all(isinstance(side, Stiffness) for side in group)
            for group in self.groups
        )
        if not pairs or not self.groups:
            raise InputError(
                f"cohort {self.name!r}: groups is {shown(self.groups)}; allowed: one or more pairs (left, right) of "
                "Stiffness, in tuples"
            )
        for stiffness in (self._muscle_stiffness(name, group) for group in self.groups for name in self.muscles.names):
            self._check_range("F_o_N", stiffness.F_o_N, stiffness.F_o_sd, LARGEST_F_O_N)
            self._check_range("b", stiffness.b, stiffness.b_sd, LARGEST_B)

    def _check_range(self, symbol: str, median: float, sd: float, largest: float) -> None:
        if sd > LARGEST_SD:
            raise InputError(
                f"cohort {self.name!r}: sd of log {symbol} = {sd:g}; allowed: more than 0, at most {LARGEST_SD:g}"
            )
        if math.log(median) + TRUNCATION_SD * sd > math.log(largest):
            raise InputError(
                f"cohort {self.name!r}: {symbol} = {median:g} with a log sd of {sd:g} is drawn larger than "
                f"{largest:g}; allowed: up to {largest:g} at {TRUNCATION_SD:g} sd above the median"
            )

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> Cohort:
        """A cohort from a mapping: `groups`, and if wanted `name`, `description` and `basis`.

        `groups` is a list of mappings with `left` and `right`, each a mapping of the fields of `Stiffness`.

        Raises:
            InputError: one line that names the field, the value and what is allowed.
        """
        content = validate(_CohortFields, data, cls.__name__)
        groups = tuple(
            (Stiffness(**group.left.model_dump()), Stiffness(**group.right.model_dump())) for group in content.groups
        )
        return cls(content.name, content.description, content.basis, groups)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Cohort:
        """Read a cohort from a JSON, TOML or YAML file, as `from_dict` takes it.

        Raises:
            InputError: one line that names the file and what is wrong with it.
        """
        return read_into(path, cls.from_dict)

    def to_dict(self) -> dict[str, Any]:
        """The mapping that `from_dict` takes, of text and numbers alone."""
        groups = [{"left": asdict(left), "right": asdict(right)} for left, right in self.groups]
        return {"name": self.name, "description": self.description, "basis": self.basis, "groups": groups}

    def __eq__(self, other: object) -> bool:
        """Whether the same patients are drawn, under the same name."""
        alike = isinstance(other, Cohort) and self.muscles.parameter_names == other.muscles.parameter_names
        return alike and self.to_dict() == cast(Cohort, other).to_dict()

    def __hash__(self) -> int:
        """Hash of name and numbers."""
        return hash((self.name, repr(self.groups)))

    def __reduce__(self) -> tuple[Any, ...]:
        """Rebuild through the constructor: plain unpickling would leave the arrays writable."""
        return Cohort, (self.name, self.description, self.basis, self.groups, self.muscles)

    def _muscle_stiffness(self, name: str, group: tuple[Stiffness, Stiffness]) -> Stiffness:
        """Stiffness of a muscle: the muscles of a side are alike, one of the sagittal plane is both sides' together."""
        left, right = group
        side = name.rsplit("_", 1)[-1]
        stiffness = {"left": left, "right": right}.get(side) or left.together(right)
        return stiffness.times(self.muscles.whole_muscles_per_line)

    @property
    def typical(self) -> NDArray[np.float64]:
        """(p,) natural-log parameters by which it is decided what of an anatomy matters."""
        return self.prior.mean

    def draw_log_parameters(self, rng: np.random.Generator) -> NDArray[np.float64]:
        """Natural-log parameters of one patient, (p,) in the order of `muscles.parameter_names`."""
        group = int(rng.integers(len(self.groups))) if len(self.groups) > 1 else 0
        # Inverse of the truncated normal's distribution function: exact, and no redraws.
        standard = ndtri(_TAIL + (1.0 - 2.0 * _TAIL) * rng.random(self.mean.shape[1]))
        drawn: NDArray[np.float64] = self.mean[group] + self.sd[group] * standard
        return drawn

    def draw(self, rng: np.random.Generator) -> Patient:
        """One patient, head upright."""
        return Patient.from_log_parameters(self.draw_log_parameters(rng), name=self.name, muscles=self.muscles.names)

    def sample(
        self, n: int, seed: int, *, accept: Callable[[NDArray[np.float64]], NDArray[np.bool_]] | None = None
    ) -> NDArray[np.float64]:
        """Natural-log parameters of ``n`` patients, the first rows of any larger sample with the same seed.

        Args:
            n: 0 or more.
            seed: 0 or more; other random numbers than those of an environment with this seed.
            accept: says of (m, p) parameters who is kept, (m,) bool, as ``jawenv.treatable`` does; whoever is not is
                drawn again, so that the sample is of the cohort's law under this condition. None keeps all.

        Returns:
            (n, p) in the order of ``muscles.parameter_names``.

        Raises:
            InputError: ``n`` or ``seed`` is out of range, or hardly anybody is accepted.
        """
        for name, value in (("n", n), ("seed", seed)):
            number = whole_number(value)
            if number is None or number < 0:
                raise InputError(f"{name} is {shown(value)}; allowed: a whole number, 0 or more")
        rng = np.random.default_rng(seed)
        accepted, drawn, missing = [np.empty((0, self.mean.shape[1]))], 0, int(n)
        while missing > 0:
            if drawn > MOST_DRAWS * n:
                raise InputError(f"cohort {self.name!r}: fewer than one in {MOST_DRAWS} patients is accepted")
            rows = np.array([self.draw_log_parameters(rng) for _ in range(missing)])
            drawn += missing
            accepted.append(rows if accept is None else rows[accept(rows)])
            missing -= len(accepted[-1])
        return np.concatenate(accepted)


_HEALTHY = Stiffness(F_o_N=0.7, F_o_sd=0.3, b=7.0, b_sd=0.3)
_TRISMUS = Stiffness(F_o_N=4.0, F_o_sd=0.4, b=10.0, b_sd=0.3)
_SEVERE = Stiffness(F_o_N=10.0, F_o_sd=0.3, b=10.0, b_sd=0.3)
_BLOCKAGE = Stiffness(F_o_N=0.8, F_o_sd=0.3, b=18.0, b_sd=0.3)
_PATCHY = Stiffness(F_o_N=2.7, F_o_sd=0.9, b=8.5, b_sd=0.35)

COHORTS: Mapping[str, Cohort] = MappingProxyType(
    {
        c.name: c
        for c in (
            Cohort(
                "trismus",
                "all closing muscles stiff: 24 mm open under 20 N, 35 mm under 40 N",
                "F_o 1.8-8.9 N: 2-9 N make 15-35 mm of opening under 20-40 N (D/G) of the limit of trismus, 35 mm "
                "(Dijkstra 2006, M); b 5.5-18 around the 9-20 of the jaw's passive law through fibres (D/R)",
                ((_TRISMUS, _TRISMUS),),
            ),
            Cohort(
                "healthy",
                "healthy closing muscles: rests 2 to 4 mm open, opens 45 mm under less than 20 N",
                "F_o 0.38-1.3 N: shear waves in 140 masseters make b F_o = 7.3 N (10.67 kPa, sd 1.77; M/D), 0.0014 of "
                "the muscles' largest force 0.05-0.45 N (D/R); b 3.8-12.8 around the 6-8 of the passive law (R)",
                ((_HEALTHY, _HEALTHY),),
            ),
            Cohort(
                "severe",
                "all closing muscles very stiff: at most 20 mm open under 40 N",
                "F_o 5.5-18 N: what 20 mm of opening under 40 N, severe trismus (van der Geer 2019, M), needs (D/G)",
                ((_SEVERE, _SEVERE),),
            ),
            Cohort(
                "one_sided",
                "the closing muscles of one side, left or right, stiff as in trismus, the others healthy",
                "the numbers of trismus and healthy; the sides equally likely (G)",
                ((_TRISMUS, _HEALTHY), (_HEALTHY, _TRISMUS)),
            ),
            Cohort(
                "patchy",
                "each muscle anything from healthy to very stiff",
                "F_o 0.45-16 N and b 4.2-17 span healthy to severe (G)",
                ((_PATCHY, _PATCHY),),
            ),
            Cohort(
                "blockage",
                "only the exponent b is raised: soft near closing, suddenly stiff when opened",
                "b 9.9-32.8: 18 makes 29 mm of opening under 20 N and 35 mm under 40 N (D/G); F_o "
                "0.44-1.5 N as the healthy",
                ((_BLOCKAGE, _BLOCKAGE),),
            ),
            Cohort(
                "wide",
                "the medians of trismus, twice its spread, and a filter that knows as little",
                "F_o 0.81-20 N and b 3.0-33 span healthy to severe (G)",
                ((_TRISMUS.widened(2.0), _TRISMUS.widened(2.0)),),
            ),
            Cohort(
                "anyone",
                "a person of whom nothing is known: healthy, trismus, severe, one side, patchy or blockage",
                "F_o 0.38-18 N and b 3.8-33: a sixth of each of the other cohorts but wide, the sides equally likely. "
                "No source counts the patients of such a device (G)",
                2
                * (
                    (_HEALTHY, _HEALTHY),
                    (_TRISMUS, _TRISMUS),
                    (_SEVERE, _SEVERE),
                    (_PATCHY, _PATCHY),
                    (_BLOCKAGE, _BLOCKAGE),
                )
                + ((_TRISMUS, _HEALTHY), (_HEALTHY, _TRISMUS)),
            ),
        )
    }
)
"""Every cohort by its name."""


def cohort(source: str | Cohort | Source, muscles: MuscleSet | None = None) -> Cohort:
    """A cohort by its name in `COHORTS`, or given as itself, as a mapping or as the path of a file.

    Args:
        source: a text that ends as a JSON, TOML or YAML file does is a path; see `Cohort.from_dict` for mappings.
        muscles: those of its patients; the six whole muscles, or a given cohort's own, by default.

    Raises:
        InputError: an unknown name (the message lists the known ones), or what `Cohort` refuses.
    """
    if isinstance(source, str) and Path(source).suffix.lower() not in FILE_TYPES:
        if source not in COHORTS:
            raise not_among("cohort", source, COHORTS, f", or a file ({', '.join(FILE_TYPES)})")
        chosen = COHORTS[source]
    elif isinstance(source, Cohort | Mapping | str | os.PathLike):
        chosen = instance_of(Cohort, source, "cohort")
    else:
        raise InputError(f"cohort is {shown(source)}; allowed: a name, a Cohort, a mapping of its fields, or a file")
    return chosen if muscles is None else replace(chosen, muscles=muscles)
