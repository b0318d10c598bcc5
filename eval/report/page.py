"""One HTML file that shows a whole study and is explored in a browser; it needs no network and no other file.

plotly.js (basic bundle, MIT licence) lies under `assets/` as published on npm, and is written into the page once.
"""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
from markupsafe import Markup

from eval.comparison.admission import LARGEST_RINGING
from eval.comparison.ranking import SIGMAS, Ranking
from eval.comparison.results import Results
from eval.comparison.trainings import adaptations
from eval.figures import words
from eval.figures.statistics import RESAMPLES
from eval.report import charts, films, first, marks, template
from eval.report.learned import learned, learning_charts
from eval.rows.outcomes import EARLY_S
from jawenv.anatomy.muscles import SIDES
from jawenv.metrics import BLOCKED_B, CONFIDENCE, FIBROSED_F_O_N, whole_muscles_per_line

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


def render(study: Results, ranking: Ranking) -> str:
    """The report as HTML text.

    Args:
        study: results of all entries.
        ranking: of the same study.
    """
    learning, learning_notes = learning_charts(study, ranking)
    learnt = learned(study, ranking)
    filmed = films.filmed(study, ranking, [row for lesson in learnt for row in (lesson.base, lesson.entry)])
    titles = [words.parameter(name) for name in ranking.parameters]
    data: dict[str, Any] = {
        "entries": marks.entries(ranking),
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
        ranking=ranking,
        largest_ringing=LARGEST_RINGING,
        adaptations=adaptations(study),
        early_s=EARLY_S,
        sigmas=SIGMAS,
        about=study.about,
        answer=first.answer(ranking),
        assumption=first.assumption(study),
        belief=first.belief(ranking),
        bars=first.all_bars(ranking, _episode_s(study), first.firsts(ranking)),
        bars_of_rest=first.all_bars(ranking, _episode_s(study), first.rest(ranking)),
        rest=first.rest(ranking),
        beside=films.beside(study, ranking),
        filmed=filmed,
        longest_s=films.LONGEST_S,
        speed=films.SPEED,
        knowledge=films.colours(),
        least_sure=first.LEAST_SURE,
        terms=template.TERMS,
        has_bound=charts.has_bound(ranking),
        muscles=[words.muscle(name) for name in ranking.parameters[::2]],
        parameter_titles=titles,
        sided=any(name.endswith(SIDES) for name in ranking.parameters),
        shrinks=1.0 - math.exp(-1.0 / ranking.n_parameters),
        fibrosed_F_o_N=FIBROSED_F_O_N * whole_muscles_per_line(ranking.parameters),
        blocked_b=BLOCKED_B,
        confidence=CONFIDENCE,
        resamples=RESAMPLES,
        limits=_limits(study),
        use=_use_of_limits(study, ranking),
        learning=list(learning),
        learning_entries=_entries_in(learning, data["entries"]),
        learning_notes=learning_notes,
        learned=learnt,
        played=_played(study),
        data=_embedded(data),
        plotly=Markup((ASSETS / "plotly-basic.min.js").read_text(encoding="utf-8")),  # noqa: S704  (ours)
        assets={file.name: Markup(file.read_text(encoding="utf-8")) for file in _own_assets()},  # noqa: S704
    )


def _episode_s(study: Results) -> float:
    """Length of the longest episode."""
    return float(study.patients["duration_s"].max())


def _played(study: Results) -> str:
    """Whose motion is shown."""
    first_seed = study.about["settings"]["seed"]
    seed = study.about.get("played_seed", first_seed)
    return f"the {'first ' if seed == first_seed else ''}patient (seed {seed})"


def _entries_in(traced: dict[str, marks.Chart], entries: list[dict[str, Any]]) -> list[str]:
    """Place and name of the entries that have a line in a chart."""
    numbers = dict.fromkeys(trace["meta"] for chart in traced.values() for trace in chart["data"])
    return [f"{entries[i]['place']} {entries[i]['name']}" for i in numbers]


def _own_assets() -> list[Path]:
    return [file for file in ASSETS.iterdir() if file.suffix in (".css", ".js") and "plotly" not in file.name]


def _embedded(data: dict[str, Any]) -> Markup:
    """JSON that may stand inside a script element: no text in it can end the element."""
    text = json.dumps(data, separators=(",", ":"), allow_nan=False)
    return Markup(text.replace("<", "\\u003c"))  # noqa: S704


def _limits(study: Results) -> list[str]:
    """Names of the comfort limits; none in results that are older than their columns."""
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
