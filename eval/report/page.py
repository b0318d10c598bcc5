"""One HTML file that shows a whole study and is explored in a browser; it needs no network and no other file.

plotly.js (basic bundle, MIT licence) lies under `assets/` as published on npm, and is written into the page once.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from markupsafe import Markup

from eval.comparison.admission import LARGEST_RINGING
from eval.comparison.ranking import Ranking, RankingRow
from eval.comparison.results import Results
from eval.comparison.trainings import adaptations, verdict
from eval.figures import words
from eval.figures.statistics import RESAMPLES
from eval.report import charts, films, first, marks, template
from eval.report.learned import learned, learning_charts
from eval.rows.outcomes import EARLY_S
from jawenv.anatomy.muscles import SIDES
from jawenv.metrics import CONFIDENCE, TARGETS

ASSETS = Path(__file__).parent / "assets"


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


CONSTANTS: Mapping[str, Any] = {
    "confidence": CONFIDENCE,
    "early_s": EARLY_S,
    "largest_ringing": LARGEST_RINGING,
    "least_sure": first.LEAST_SURE,
    "resamples": RESAMPLES,
    "targets": TARGETS,
    "terms": template.TERMS,
}


def render(study: Results, ranking: Ranking) -> str:
    """The report as HTML text.

    Args:
        study: results of all entries.
        ranking: of the same study.
    """
    lessons = learned(study, ranking)
    filmed = films.filmed(study, ranking, [row for lesson in lessons for row in (lesson.base, lesson.entry)])
    entries, (learning, notes) = marks.entries(ranking), learning_charts(study, ranking)
    titles = [words.parameter(name) for name in ranking.parameters]
    data: dict[str, Any] = {
        "entries": entries,
        "charts": charts.all_charts(study, ranking) | learning,
        "parameters": [{"key": key, "title": title} for key, title in zip(ranking.parameters, titles, strict=True)],
        "curves": charts.curves(study, ranking),
        "sd_range": charts.sd_range(study),
        "films": films.films(study, filmed),
        "speed": films.SPEED,
        "motions": {row.entry: charts.motion(study.motions[row.entry]) for row in filmed},
    }
    return template.render(
        "report.html.j2",
        about=study.about,
        ranking=ranking,
        constants=CONSTANTS,
        model=_model(ranking, titles),
        answer=_answer(study, ranking),
        films=_films(study, ranking, filmed),
        comfort={"limits": _limits(study), "use": _use_of_limits(study, ranking)},
        adaptations=adaptations(study),
        verdict=verdict,
        diagnoses={row.entry: study.diagnoses(row.entry) for row in ranking.rows},
        learning={
            "lessons": lessons,
            "charts": list(learning),
            "entries": _entries_in(learning, entries),
            "notes": notes,
        },
        embedded=_embedded(data),
    )


def _model(ranking: Ranking, titles: list[str]) -> dict[str, Any]:
    """The muscles and their parameters in words."""
    return {
        "muscles": [words.muscle(name) for name in ranking.parameters[::2]],
        "parameters": titles,
        "sided": any(name.endswith(SIDES) for name in ranking.parameters),
        "shrinks": 1.0 - math.exp(-1.0 / ranking.n_parameters),
    }


def _answer(study: Results, ranking: Ranking) -> dict[str, Any]:
    """The first screen."""
    longest_s, rest = float(study.patients["duration_s"].max()), first.rest(ranking)
    believed, because = first.belief(ranking)
    return {
        "sentence": first.answer(ranking),
        "assumption": first.assumption(study),
        "believed": believed,
        "because": because,
        "bars": [(row, first.bars(ranking, row, longest_s)) for row in first.firsts(ranking)],
        "bars_of_rest": [(row, first.bars(ranking, row, longest_s)) for row in rest],
        "rest": rest,
    }


def _films(study: Results, ranking: Ranking, filmed: list[RankingRow]) -> dict[str, Any]:
    """The films, and whose motion they show."""
    first_seed = study.about["settings"]["seed"]
    seed = study.about.get("played_seed", first_seed)
    return {
        "filmed": filmed,
        "beside": [("The best: " if row is ranking.best else "", row) for row in films.beside(study, ranking)],
        "longest_s": films.LONGEST_S,
        "speed": films.SPEED,
        "knowledge": films.colours(),
        "played": f"the {'first ' if seed == first_seed else ''}patient (seed {seed})",
    }


def _entries_in(traced: dict[str, marks.Chart], entries: list[dict[str, Any]]) -> list[str]:
    """Place and name of the entries that have a line in a chart."""
    numbers = dict.fromkeys(trace["meta"] for chart in traced.values() for trace in chart["data"])
    return [f"{entries[i]['place']} {entries[i]['name']}" for i in numbers]


def _embedded(data: dict[str, Any]) -> dict[str, Markup]:
    """Styles and scripts by the names of their files, and ``plotly`` and ``data``.

    JSON may stand inside a script element: no text in it can end the element.
    """
    text = json.dumps(data, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")
    own = [file for file in ASSETS.iterdir() if file.suffix in (".css", ".js") and "plotly" not in file.name]
    texts = {file.name: file.read_text(encoding="utf-8") for file in own}
    texts |= {"plotly": (ASSETS / "plotly-basic.min.js").read_text(encoding="utf-8"), "data": text}
    return {name: Markup(text) for name, text in texts.items()}  # noqa: S704  (ours)


def _limits(study: Results) -> list[str]:
    """Names of the comfort limits; none in results from before their columns."""
    return [name.removeprefix("used/") for name in map(str, study.patients) if name.startswith("used/")]


def _use_of_limits(study: Results, ranking: Ranking) -> dict[str, dict[str, dict[str, float]]]:
    """Largest use of every soft limit in any patient, and mean s beyond it, by entry and limit."""
    uses = {}
    for row in ranking.rows:
        table = study.of(row.entry)
        uses[row.entry] = {
            limit: {
                "largest": float(np.nanmax(table[f"used/{limit}"])),
                "beyond_s": float(table[f"beyond/{limit}_s"].mean()),
            }
            for limit in _limits(study)
        }
    return uses
