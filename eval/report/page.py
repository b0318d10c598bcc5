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
from eval.comparison.ranking import Ranking
from eval.comparison.results import Results
from eval.comparison.trainings import adaptations, verdict
from eval.figures import words
from eval.figures.statistics import RESAMPLES
from eval.report import charts, films, first, template
from eval.rows.outcomes import EARLY_S
from jawenv.anatomy.muscles import SIDES
from jawenv.ladder import KNOWN_WITHIN_SDS
from jawenv.metrics import CONFIDENCE, TARGETS
from jawenv.playing.rollout import DEFAULT_ENV

ASSETS = Path(__file__).parent / "assets"


CONSTANTS: Mapping[str, Any] = {
    "confidence": CONFIDENCE,
    "early_s": EARLY_S,
    "largest_ringing": LARGEST_RINGING,
    "resamples": RESAMPLES,
    "targets": TARGETS,
    "terms": template.TERMS,
}


def write(study: Results, ranking: Ranking, path: Path) -> Path:
    """Write the report, and return its path; see `render`."""
    return template.write(render(study, ranking), path)


def render(study: Results, ranking: Ranking) -> str:
    """The report as HTML text.

    Args:
        study: results of all entries.
        ranking: of the same study.
    """
    shown = films.shown(study, ranking)
    titles = [words.parameter(name) for name in ranking.parameters]
    data: dict[str, Any] = {
        "entries": charts.entries(ranking),
        "charts": charts.all_charts(study, ranking),
        "parameters": [{"key": key, "title": title} for key, title in zip(ranking.parameters, titles, strict=True)],
        "curves": charts.curves(study, ranking),
        "sd_range": charts.sd_range(study),
        "films": shown.pop("films"),
    }
    answer, comfort = _answer(study, ranking), {"limits": _limits(study), "use": _use_of_limits(study, ranking)}
    diagnoses = {row.entry: study.diagnoses(row.entry) for row in ranking.rows}
    return template.render(
        "report.html.j2",
        about=study.about,
        answer=answer,
        comfort=comfort,
        diagnoses=diagnoses,
        adaptations=adaptations(study),
        ranking=ranking,
        constants=CONSTANTS,
        model=_model(ranking, titles),
        films=shown,
        verdict=verdict,
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
    believed, because = first.belief(ranking)
    return {
        "sentence": first.answer(ranking),
        "assumption": _assumption(study),
        "believed": believed,
        "because": because,
        "rest": first.rest(ranking),
    }


def _assumption(study: Results) -> str:
    """Assumptions of the answer on anatomy and disturbance, in a sentence or two."""
    settings = study.about.get("settings", {})
    imaged = study.env == KNOWN_WITHIN_SDS
    how = "only roughly, as a scan shows it" if imaged or settings.get("knowledge") else "exactly"
    lasts = imaged or settings.get("device", {}).get("unmodelled_time_s", 0.0) > 0.0
    lasting = "that last" if lasts else "that do not last"
    sentence = f"This holds for a jaw whose anatomy is known {how}, with small disturbances {lasting}."
    less = " Where a scan alone shows the anatomy, all is known several times less precisely."
    return sentence + (less if how == "exactly" and study.env == DEFAULT_ENV else "")


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
