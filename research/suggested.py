"""Worth of ``jawenv suggest``: ten seconds of `slow_opening`, then ten of what it suggests or of other movements.

    python -m research.suggested --patients 200 > docs/tables/suggested.md

The filter is told that the patient is anyone. Informations of both recordings are added. *Another's*: the movement
that was suggested for the next patient. *Expected*: the largest error bar for patients drawn from the first belief,
median over the draws, beside what came. Budget: 0.033 s of discomfort, for every second movement.
"""

from __future__ import annotations

import argparse
from typing import Any, NamedTuple

import numpy as np

import jawenv
from agents.replay import Replay
from eval.figures import statistics, words
from jawenv.anatomy import Patient, cohort
from jawenv.base.seeds import REPORTS
from jawenv.playing.agents import Array
from jawenv.suggesting.search import searched_actions
from jawenv.suggesting.suggestion import drawn_from, seeds_of, suggested_actions

_FIRST, _OTHERS, _DRAWS = "slow_opening", ("refined_one_sided", "slow_opening"), 8
_ANOTHER, _SEARCHED, _BUDGET_S = "another's", "suggested after the search", 1.0 / 30.0
_COHORTS = ("one_sided", "patchy", "trismus")
_HEADINGS = (
    "second movement",
    "worst beside `refined`",
    "beside `refined_one_sided`",
    "NEES/12",
    "discomfort, s",
    "above, %",
)


class _Belief(NamedTuple):
    """Beliefs of N patients."""

    mean: Array  # (N, p)
    precision: Array  # (N, p, p)

    @property
    def log_worst(self) -> Array:
        """Log of the largest error bar (N,)."""
        largest: Array = np.diagonal(np.linalg.inv(self.precision), axis1=1, axis2=2).max(axis=1)
        return 0.5 * np.log(largest)

    def nees(self, truth: Array) -> float:
        """Mean NEES over the number of parameters."""
        error = self.mean - truth
        return float(np.einsum("ni,nij,nj->n", error, self.precision, error).mean() / truth.shape[1])


class _Played(NamedTuple):
    """Episodes of N patients."""

    belief: _Belief  # with what the prior says
    prior: _Belief
    discomfort_s: Array  # (N,)


def _play(agent: Any, patients: list[Any], seed: int, world: dict[str, Any]) -> _Played:
    recording = jawenv.play(agent, patients=patients, seed=seeds_of(patients, world, seed), env_kwargs=world)
    precision: Array = np.linalg.inv(recording.belief_cov[:, -1]).astype(np.float64)
    prior = _Belief(recording.prior_mean + np.zeros_like(recording.truth), np.diag(recording.prior_sd**-2.0)[None])
    return _Played(_Belief(recording.belief_mean[:, -1], precision), prior, jawenv.score(recording).discomfort_s)


def _added(first: _Played, second: _Played) -> _Belief:
    """The belief of both recordings: the prior counts once."""
    precision = first.belief.precision + second.belief.precision - first.prior.precision
    parts = ((first.belief, 1.0), (second.belief, 1.0), (first.prior, -1.0))
    score = sum(sign * np.einsum("nij,nj->ni", one.precision + 0.0 * precision, one.mean) for one, sign in parts)
    return _Belief(np.linalg.solve(precision, score[..., None])[..., 0], precision)


def _movements(first: _Played, world: dict[str, Any], arguments: argparse.Namespace) -> dict[str, Any]:
    """Agents for the second recording, by the words of their rows."""
    actions = suggested_actions([Patient.from_log_parameters(mean) for mean in first.belief.mean], world)
    hz = actions.shape[1] / world["episode_s"]
    movements: dict[str, Any] = {each: jawenv.Player(each) for each in ("refined", *_OTHERS)}
    movements |= {"suggested": Replay("suggested", actions, hz)}
    movements |= {_ANOTHER: Replay(_ANOTHER, np.roll(actions, 1, axis=0), hz)}
    if arguments.search:
        rows = _drawn(first.belief, arguments.seed)
        patients = [Patient.from_log_parameters(row) for row in rows.reshape(-1, rows.shape[-1])]
        found = searched_actions(actions, patients, seeds_of(patients, world), *first.belief, world, arguments.search)
        movements |= {_SEARCHED: Replay(_SEARCHED, found, hz)}
    return movements


def _of_cohort(name: str, arguments: argparse.Namespace) -> None:
    number, seed = arguments.patients, arguments.seed
    world = {"cohort": "anyone", "control": "targets", "episode_s": 10.0, "track_bound": False}
    world |= {"knowledge": arguments.knowledge, "comfort_budget_s": _BUDGET_S}
    truth = cohort(name).sample(number, seed, accept=jawenv.treatable)
    drawn = [Patient.from_log_parameters(row) for row in truth]
    first = _play(jawenv.Player(_FIRST), drawn, seed, world)
    movements = _movements(first, world, arguments)
    played = {key: _play(agent, drawn, seed + 1000, world) for key, agent in movements.items()}
    added = {key: _added(first, one) for key, one in played.items()}
    told = f"{np.exp(first.belief.log_worst.mean()):.1%} (geometric mean), NEES/12 {first.belief.nees(truth):.2f}"
    print(
        f"\n**{name}**, {number} patients, {arguments.knowledge}: largest error bar after the first recording {told}.\n"
    )
    print(f"| {' | '.join(_HEADINGS)} |\n|---{'|--:' * (len(_HEADINGS) - 1)}|")
    for key, belief in added.items():
        ratios = [_ratio(belief, added[beside]) for beside in ("refined", "refined_one_sided")]
        cost = played[key].discomfort_s
        cells = (f"{belief.nees(truth):.2f}", f"{cost.mean():.3f}", f"{100.0 * np.mean(cost > _BUDGET_S):.0f}")
        print(f"| {key} | {' | '.join((*ratios, *cells))} |", flush=True)
    off = _expected(first, movements["suggested"], world, seed + 2000) - added["suggested"].log_worst
    within = np.mean(np.abs(np.exp(off) - 1.0) < 0.25)
    print(f"\nSuggested beside another's: {_ratio(added['suggested'], added[_ANOTHER])}.", end=" ")
    print(f"Expected over what came: {np.exp(off.mean()):.2f}, within 25 % for {within:.0%}.", flush=True)


def _ratio(one: _Belief, beside: _Belief) -> str:
    """Geometric mean of the ratio of the largest error bars, with its interval."""
    apart = one.log_worst - beside.log_worst
    of_logs = statistics.mean(apart)
    return words.with_interval(statistics.Interval(*np.exp([of_logs.value, of_logs.low, of_logs.high])), 3)


def _drawn(belief: _Belief, seed: int) -> Array:
    """Parameters (N, draws, p) that beliefs allow."""
    cov: Array = np.linalg.inv(belief.precision).astype(np.float64)
    return drawn_from(belief.mean, cov, _DRAWS, seed)


def _expected(first: _Played, agent: Replay, world: dict[str, Any], seed: int) -> Array:
    """Median (N,) over draws from the first belief of the log of the largest error bar after both recordings."""
    draws = []
    for k, rows in enumerate(_drawn(first.belief, seed).swapaxes(0, 1)):
        played = _play(agent, [Patient.from_log_parameters(row) for row in rows], seed + k, world)
        draws.append(_added(first, played).log_worst)
    return np.median(draws, axis=0)


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--patients", type=int, default=200, help="of a cohort (default: %(default)s)")
    parser.add_argument("--seed", type=int, default=REPORTS[1].start + 3000, help="of the first (default: %(default)s)")
    parser.add_argument("--search", type=int, default=0, help="updates of the search (default: %(default)s)")
    parser.add_argument("--knowledge", default="exact", help="exact or imaged (default: %(default)s)")
    parser.add_argument("--cohorts", nargs="+", default=_COHORTS, help="default: %(default)s")
    arguments = parser.parse_args()
    made = f"python -m research.suggested --patients {arguments.patients} --search {arguments.search}"
    print(f"# Worth of what is suggested\n\nMade by `{made} --knowledge {arguments.knowledge}`.")
    for name in arguments.cohorts:
        _of_cohort(name, arguments)


if __name__ == "__main__":
    main()
