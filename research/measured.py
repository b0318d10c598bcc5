"""Simulated jaws beside published measurements of people: the table of docs/measured.md.

    python -m research.measured

Openings and pulls are those of relaxed jaws under a slow vertical pull (``jawenv.mechanics.passive_opening``), of 30
patients of each cohort. Relaxed by a drug means: without tone, lying on the back.
"""

from __future__ import annotations

import argparse
from dataclasses import replace

import numpy as np

from jawenv.anatomy import COHORTS, Mandible, default_mandible
from jawenv.mechanics.passive_opening import passive_opening, pull_to_open

PEOPLE, SEED = 30, 5
ON_THE_BACK = -90.0
LOADS_N = (1.67, 4.32)
CHANGES = {"b × 1.5": (1.0, 1.5, 0.0), "F_o × 1.5": (1.5, 1.0, 0.0), "a tone of 0.1 N": (1.0, 1.0, 0.1)}
"""Name -> factor of F_o, factor of b, tone of each closer (N)."""


def _with_tone(tone_N: float = 0.0) -> Mandible:
    return replace(default_mandible(), closing_tone_N=tone_N)


def _shares_lost(change: str) -> np.ndarray:
    """Shares of the openings under ``LOADS_N`` that a stiffer healthy jaw loses, (2,)."""
    F_o, b, tone = CHANGES[change]
    before = COHORTS["healthy"].prior.mean
    after = before + np.tile(np.log([F_o, b]), len(before) // 2)
    opened = passive_opening(before, LOADS_N, mandible=_with_tone(), head_tilt_deg=ON_THE_BACK)
    stiffer = passive_opening(after, LOADS_N, mandible=_with_tone(tone), head_tilt_deg=ON_THE_BACK)
    lost: np.ndarray = 1.0 - stiffer / opened
    return lost


def _spread(values: np.ndarray) -> str:
    return f"{np.nanmean(values):.3g} ± {np.nanstd(values):.2g}"


def rows() -> list[tuple[str, str, str, str]]:
    """(what, simulated, measured, source)."""
    people = {name: cohort.sample(PEOPLE, seed=SEED) for name, cohort in COHORTS.items()}
    rest = passive_opening(people["healthy"], (0.0,))[:, 0]
    pulls = pull_to_open(people["healthy"], (20.0, 30.0, 40.0), mandible=_with_tone(), head_tilt_deg=ON_THE_BACK)
    own = {name: passive_opening(people[name], (32.0,))[:, 0] for name in ("trismus", "severe")}
    lost = "; ".join(f"{name}: {100 * a:.0f} and {100 * b:.0f} %" for name in CHANGES for a, b in [_shares_lost(name)])
    return [
        ("rest, healthy, mm", _spread(rest), "2 to 4", "textbooks (R)"),
        ("trismus: opening by 32 N, mm", _spread(own["trismus"]), "at most 35", "Dijkstra 2006 (M)"),
        ("severe trismus: opening by 32 N, mm", _spread(own["severe"]), "at most 20 to 25", "van der Geer 2019 (M)"),
        (
            "pull that opens relaxed adults by 20, 30, 40 mm, N",
            ", ".join(_spread(column) for column in pulls.T),
            "12.7 to 16.4, the opening is not stated",
            "Ummenhofer 1998, Can. J. Anaesth., abstract (M)",
        ),
        (
            "share of two openings, by 1.67 and 4.32 N, that stiffening takes",
            lost,
            "equal shares of both (children)",
            "van der Spek 1990, Br. J. Anaesth., abstract (M)",
        ),
    ]


def main() -> None:
    """Print the table in Markdown."""
    argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter).parse_args()
    print("| what | simulated, mean ± sd | measured | source (grade) |\n|---|---|---|---|")
    for row in rows():
        print("| " + " | ".join(row) + " |", flush=True)


if __name__ == "__main__":
    main()
