"""One HTML file that shows a whole study; it needs no network and no other file."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from markupsafe import Markup

from eval.comparison.adaptation import adaptations
from eval.comparison.ranking import Ranking
from eval.comparison.results import EARLY_S, Results
from eval.report import drawing, figures, panels, template, verdict, words
from eval.report.template import picture
from eval.statistics import RESAMPLES
from jawenv.metrics import BLOCKED_B, CONFIDENCE, FIBROSED_F_O_N, whole_muscles_per_line


@dataclass(frozen=True)
class EntryFigure:
    """The parameters of one entry over time."""

    entry: str
    picture: Markup


def write(study: Results, ranking: Ranking, path: Path) -> Path:
    """Write the report.

    Args:
        study: results of all entries.
        ranking: of the same study.
        path: of the HTML file.

    Returns:
        The path.
    """
    return template.write(render(study, ranking), path)


def render(study: Results, ranking: Ranking) -> str:
    """The report as HTML text.

    Args:
        study: results of all entries.
        ranking: of the same study.
    """
    return template.render(
        "report.html.j2",
        ranking=ranking,
        adaptations=adaptations(study),
        early_s=EARLY_S,
        about=study.about,
        headline=verdict.headline(ranking),
        remarks=verdict.remarks(ranking),
        pictures=dict(_pictures(study, ranking)),
        entry_figures=list(_entry_figures(study, ranking)),
        muscles=[words.muscle(name) for name in ranking.parameters[::2]],
        sided=panels.sided(ranking.parameters),
        shrinks=1.0 - math.exp(-1.0 / ranking.n_parameters),
        fibrosed_F_o_N=FIBROSED_F_O_N * whole_muscles_per_line(ranking.parameters),
        blocked_b=BLOCKED_B,
        confidence=CONFIDENCE,
        resamples=RESAMPLES,
    )


def _pictures(study: Results, ranking: Ranking) -> Iterator[tuple[str, Markup]]:
    """Every figure that shows all entries, by its name."""
    drawn = {
        "overview": (figures.overview, "Information and worst standard deviation of every entry"),
        "differences": (figures.differences, "Paired differences of information"),
        "sd_over_time": (figures.sd_over_time, "Standard deviation of every parameter over time"),
        "time_to_target": (figures.time_to_target, "Share of patients that reach a target over time"),
        "calibration": (figures.calibration, "NEES, coverage and honesty gap"),
        "nees_over_time": (figures.nees_over_time, "Mean NEES over time"),
        "discomfort": (figures.discomfort, "Information against discomfort"),
    }
    for name, (draw, label) in drawn.items():
        yield name, picture(draw(study, ranking), name, label)


def _entry_figures(study: Results, ranking: Ranking) -> Iterator[EntryFigure]:
    colour = drawing.colours(ranking)
    for place, row in enumerate(ranking.rows, 1):
        drawn = figures.sd_of_entry(study, row.entry, colour[row.entry])
        label = f"Standard deviation of every parameter over time, {words.label(row.entry)}"
        yield EntryFigure(row.entry, picture(drawn, f"entry{place}", label))
