"""Entries with and without a kept budget of discomfort, in every cohort: docs/tables/kept_budget.md.

    python -m research.kept_budget --patients 200 > docs/tables/kept_budget.md

Ten seconds in targets control, patients of reports. The log of the worst error bar, and of the root mean square error,
stands beside `refined_one_sided` without a budget on the same patients; *loss* beside the entry itself without one.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from functools import cache
from typing import Any, NamedTuple

import numpy as np

import jawenv
from agents.registry import load_agent
from eval.figures import statistics, words
from eval.rows.outcomes import verdicts_s
from jawenv.anatomy import COHORTS
from jawenv.base.seeds import REPORTS
from jawenv.metrics import time_to
from jawenv.playing.agents import Array
from jawenv.playing.policies.named import agent_names

_SECONDS, _BUDGET_S, _SURE = 10.0, 1.0 / 30.0, 0.05
_BESIDE = "refined_one_sided"
_HEADINGS = (
    "entry",
    "log worst beside",
    "true error",
    "loss",
    "above, %, free → kept",
    "s to 5 %",
    "nine in ten",
    "s to verdicts",
    "NEES/12",
)


class _Played(NamedTuple):
    """An entry's episodes with N patients."""

    log_worst: Array  # (N,) of the error bars at the end
    log_error: Array  # (N,) of the root mean square error
    nees: Array  # (N,) over the parameters
    discomfort_s: Array  # (N,)
    sure_s: Array  # (N,) until all error bars are within ``SURE``, at most ``SECONDS``
    verdicts_s: Array  # (N,) until the data have a verdict on every muscle, at most ``SECONDS``


@cache
def _played(entry: str, cohort: str, env_id: str, budget_s: float | None, patients: int) -> _Played:
    """The episodes of an entry."""
    arguments: dict[str, Any] = {"cohort": cohort, "episode_s": _SECONDS, "track_bound": False}
    arguments |= {"control": "targets", "comfort_budget_s": budget_s}
    agent = load_agent(entry, env_id=env_id)
    recording = jawenv.play(agent, patients=patients, seed=REPORTS[1].start, env_kwargs=arguments, env_id=env_id)
    sd, error = recording.belief_sd, recording.belief_mean[:, -1] - recording.truth
    sure = np.minimum(time_to(sd, recording.time, _SURE, recording.counts), _SECONDS)
    solved = np.linalg.solve(recording.belief_cov[:, -1], error[..., None])[..., 0]
    return _Played(
        np.log(sd[:, -1].max(axis=1)),
        np.log(np.sqrt((error**2).mean(axis=1))),
        (error * solved).mean(axis=1),
        jawenv.score(recording).discomfort_s,
        sure,
        np.minimum(verdicts_s(recording), _SECONDS),
    )


def _row(entry: str, cohort: str, env_id: str, patients: int) -> list[str]:
    """Cells of an entry in a cohort."""
    beside = _played(_BESIDE, cohort, env_id, None, patients)
    free, kept = (_played(entry, cohort, env_id, budget, patients) for budget in (None, _BUDGET_S))
    above = [f"{100.0 * np.mean(each.discomfort_s > _BUDGET_S):.0f}" for each in (free, kept)]
    return [
        f"`{entry}`",
        words.with_interval(statistics.mean(kept.log_worst - beside.log_worst), 3),
        f"{np.mean(kept.log_error - beside.log_error):+.2f}",
        f"{np.mean(kept.log_worst - free.log_worst):+.3f}",
        " → ".join(above),
        f"{kept.sure_s.mean():.2f}",
        f"{np.quantile(kept.sure_s, 0.9):.1f}",
        words.with_interval(statistics.mean(kept.verdicts_s), 2),
        f"{kept.nees.mean():.2f}",
    ]


def main(argv: Sequence[str] | None = None) -> None:
    """Print a table for each cohort."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("entries", nargs="*", metavar="ENTRY", help="all of the project by default")
    parser.add_argument("--patients", type=int, default=200, metavar="N")
    parser.add_argument("--cohorts", nargs="+", default=list(COHORTS), metavar="NAME")
    parser.add_argument("--env", default="jawenv/Jaw-v3", metavar="ID")
    asked = parser.parse_args(argv)
    entries = asked.entries or [name for name in agent_names() if not name.endswith(("_force", "_asked"))]
    for cohort in asked.cohorts:
        print(f"\n**{cohort}**, {asked.patients} patients\n")
        print(f"| {' | '.join(_HEADINGS)} |")
        print("|---|" + "--:|" * (len(_HEADINGS) - 1))
        for number, entry in enumerate(entries, 1):
            print(f"| {' | '.join(_row(entry, cohort, asked.env, asked.patients))} |", flush=True)
            print(f"{cohort}: {number} of {len(entries)} entries", file=sys.stderr)


if __name__ == "__main__":
    main()
