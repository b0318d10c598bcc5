"""The answer of a force-opening log: the curve of force against opening, the total pull, and what stays unknown."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from jawenv.anatomy import MUSCLE_NAMES, Cohort
from jawenv.anatomy.cohorts import TRUNCATED_VARIANCE
from jawenv.recordings.stretcher.fit import N_UNKNOWN, Assumed, Fit, Solution
from jawenv.recordings.stretcher.log import StretchLog, Windows, windows
from jawenv.recordings.stretcher.statics import Statics

Array = NDArray[np.float64]

DRAWS, PRIOR_DRAWS = 160, 5
"""Number of the posterior's draws, and of the prior's for each of them."""
LEAST_SHARE = 0.9
"""Least share of draws that come to their minimum: more fail where the condyle runs over the crest."""
RARE, FAR_SDS = 1e-3, 3.5
"""Chance that an honest log fits worse; sds by which a draw may fit worse than draws do on average."""
OFF_TEETH_MM = 1.0
LEAST_WINDOWS = 6
SHARES = (1.0, 0.8)
"""Parts of the opening that are tried: at the end of it a condyle may run over the crest, where nothing is at rest."""
LIGHT = 0.01
"""Weight of a group below which none of its patients is drawn."""
GRID_MM = 5.0
HYSTERESIS_N = 0.5
HELD_MM = 2.0  # below the widest opening at the end of a log without a return
SIDES = {"left": "_left", "right": "_right"}


@dataclass(frozen=True, eq=False)
class Stretched:
    """The posterior of one log."""

    log: StretchLog
    cohort: Cohort
    assumed: Assumed
    theta: Array  # (D, 12) natural-log parameters, draws; none where nothing fits
    prior: Array  # (P, 12) the same before the log, of the groups of the cohort that explain it
    openings: Array  # (G,) mm, up to the opening that was reached
    forces: Array  # (D, G) N that hold the relaxed jaw there
    settled: float  # share of the draws that came to their minimum
    misfit: float  # chi-square of the best fit over the largest that is believed
    reached_mm: float  # opening up to which the log is explained
    hysteresis_N: float  # force while it opens less force while it closes, at the same openings

    @property
    def doubts(self) -> list[str]:
        """Why nothing is told; empty where the log is believed."""
        if self.misfit <= 1.0 and self.settled >= LEAST_SHARE:
            return []
        doubts = [f"no relaxed jaw of this cohort has such a curve: misfit {self.misfit:.3g}; allowed: 1"]
        if self.hysteresis_N > HYSTERESIS_N and self.log.opening.max() - self.log.opening[-1] < HELD_MM:
            doubts.append(
                f"the force falls by {self.hysteresis_N:.2g} N while the opening is held: muscles that relax; allowed: "
                "an opening alone, so cut the log where it stops"
            )
        elif self.hysteresis_N > HYSTERESIS_N:
            doubts.append(
                f"at the same openings the return takes {self.hysteresis_N:.2g} N less than the opening: muscles that "
                "creep, or a jaw that yields; allowed: the same force on both ways"
            )
        return doubts

    @property
    def believed(self) -> bool:
        """Whether the log tells anything."""
        return not self.doubts


def stretched(
    log: StretchLog, cohort: Cohort, assumed: Assumed | None = None, *, draws: int = DRAWS, seed: int = 0
) -> Stretched:
    """Identify a jaw from a log of force and opening.

    Args:
        log: of one slow opening, and of the return too where it is there.
        cohort: of whole muscles; each of its groups is a prior of its own, weighed by how well it explains the log.
        assumed: sds within which all but the muscles is known.
        draws: of the posterior.
        seed: of the draws.
    """
    assumed, statics, whole = assumed or Assumed(), Statics(log.head_tilt_deg), _off_the_teeth(windows(log))
    hysteresis, found = _hysteresis(whole), []
    for share in SHARES if hysteresis < HYSTERESIS_N else SHARES[:1]:
        seen, rng = whole[whole.opening <= share * whole.opening.max()], np.random.default_rng(seed)
        theta, prior, misfit = _posterior(statics, seen, cohort, assumed, draws, rng)
        reached = float(seen.opening.max())
        openings = np.arange(min(GRID_MM, np.floor(reached)), reached, GRID_MM)
        forces = np.array([statics.forces(row, openings) for row in theta]).reshape(len(theta), len(openings))
        found.append(
            Stretched(
                log, cohort, assumed, theta, prior, openings, forces, len(theta) / draws, misfit, reached, hysteresis
            )
        )
        if found[-1].believed:
            return found[-1]
    return found[0]


def _posterior(
    statics: Statics, seen: Windows, cohort: Cohort, assumed: Assumed, draws: int, rng: np.random.Generator
) -> tuple[Array, Array, float]:
    """Draws of the parameters after and before the log (D, 12), and the misfit; none where it is above 1."""
    fits, modes, weights = _explained(statics, seen, cohort, assumed, rng)
    best = min((float(mode.cost[0]) for mode in modes), default=np.inf)
    number = len(seen.opening)
    misfit = 2.0 * best / float(chi2.isf(RARE, number)) if number >= LEAST_WINDOWS else np.inf
    counts = rng.multinomial(draws, weights) if misfit <= 1.0 else np.zeros(len(fits), dtype=np.int64)
    before, after = [np.empty((0, len(cohort.prior.mean)))], [np.empty((0, len(cohort.prior.mean)))]
    for fit, mode, count in zip(fits, modes, counts, strict=True):
        if count:
            before.append(fit.theta(rng.standard_normal((PRIOR_DRAWS * count, N_UNKNOWN))))
            found = fit.draws(mode, int(count), rng)
            after.append(fit.theta(found.z[found.cost < _largest_cost(mode.cost[0], number)]))
    return np.concatenate(after), np.concatenate(before), misfit


def _largest_cost(best: float, number: int) -> float:
    """The largest cost of a draw that has come to its minimum, where the unperturbed problem has the cost ``best``.

    Of a linear model 2 cost = |r + P e|^2 with |r|^2 = 2 best and ``number`` standard normals P e.
    """
    return best + 0.5 * number + 0.5 * FAR_SDS * float(np.sqrt(8.0 * best + 2.0 * number))


def _off_the_teeth(seen: Windows) -> Windows:
    """Windows of an open jaw: without those on the teeth and their neighbours, in which it lifts off."""
    closed = np.pad(seen.opening <= seen.opening.min() + OFF_TEETH_MM, 1)
    return seen[~(closed[:-2] | closed[1:-1] | closed[2:])]


def _explained(
    statics: Statics, seen: Windows, cohort: Cohort, assumed: Assumed, rng: np.random.Generator
) -> tuple[list[Fit], list[Solution], Array]:
    """Problem and modes of each group of a cohort that has patients who open so far, and the groups' weights."""
    groups, counts = np.unique(np.stack([cohort.mean, cohort.sd], axis=1), axis=0, return_counts=True)
    fits, modes, logs = [], [], []
    for (mean, sd), count in zip(groups, counts, strict=True):
        fit = Fit(statics, seen, mean, TRUNCATED_VARIANCE**0.5 * sd, assumed)
        found = fit.modes(rng)
        if len(found.cost):
            fits.append(fit)
            modes.append(found)
            logs.append(np.log(count) + fit.log_evidence(found))
    weights = np.exp(np.array(logs) - max(logs, default=0.0))
    weights[weights < LIGHT * weights.sum()] = 0.0
    return fits, modes, weights / weights.sum() if len(weights) else weights


def _hysteresis(seen: Windows) -> float:
    """Mean excess of the force (N) while the mouth opens over that while it closes; 0 where one of the ways lacks."""
    ways = [(seen.opening[way], seen.force[way]) for way in (seen.loading, ~seen.loading)]
    if min(len(opening) for opening, _ in ways) < 2:
        return 0.0
    (up, up_force), (down, down_force) = ((o[np.argsort(o)], f[np.argsort(o)]) for o, f in ways)
    common = np.linspace(max(up[0], down[0]), min(up[-1], down[-1]), 10)
    return float(np.mean(np.interp(common, up, up_force) - np.interp(common, down, down_force)))


def pulls(theta: Array) -> dict[str, Array]:
    """Natural logs of pulls of the closed jaw (...): all muscles, left, right, and left over right."""
    F_o = np.exp(theta[..., ::2])
    of = {
        side: np.log(F_o[..., [name.endswith(end) for name in MUSCLE_NAMES]].sum(axis=-1))
        for side, end in SIDES.items()
    }
    return {"all": np.log(F_o.sum(axis=-1)), **of, "left : right": of["left"] - of["right"]}
