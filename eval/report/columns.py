"""The columns of the report's tables: figures of the catalogue below their headings, in groups."""

from __future__ import annotations

from typing import NamedTuple

from eval.comparison.ranking import DIFFERENCE, KNOWN, SOON, Ranking
from eval.figures import words
from eval.figures.catalogue import FIGURES, SIGMAS, Figure, reaches

_LONGEST = 16
"""Characters of a name in a heading; of a longer one the first ten."""


class Column(NamedTuple):
    """One figure of every row."""

    figure: str  # its name
    heading: str  # in lines
    digits: int  # behind the point
    scale: float  # factor
    best: str  # what stands first where it is sorted: `most`, or what is nearest to a number, or if empty the least


class Group(NamedTuple):
    """Columns that belong together."""

    title: str  # empty for none
    columns: tuple[Column, ...]


def tables_of(ranking: Ranking) -> dict[str, list[Group]]:
    """The columns of each table.

    Args:
        ranking: of the study.
    """
    parameters, name = ranking.n_parameters, words.label(ranking.reference)
    reference = name if len(name) <= _LONGEST else f"{name[:10]}…"
    worst = f"worst {'of those asked for' if ranking.asked else f'of the {parameters}'} sd, %"

    def column(name: str, heading: str = "", digits: int | None = None) -> Column:
        figure = FIGURES[name]
        shown = heading or figure.narrow.format(parameters=parameters)
        return Column(name, shown, figure.digits if digits is None else digits, figure.scale, _best(figure, parameters))

    def group(title: str, *columns: Column) -> Group:
        return Group(title, columns)

    return {
        "ranking": [
            group(
                f"{ranking.sought} within {100.0 * KNOWN:g} %",
                column(SOON, "median\ns"),
                column(f"{SOON}_p90", "90 % of\npatients, s"),
                column(reaches(KNOWN), "share\n%", 0),
            ),
            group(
                "true information, nats",
                column("information_true", "mean"),
                Column(DIFFERENCE, f"against\n{reference}", 1, 1.0, "most"),
            ),
            group(worst, column("worst_sd", "median", 1), column("worst_sd_p90", "90 % of\npatients", 1)),
            group(
                "can it be believed?", column("nees"), column("honesty_gap", "claimed −\ntrue, nats"), column("rings")
            ),
            group("patient", column("discomfort_rate"), column("violated")),
        ],
        "comfort": [
            group(
                "in all",
                column("discomfort_rate", digits=3),
                column("violated", "crosses a hard\nlimit, %"),
                column("governor", "governor\nacts, %"),
            )
        ],
        "honesty": [
            group("", column("nees", f"NEES\n(calibrated: {parameters})"), column("identified")),
            group("", *(column(f"inside_{sigmas}_sigma", f"within\n{sigmas} sd, %") for sigmas in SIGMAS)),
            group(
                "",
                column("information_claimed", "claimed\nnats"),
                column("information_true", "true\nnats"),
                *([column("information_bound", "bound\nnats")] if ranking.has_bound else []),
                column("honesty_gap", "claimed −\ntrue"),
            ),
            group("", *([column("rmse_over_bound")] if ranking.has_bound else [])),
        ],
    }


def _best(figure: Figure, parameters: int) -> str:
    """What is best of a figure: of the NEES, which has no better direction, the number of parameters."""
    if figure.better in ("higher", "lower"):
        return "most" if figure.better == "higher" else ""
    return f"{parameters if figure.better is None else figure.better:g}"
