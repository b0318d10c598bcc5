"""What a drive has reached on its patient, and what maneuvers reach on the same one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from jawenv.live.setup import Setup
from jawenv.metrics import score
from jawenv.playing.maneuvers import Maneuver, Player
from jawenv.playing.rollout import play

RIVALS = ("refined", "slow_opening")
KNOWN = (0.10, 0.05)
"""Standard deviations of natural logs below which a parameter counts as known."""
LARGEST_DISCOMFORT_S = 0.1  # in 30 s, as for the ranking of a comparison


@dataclass(frozen=True)
class Outcome:
    """What one drive of one patient has reached.

    Attributes:
        name: who drove.
        time_to_s: for each of ``KNOWN`` the time until all parameters were known so well; infinite if never.
        worst_sd: largest standard deviation at the end.
        discomfort_s: integral of the cost over time, s.
        duration_s: length of the drive.
        violated: whether a hard limit was crossed.
    """

    name: str
    time_to_s: tuple[float, float]
    worst_sd: float
    discomfort_s: float
    duration_s: float
    violated: bool

    @property
    def within_comfort(self) -> bool:
        """Whether a comparison would rank it."""
        return not self.violated and self.discomfort_s <= LARGEST_DISCOMFORT_S * max(self.duration_s, 1.0) / 30.0

    def line(self) -> str:
        """All of it in one line."""
        ten, five = (f"{time:.1f} s" if np.isfinite(time) else "never" for time in self.time_to_s)
        comfort = "" if self.within_comfort else ", not within comfort"
        return (
            f"{self.name.replace('_', ' ')}: all to 10 % {ten}, to 5 % {five}, worst sd {100 * self.worst_sd:.1f} %, "
            f"discomfort {self.discomfort_s:.2f} s{comfort}"
        )


def outcomes_of_rivals(setup: Setup, names: Sequence[str] = RIVALS) -> list[Outcome]:
    """What maneuvers that come with jawenv reach on the patient of a setup, with the same noise."""
    return [_played(setup, Maneuver.named(name)) for name in names]


def _played(setup: Setup, maneuver: Maneuver) -> Outcome:
    player = Player(maneuver, control=setup.control, control_hz=setup.control_hz)
    kwargs = setup.env_kwargs | {"track_bound": False, "record": False}
    reached = score(play(player, patients=1, seed=setup.seed, env_kwargs=kwargs, env_id=setup.env_id), targets=KNOWN)
    return Outcome(
        maneuver.name,
        (float(reached.time_to_s[KNOWN[0]][0]), float(reached.time_to_s[KNOWN[1]][0])),
        float(reached.worst_sd[0]),
        float(reached.discomfort_s[0]),
        float(reached.duration_s[0]),
        bool(reached.violated[0]),
    )
