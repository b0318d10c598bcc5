"""The planners that come with the project, by name."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import NamedTuple

from agents.evolving import EvolvingPlanner
from agents.planning import Plan, Planner
from jawenv.controls import Control


class Named(NamedTuple):
    """How a planner that has a name plans, and its class.

    Attributes:
        plan: its settings.
        kind: its search.
    """

    plan: Plan
    kind: type[Planner]

    def planner(self, control: Control) -> Planner:
        """The planner.

        Raises:
            InputError: another control mode than targets.
        """
        return self.kind(self.plan, control=control)


_MYOPIC = Named(
    Plan(
        name="myopic",
        description="Of sampled targets for the next second, the one of the largest predicted gain less discomfort.",
        horizon_s=1.0,
        candidates=64,
    ),
    Planner,
)
_RECEDING = Named(
    Plan(
        name="receding_horizon",
        description="Evolves how a maneuver goes on over the next four seconds, for the largest predicted fall of the "
        "largest sds less discomfort; follows the first second.",
        horizon_s=4.0,
        candidates=24,
        rounds=4,
        elites=6,
        maneuvers=("refined_one_sided",),
        goal="worst",
    ),
    EvolvingPlanner,
)


def _clairvoyant(named: Named) -> Named:
    plan = replace(
        named.plan,
        name=f"clairvoyant_{named.plan.name}",
        description=f"No contestant: knows the true patient, a yardstick of what adapting can be worth. "
        f"{named.plan.description}",
        clairvoyant=True,
    )
    return Named(plan, named.kind)


PLANNERS: Mapping[str, Named] = MappingProxyType(
    {each.plan.name: each for each in (_MYOPIC, _RECEDING, _clairvoyant(_MYOPIC), _clairvoyant(_RECEDING))}
)
"""Each by its name."""
