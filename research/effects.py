"""What effects that the filter does not know do to a belief, and to the change between two treatments.

    python -m research.effects --patients 48 --seed 20000

The effects are those of the study of robustness. The same patients are played twice, the second time with muscles that
have changed by a normal step of the natural logs, and with the same anatomy. What is asked of a course of treatments is
that change: the errors of both beliefs that are alike cancel in it.
"""

from __future__ import annotations

import argparse
from typing import Any

import numpy as np
from numpy.typing import NDArray

import jawenv
from agents import load_agent
from eval.studies import design
from jawenv.anatomy import Patient, cohort

Array = NDArray[np.float64]

STEP_SD = 0.1  # of the muscles' natural logs between two treatments
HEAD = (
    "| effect | alarm, % | NEES/12 | largest mean z | error of the belief, % | error of the change, % "
    "| change within its 95 % interval, % |\n|---|--:|--:|--:|--:|--:|--:|"
)


def drawn(name: str, number: int, seed: int) -> tuple[Array, Array]:
    """Natural-log parameters of patients that the device can treat, before and after: twice (n, p)."""
    rng = np.random.default_rng(seed)
    before = cohort(name).sample(number, seed, accept=jawenv.treatable)
    return before, before + STEP_SD * rng.standard_normal(before.shape)


def played(agent: str, theta: Array, anatomy: int, seed: int, kwargs: dict[str, Any]) -> Any:
    """The recording of patients with these parameters (n, p), the i-th with the anatomy of ``anatomy`` + i."""
    names = cohort(kwargs["cohort"]).muscles.names
    patients = [
        Patient.from_log_parameters(row, muscles=names).model_copy(update={"anatomy_seed": anatomy + i})
        for i, row in enumerate(theta)
    ]
    return jawenv.play(load_agent(agent, control="targets"), patients=patients, seed=seed, env_kwargs=kwargs)


def row(name: str, first: Any, second: Any) -> str:
    """A row of the table, of both treatments' recordings."""
    means = [play.belief_mean[:, -1] for play in (first, second)]
    covs = [play.belief_cov[:, -1] for play in (first, second)]
    error = means[1] - second.truth
    nees = np.einsum("ni,nij,nj->n", error, np.linalg.inv(covs[1]), error) / error.shape[1]
    sds = [np.sqrt(np.diagonal(cov, axis1=1, axis2=2)) for cov in covs]
    wrong = (means[1] - means[0]) - (second.truth - first.truth)
    inside = np.abs(wrong) < 1.96 * np.hypot(*sds)
    rings = np.nanmax(second.misfit, axis=1) > 1.0
    bias = np.abs((error / sds[1]).mean(axis=0)).max()
    figures = (
        f"{100.0 * rings.mean():.0f}",
        f"{nees.mean():.2f}",
        f"{bias:.2f}",
        f"{100.0 * np.sqrt(np.mean(error**2)):.1f}",
        f"{100.0 * np.sqrt(np.mean(wrong**2)):.1f}",
        f"{100.0 * inside.mean():.0f}",
    )
    return f"| {name} | " + " | ".join(figures) + " |"


def main() -> None:
    """Print the table, a row as soon as it is there."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--patients", type=int, default=48)
    parser.add_argument("--seed", type=int, default=20_000)
    parser.add_argument("--cohort", default="trismus")
    parser.add_argument("--agent", default="refined")
    parser.add_argument("--episode-s", type=float, default=30.0)
    options = parser.parse_args()
    before, after = drawn(options.cohort, options.patients, options.seed)
    print(HEAD)
    for name, effect in design.read("robustness")[1].reality.items():
        kwargs = {"cohort": options.cohort, "control": "targets", "episode_s": options.episode_s, "reality": effect}
        seed, later = options.seed, options.seed + options.patients
        first = played(options.agent, before, seed, seed, kwargs)
        second = played(options.agent, after, seed, later, kwargs)
        print(row(name, first, second), flush=True)


if __name__ == "__main__":
    main()
