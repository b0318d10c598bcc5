"""The planners that come with the project, by name, and the search of those that look far ahead.

It is an evolution strategy (Beyer & Schwefel 2002, Natural Computing 1:3) with weighted recombination and steps that
shrink, about the plan that was made last and what maneuvers would do next. Most random changes of eight targets ahead
on four channels make a good plan worse; the best of a hundred of them is hardly better, the mean of the better quarter
is: small gains of many candidates add up.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from agents.planning import SPREAD, Plan, Planner, approach
from jawenv.controls import DEFAULT_CONTROL, Control
from jawenv.device.channels import HIGHEST, LOWEST, N_CHANNELS
from jawenv.errors import InputError
from jawenv.playing.protocol import Array, Mask

SIZE = 0.5
"""First step, as a share of ``SPREAD``."""
SHRINKS = 0.8  # a step, from round to round


class EvolvingPlanner(Planner):
    """A ``Planner`` with another search.

    Candidates are the mean, the continuation of each maneuver (in the first round) and variations of the mean in pairs,
    one as far on one side of it as the other on the other. The mean goes to the elites' weighted mean. The best of all
    candidates is played.

    Raises:
        InputError: another control mode than targets, or a plan without a maneuver.
    """

    knot_s = 0.5

    def __init__(self, plan: Plan, *, control: Control = DEFAULT_CONTROL) -> None:
        super().__init__(plan, control=control)
        if not plan.maneuvers:
            raise InputError(f"agent {plan.name!r}: maneuvers is (); allowed: one or more")

    def _search(self, step: Array, due: Mask) -> None:
        """Plan anew for the worlds that are due."""
        number, plan, shape = len(due), self.plan, (self._horizon, N_CHANNELS)
        streams, keys = self._chance(step)
        mean, tried = np.zeros((number, *shape)), np.zeros((number, plan.candidates, *shape))
        best, best_score = self._planned.copy(), np.full(number, -np.inf)
        weights = np.log(plan.elites + 0.5) - np.log(np.arange(1, plan.elites + 1))
        weights /= weights.sum()
        for k in range(plan.rounds):
            for i in np.flatnonzero(due):
                fixed = mean[i : i + 1]
                if k == 0:
                    start = self._env.simulation.targets[i]
                    fixed = np.array(self._known(start, int(i), int(step[i])))
                    mean[i] = fixed[0]
                pairs = self._pairs(mean[i], plan.candidates - len(fixed), SIZE * SHRINKS**k, streams[i])
                tried[i] = np.concatenate([fixed, pairs])
            score = self._judge(tried, due, keys)
            for i in np.flatnonzero(due):
                order = np.argsort(-score[i], kind="stable")
                if score[i, order[0]] > best_score[i]:
                    best[i], best_score[i] = tried[i, order[0]], score[i, order[0]]
                mean[i] = np.tensordot(weights, tried[i, order[: plan.elites]], axes=1)
        self._planned[due] = best[due]
        self._planned_at[due] = step[due]

    def _known(self, start: Array, world: int, step: int) -> list[Array]:
        """First candidates (H, 4): the last plan, with a maneuver after its end, and the maneuvers."""
        continued = self._continued(start, step)
        if not 0 <= self._planned_at[world] < step:
            return continued
        left = self._planned[world, min(step - self._planned_at[world], self._horizon) :]
        end = left[-1] if len(left) else start
        ahead = np.arange(1, self._horizon - len(left) + 1) / self._hz
        after = self._maneuvers[0].targets((step + len(left)) / self._hz + ahead).value
        return [np.concatenate([left, approach(end, after, ahead)]), *continued]

    def _pairs(self, mean: Array, number: int, size: float, stream: np.random.Generator) -> Array:
        """Variations (number, H, 4) of a mean (H, 4), within the limits of the device."""
        noise = size * SPREAD * stream.standard_normal(((number + 1) // 2, len(self._knots), N_CHANNELS))
        moved = np.einsum("hk,ckj->chj", self._between, np.concatenate([noise, -noise])[:number])
        within: Array = np.clip(mean + moved, np.array(LOWEST), HIGHEST)
        return within


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
    {named.plan.name: named for named in (_MYOPIC, _RECEDING, _clairvoyant(_MYOPIC), _clairvoyant(_RECEDING))}
)
"""Each by its name."""
