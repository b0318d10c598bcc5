"""Films of the first patient under each entry, drawn by the renderer from kept motions."""

from __future__ import annotations

import base64
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from rich.console import Console

from eval.comparison.ranking import Ranking, RankingRow
from eval.comparison.results import Results
from eval.episodes.video import write_mp4
from jawenv.base.progress import Progress
from jawenv.rendering import palette
from jawenv.rendering.film import JawRenderer
from jawenv.rendering.scene import Scene

BESIDE = "slow_opening"
"""Entry of the film beside the best one's: the maneuver of practice."""
ENOUGH = 4
"""Number of filmed entries."""
LONGEST_S, SPEED = 12.0, 1.5
"""Longest film of an episode, s; speed of the film."""
QUALITY = ("-crf", "32", "-preset", "slow")


def candidates(ranking: Ranking) -> set[str]:
    """Labels of the entries that `filmed` may choose from."""
    return {BESIDE, *(row.entry for row in ranking.rows[:ENOUGH])}


def beside(study: Results, ranking: Ranking) -> list[RankingRow]:
    """The best entry, or the first, among those with a kept motion, and ``BESIDE``."""
    rows = [row for row in ranking.rows if study.motions.get(row.entry)]
    best = ranking.best if ranking.best in rows else rows[0] if rows else None
    return [row for row in rows if row is best or row.entry == BESIDE]


def filmed(study: Results, ranking: Ranking) -> list[RankingRow]:
    """The entries of `beside`, and the next best."""
    rows, first = [row for row in ranking.rows if study.motions.get(row.entry)], beside(study, ranking)
    others = [row for row in rows if row not in first]
    return [row for row in rows if row in (*first, *others[: ENOUGH - len(first)])]


def shown(study: Results, ranking: Ranking) -> dict[str, Any]:
    """The films, whose motion they show, and how, for the page.

    Args:
        study: a comparison with motions.
        ranking: of the same study.
    """
    rows, first_seed = filmed(study, ranking), study.about["settings"]["seed"]
    seed = study.about.get("played_seed", first_seed)
    return {
        "films": _films({row.entry: study.motions[row.entry] for row in rows}),
        "filmed": rows,
        "beside": [("The best: " if row is ranking.best else "", row) for row in beside(study, ranking)],
        "longest_s": LONGEST_S,
        "speed": SPEED,
        "knowledge": f"linear-gradient(to right, {', '.join(f'rgb{colour}' for colour in palette.KNOWLEDGE)})",
        "played": f"the {'first ' if seed == first_seed else ''}patient (seed {seed})",
    }


def _films(motions: Mapping[str, Sequence[Scene]]) -> dict[str, str]:
    """An mp4 in base64 of every motion, by the entry's label; progress is shown on the error stream."""
    if not motions:
        return {}
    made: dict[str, str] = {}
    with Progress(len(motions), "films", Console(stderr=True)) as progress:
        progress.say(f"filming {len(motions)} entries")
        for entry, scenes in motions.items():
            made[entry] = _film(scenes)
            progress.advance_to(len(made))
    return made


def _film(scenes: Sequence[Scene]) -> str:
    renderer = JawRenderer()
    pictures = (renderer.draw(scene) for scene in scenes if scene.time_s <= LONGEST_S)
    every_s = scenes[min(1, len(scenes) - 1)].time_s - scenes[0].time_s or 1.0
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "film.mp4"
        write_mp4(path, pictures, SPEED / every_s, QUALITY)
        return base64.b64encode(path.read_bytes()).decode()
