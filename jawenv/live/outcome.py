"""Outcomes of a drive and of maneuvers on the same patient."""

from __future__ import annotations

import contextlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from jawenv.base.errors import InputError
from jawenv.controls import takes_targets
from jawenv.live.setup import Setup
from jawenv.metrics import score
from jawenv.playing.agents import Agent
from jawenv.playing.maneuvers import Maneuver, Player
from jawenv.playing.policies.card import SHIPPED
from jawenv.playing.policies.plain import load_plain
from jawenv.playing.rollout import play

RIVALS = ("universal", "slow_opening")
LEARNED = ("apg_anyone", "ppo_trismus")
"""Policies of targets control that come with jawenv and play against the hand."""
KNOWN = (0.10, 0.05)
"""Standard deviations of natural logs below which a parameter counts as known."""
LARGEST_DISCOMFORT_S = 0.1  # in 30 s, as for the ranking of a comparison


@dataclass(frozen=True)
class DriveOutcome:
    """The outcome of one drive of one patient."""

    name: str  # who drove
    time_to_s: tuple[float, float]
    """For each of ``KNOWN`` the time until all parameters were known so well; infinite if never."""
    worst_sd: float  # largest standard deviation at the end
    discomfort_s: float  # integral of the cost over time, s
    duration_s: float  # length of the drive
    violated: bool  # whether a hard limit was crossed

    @property
    def within_comfort(self) -> bool:
        """Whether a comparison would rank it."""
        return not self.violated and self.discomfort_s <= LARGEST_DISCOMFORT_S * max(self.duration_s, 1.0) / 30.0


def learned_agents() -> dict[str, Agent]:
    """The policies of ``LEARNED``."""
    return {name: load_plain(SHIPPED / name) for name in LEARNED}


def outcomes_of_rivals(
    setup: Setup, agents: Mapping[str, Agent] | None = None, names: Sequence[str] = RIVALS
) -> list[DriveOutcome]:
    """Outcomes of shipped agents and maneuvers on the patient of a setup, with the same noise.

    Args:
        setup: whom, and how.
        agents: by name; in targets control they are played, deciding as often as there. Who refuses the setup is
            left out.
        names: of maneuvers.
    """
    able = dict(agents or {}) if takes_targets(setup.world.control) else {}
    control, hz = setup.world.control, setup.world.steps_per_s
    players = [Player(Maneuver.named(name), control=control, control_hz=hz) for name in names]
    of_agents = []
    for name, agent in able.items():
        with contextlib.suppress(InputError):
            of_agents.append(_played(setup, name, agent, None))
    return of_agents + [_played(setup, player.name, player, setup.world.steps_per_s) for player in players]


def _played(setup: Setup, name: str, player: Agent, control_hz: float | None) -> DriveOutcome:
    kwargs = setup.world.arguments | {"track_bound": False, "record": False, "control_hz": control_hz}
    reached = score(
        play(player, patients=1, seed=setup.seed, env_kwargs=kwargs, env_id=setup.world.env_id), targets=KNOWN
    )
    return DriveOutcome(
        name,
        (float(reached.time_to_s[KNOWN[0]][0]), float(reached.time_to_s[KNOWN[1]][0])),
        float(reached.worst_sd[0]),
        float(reached.discomfort_s[0]),
        float(reached.duration_s[0]),
        bool(reached.violated[0]),
    )
