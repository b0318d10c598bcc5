"""Films of the first patient under each entry, drawn by the renderer from kept motions."""

from __future__ import annotations

import base64
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console

from eval.comparison.ranking import Ranking, RankingRow
from eval.comparison.results import Results
from eval.episodes.video import write_mp4
from eval.report.learned import Learned
from jawenv.anatomy import default_mandible
from jawenv.base.progress import Progress
from jawenv.ladder import Model, model_of_env
from jawenv.rendering import Scene, palette
from jawenv.rendering.film import JawRenderer

BESIDE = "slow_opening"
"""Entry of the film beside the best one's: the maneuver of practice."""
ENOUGH, MOST = 4, 6
"""Number of filmed entries; only trainings beside their base maneuvers add to them."""
LONGEST_S, PICTURES_PER_S, SPEED = 12.0, 8, 1.5
"""Longest film of an episode, s; pictures per second of it; speed of the film."""
QUALITY = ("-crf", "32", "-preset", "slow")
_SMOOTH = ("contact", "turn", "moved")


def candidates(ranking: Ranking, trained: Sequence[Learned]) -> set[str]:
    """Labels of the entries that `filmed` may choose from.

    Args:
        ranking: of the comparison.
        trained: trainings beside what they began as.
    """
    rows = [*ranking.rows[:ENOUGH], *(row for each in trained for row in (each.entry, each.base))]
    return {BESIDE, *(row.entry for row in rows)}


def beside(study: Results, ranking: Ranking) -> list[RankingRow]:
    """The best entry, or the first, among those with a kept motion, and ``BESIDE``."""
    rows = [row for row in ranking.rows if study.motions.get(row.entry)]
    best = ranking.best if ranking.best in rows else rows[0] if rows else None
    return [row for row in rows if row is best or row.entry == BESIDE]


def filmed(study: Results, ranking: Ranking, asked_rows: Sequence[RankingRow]) -> list[RankingRow]:
    """The entries of `beside`, the wanted ones, and the next best where there is time for more."""
    rows = [row for row in ranking.rows if study.motions.get(row.entry)]
    asked = list(dict.fromkeys(row.entry for row in (*beside(study, ranking), *asked_rows) if row in rows))[:MOST]
    others = [row.entry for row in rows if row.entry not in asked]
    shown = {*asked, *others[: max(ENOUGH - len(asked), 0)]}
    return [row for row in rows if row.entry in shown]


def shown(study: Results, ranking: Ranking, asked_rows: Sequence[RankingRow]) -> dict[str, Any]:
    """The films, whose motion they show, and how, for the page.

    Args:
        study: a comparison with motions.
        ranking: of the same study.
        asked_rows: entries that are filmed if their motion is kept.
    """
    rows, first_seed = filmed(study, ranking, asked_rows), study.about["settings"]["seed"]
    seed = study.about.get("played_seed", first_seed)
    return {
        "films": _films({row.entry: study.motions[row.entry] for row in rows}, ranking.env),
        "filmed": rows,
        "beside": [("The best: " if row is ranking.best else "", row) for row in beside(study, ranking)],
        "longest_s": LONGEST_S,
        "speed": SPEED,
        "knowledge": f"linear-gradient(to right, {', '.join(f'rgb{colour}' for colour in palette.KNOWLEDGE)})",
        "played": f"the {'first ' if seed == first_seed else ''}patient (seed {seed})",
    }


def _films(motions: Mapping[str, Any], env: str) -> dict[str, str]:
    """An mp4 in base64 of every motion, by the entry's label; progress is shown on the error stream."""
    if not motions:
        return {}
    model, made = model_of_env(env), {}
    with Progress(len(motions), "films", Console(stderr=True)) as progress:
        progress.say(f"filming {len(motions)} entries")
        for entry, motion in motions.items():
            made[entry] = _film(motion, model)
            progress.advance_to(len(made))
    return made


def _film(motion: dict[str, Any], model: Model) -> str:
    renderer = JawRenderer()
    pictures = (renderer.draw(scene) for scene in scenes(motion, model))
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "film.mp4"
        write_mp4(path, pictures, PICTURES_PER_S * SPEED, QUALITY)
        return base64.b64encode(path.read_bytes()).decode()


def scenes(motion: dict[str, Any], model: Model) -> Iterator[Scene]:
    """Scenes between the frames of a motion: its path by cubic splines, all else linear.

    Args:
        motion: see `eval.comparison.motion`.
        model: in which it was played.
    """
    from scipy.interpolate import make_interp_spline
    from scipy.spatial.transform import Rotation

    frames = {name: np.array(values) for name, values in motion["frames"].items()}
    known_s = frames.pop("time_s")
    times = np.arange(known_s[0], min(known_s[-1], LONGEST_S) + 1e-9, 1.0 / PICTURES_PER_S)
    degree = min(3, len(known_s) - 1)
    at = {
        name: make_interp_spline(known_s, values, degree if name in _SMOOTH else min(1, degree))(times)
        for name, values in frames.items()
    }
    turns, number = Rotation.from_rotvec(at["turn"]).as_matrix(), len(motion["parameters"])
    origin, insertion, held = (1e-3 * np.array(motion[name]) for name in ("origin", "insertion", "mouthpiece"))
    for i, (time_s, turn, contact) in enumerate(zip(times, turns, 1e-3 * at["contact"], strict=True)):
        yield Scene(
            muscle_names=tuple(motion["muscles"]),
            muscle_origin_m=origin,
            muscle_insertion_m=contact + insertion @ turn.T,
            muscle_tension_N=np.maximum(at["tension"][i], 0.0),
            contact_m=contact,
            rotation=turn,
            plant=model.plant,
            slides=model.free[0],
            condyle_half_width_m=default_mandible().condyle_half_width_m,
            fossa_drop_m=1e-3 * motion["path"][0],
            fossa_frequency=1e3 * motion["path"][1],
            mouthpiece_m=contact + turn @ held,
            mouthpiece_force_N=at["force"][i],
            parameter_names=tuple(motion["parameters"]),
            belief_mean=np.zeros(number),
            belief_cov=np.diag(np.square(at["sd"][i])),
            prior_mean=np.zeros(number),
            prior_sd=frames["sd"][0],
            truth=None,
            comfort={},
            comfort_hard={},
            governor=0.0,
            time_s=float(time_s),
            episode_s=float(known_s[-1]) or 1.0,
            opening_mm=float(at["moved"][i, 0]),
            opening_limits_mm=np.zeros(2),
            excursion_mm=at["moved"][i, 1:],
            excursion_soft_mm=np.zeros(2),
            information_nats=0.0,
            title="",
        )
