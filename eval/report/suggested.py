"""The page of ``jawenv suggest --page``: the movement as a film, its targets, and what it is expected to tell."""

from __future__ import annotations

import base64
import tempfile
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
from markupsafe import Markup
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from eval.episodes.video import write_mp4
from eval.kept.tables import made_with
from eval.report import drawing, template
from jawenv.envs.shown_world import build_scene
from jawenv.ladder import DEFAULT_ENV
from jawenv.playing.agents import introduce
from jawenv.playing.maneuvers import Player
from jawenv.rendering.film import JawRenderer

_EVERY = 2  # control steps from one picture to the next
_QUALITY = ("-crf", "32", "-preset", "slow")
_NOW, _AFTER, _THIRD = "#8a6a4f", "#1f77c4", "#009e73"
_CSS = {_NOW: "var(--now)", _AFTER: "var(--after)", _THIRD: "var(--third)"}
_CHANNELS = (
    ("opening", 0, _AFTER, "-"),
    ("side, left up", 1, _NOW, "--"),
    ("push, forward up", 2, _THIRD, ":"),
)


def write_page(found: Any, rows: list[tuple[str, tuple[float, ...]]], weakest: str, target: Path, command: str) -> Path:
    """Write the page.

    Args:
        found: the suggestion.
        rows: what is expected in words, and the largest error bar then: one figure, or median, low and high.
        weakest: the least known combination, in words.
        target: the page's file.
        command: that made it.
    """
    told = np.sqrt(np.diagonal(found.found.estimate.cov[-1])), found.expected.sds
    page = template.render(
        "suggested.html.j2",
        movement=found.movement(),
        weakest=weakest.replace("F_o", "Fₒ").replace("%", " %"),
        seconds=f"{found.seconds:g}",
        film=_film(found),
        targets=_targets(found),
        bars=_bars(*told, found.parameter_names),
        rows=[(words, [f"{100.0 * figure:.1f} %" for figure in figures]) for words, figures in rows],
        about=made_with(command),
    )
    return template.write(page, target)


def _film(found: Any) -> str:
    """The movement of the patient whom the estimates describe, an mp4 in base64."""
    rate = 20.0
    smooth = {
        "control": "trajectory",
        "control_hz": rate,
        "comfort_budget_s": None,
    }  # targets keep a budget, 5 times a second
    env: Any = gym.make(DEFAULT_ENV, **found.world | smooth).unwrapped
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "film.mp4"
        write_mp4(path, _pictures(env, found), rate / _EVERY, _QUALITY)
        env.close()
        return base64.b64encode(path.read_bytes()).decode()


def _pictures(env: Any, found: Any) -> Iterator[Any]:
    """Pictures of an episode; what is known counts the recording before as well."""
    renderer, player = JawRenderer(), Player(found.maneuver, control="trajectory")
    observation, _ = env.reset(seed=found.seed, options={"patient": found.patient})
    player.reset(1)
    introduce(player, env)
    prior = np.diag(env.prior.sd**-2)
    known = np.linalg.inv(found.found.estimate.cov[-1]) - prior
    ended, step = False, 0
    while not ended:
        if step % _EVERY == 0:
            scene = build_scene(env.simulation, "")
            both = np.linalg.inv(np.linalg.inv(scene.belief_cov) + known)
            yield renderer.draw(replace(scene, belief_cov=both))
        action, _ = player.predict(observation[None])
        observation, _, terminated, truncated, _ = env.step(action[0])
        ended, step = terminated or truncated, step + 1


def _targets(found: Any) -> Markup:
    """The three channels over time."""
    time = np.linspace(0.0, found.seconds, 200)
    goals = found.maneuver.targets(time).value
    with drawing.style():
        figure = Figure(figsize=(5.4, 2.2), layout="constrained")
        axes = figure.subplots()
        for name, k, colour, dashes in _CHANNELS:
            axes.plot(time, goals[:, k], dashes, color=colour, label=name)
        axes.set(xlim=(0.0, found.seconds), ylim=(-1.05, 1.05), xlabel="time, s", ylabel="share of the whole")
        axes.legend(loc="upper center", bbox_to_anchor=(0.5, 1.22), ncols=3)
        return template.picture(figure, "targets", "Opening, side and push over time", _CSS)


def _bars(now: Any, after: Any, names: tuple[str, ...]) -> Markup:
    """Each parameter's error bar now and as it is expected."""
    places = np.arange(len(names))[::-1]
    with drawing.style():
        figure = Figure(figsize=(5.4, 3.3), layout="constrained")
        axes = figure.subplots()
        axes.hlines(places, 100.0 * after, 100.0 * now, color=drawing.GRID, lw=3.0)
        axes.plot(100.0 * now, places, "s", color=_NOW, label="now")
        axes.plot(100.0 * after, places, "o", color=_AFTER, label="expected after it")
        axes.set(xscale="log", xlabel="error bar (sd), %")
        axes.set_yticks(places, [_in_words(name) for name in names])
        axes.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axes.xaxis.set_minor_formatter(NullFormatter())
        axes.legend(loc="upper center", bbox_to_anchor=(0.4, 1.12), ncols=2)
        return template.picture(figure, "bars", "Error bar of each parameter, now and expected", _CSS)


def _in_words(name: str) -> str:
    symbol, muscle = name.removeprefix("log_").split("/")
    return f"{muscle.replace('_', ' ')} {symbol.replace('F_o', 'Fₒ')}"
