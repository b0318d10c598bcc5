"""A page of the maneuvers that come along: how each moves a jaw, what it is for, and three figures.

``python docs/site/gallery.py`` makes the films first; they are kept in runs/gallery until a maneuver or the drawing has
changed. A maneuver without a film is shown by its targets alone. The figures are those of docs/tables/headline.md.
"""

from __future__ import annotations

import hashlib
import re
import sys
from collections.abc import Iterator
from html import escape
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from rich.console import Console

ROOT = Path(__file__).parents[2]
sys.path[:0] = [str(Path(__file__).parent), str(ROOT)]

from purposes import purpose  # noqa: E402
from table_page import first_table  # noqa: E402

from eval.report import drawing  # noqa: E402
from eval.report.template import picture  # noqa: E402
from jawenv.base.files import atomic_write  # noqa: E402
from jawenv.base.locks import alone  # noqa: E402
from jawenv.base.progress import Progress  # noqa: E402
from jawenv.device.channels import CHANNELS  # noqa: E402
from jawenv.playing.maneuvers import Maneuver, maneuver_names  # noqa: E402
from jawenv.playing.maneuvers.maneuver import FOLDER  # noqa: E402

KEPT = ROOT / "runs" / "gallery"
TABLE = ROOT / "docs" / "tables" / "headline.md"
SHOWN_S, SPEED = 20.0, 2  # of the patient's time, and how much quicker the film is
STEPS_PER_S = 10
WIDTH = 480
FIGURES = {
    "time to 5 %, s": ("s", "until all 12 numbers are within 5 %"),
    "worst sd, %": ("%", "sd of the least known after 30 s"),
    "discomfort, s": ("s", "of discomfort in 30 s"),
}
"""Heading of the table -> unit, and what the figure is."""
FIRST = {"slow_opening": 0, "refined": 1}
DRAWN_S = 30.0
LINES = (("#185c8a", "-"), ("#7d4290", (0, (5, 2))), ("#8d4c1c", (0, (1, 1.5))), ("#236350", (0, (7, 2, 1, 2))))
"""Colour and dashes of each of the channels."""


def film_all(console: Console) -> None:
    """Film every maneuver whose film is not kept."""
    KEPT.mkdir(parents=True, exist_ok=True)
    names = maneuver_names()
    with alone(KEPT), Progress(len(names), "films", console) as progress:
        for number, name in enumerate(names, 1):
            if not _film(name).exists():
                progress.say(f"filming {name}")
                _record(name)
            progress.advance_to(number)


def files() -> dict[str, bytes]:
    """Place in the site -> content, of the films that were made and their first pictures."""
    made = {}
    for name in maneuver_names():
        for suffix in (".mp4", ".jpg"):
            place = _film(name).with_suffix(suffix)
            if place.exists():
                made[f"gallery/{name}{suffix}"] = place.read_bytes()
    return made


def page() -> str:
    """The page as Markdown."""
    names = sorted(maneuver_names(), key=lambda name: (FIRST.get(name, len(FIRST)), name))
    figures = _figures()
    cards = "\n".join(_card(Maneuver.named(name), figures.get(name, {})) for name in names)
    return (
        "---\nhide: [toc]\n---\n\n# Gallery of maneuvers\n\n"
        f"One patient of the cohort `trismus`, moved by each maneuver: {SHOWN_S:g} s, at twice their speed. The "
        "bluer a muscle, the better it is known. Below each film are the targets over time, and what "
        f"{_patients()} patients gave ([all figures](tables.md#headline)). "
        "`python -m eval play NAME` shows one in a window, `jawenv live --driver NAME` "
        f"lets you take over.\n\n{_banner()}"
        f'<div class="gallery">\n{cards}\n</div>\n\n'
        "How to write one of your own: [maneuvers](agents/README.md#write-a-maneuver).\n"
    )


def _record(name: str) -> None:
    """An episode's jaw from the side and from the front, as a film and its first picture."""
    from PIL import Image

    from eval.episodes.film import write_mp4

    place = _film(name)
    pictures = list(_pictures(name))
    with atomic_write(place.with_suffix(".jpg")) as unfinished:
        Image.fromarray(pictures[len(pictures) // 4]).save(unfinished, "JPEG", quality=85)
    with atomic_write(place) as unfinished:
        write_mp4(unfinished, pictures, STEPS_PER_S * SPEED, ("-crf", "27"))


def _pictures(name: str) -> Iterator[np.ndarray]:
    import gymnasium as gym

    import jawenv
    from jawenv.envs.shown_world import build_scene
    from jawenv.rendering.film import JawRenderer

    env = gym.make("jawenv/Jaw-v3", control="targets", control_hz=STEPS_PER_S, episode_s=SHOWN_S).unwrapped
    agent, renderer = jawenv.Player(name, control="targets", control_hz=STEPS_PER_S), JawRenderer(WIDTH)
    observation, _ = env.reset(seed=0)
    agent.reset(1)
    done = False
    while not done:
        yield renderer.draw(build_scene(env.simulation))
        action, _ = agent.predict(observation)
        observation, _, terminated, truncated, _ = env.step(action)
        done = terminated or truncated
    env.close()


def _film(name: str) -> Path:
    """Where a film lies; its name says of which sources it is."""
    mark = hashlib.sha256()
    sources = sorted((ROOT / "jawenv" / "rendering").glob("*.py"))
    for source in (FOLDER / f"{name}.yaml", Path(__file__), *sources):
        mark.update(source.read_bytes())
    return KEPT / f"{name}-{mark.hexdigest()[:12]}.mp4"


def _banner() -> str:
    """What the table says of figures of older patients, if it does."""
    found = re.search(r"^\*\*Older patients\.\*\*.*\n\n", TABLE.read_text(encoding="utf-8"), flags=re.M)
    return found[0] if found else ""


def _card(maneuver: Maneuver, figures: dict[str, str]) -> str:
    """A block that Markdown leaves as it is."""
    name = maneuver.name
    moving = (
        f'<video src="gallery/{name}.mp4" poster="gallery/{name}.jpg" loop muted playsinline controls preload="none" '
        f'aria-label="{escape(maneuver.title)}: the jaw from the side and from the front"></video>'
        if _film(name).exists()
        else ""
    )
    sought = purpose(FOLDER / f"{name}.yaml")
    begun = f"<p class='purpose'>{escape(sought)}</p>" if sought else ""
    told = "".join(_figure(figures[key], *words) for key, words in FIGURES.items() if key in figures)
    return (
        f'<section id="{name}"><h2>{escape(maneuver.title)}</h2>{moving}{_chart(maneuver)}{begun}'
        f"<p>{escape(maneuver.description)}</p><ul>{told}</ul>"
        f"<p class='source'><code>{name}</code> · {escape(maneuver.source)}</p></section>"
    )


def _figure(value: str, unit: str, meaning: str) -> str:
    """One line of a card; what is no number has no unit."""
    number = f"{value} {unit}" if value[0].isdigit() else value
    return f"<li><b>{escape(number)}</b> {escape(meaning)}</li>"


def _chart(maneuver: Maneuver) -> str:
    """The targets over time, one line for each channel that moves."""
    times = np.linspace(0.0, DRAWN_S, 301)
    values, _ = maneuver.targets(times)
    names = []
    with drawing.style():
        figure = Figure(figsize=(6.6, 1.4))
        axes = figure.add_axes((0, 0.02, 1, 0.96), xlim=(0, DRAWN_S), ylim=(-1.05, 1.05))
        axes.set_axis_off()
        axes.axhline(0.0, color=drawing.GRID, lw=1)
        for channel, (colour, dash) in zip(CHANNELS, LINES, strict=True):
            if np.ptp(values[:, CHANNELS.index(channel)]) > 1e-9:
                axes.plot(times, values[:, CHANNELS.index(channel)], color=colour, ls=dash, lw=2)
                names.append(f'<span class="{channel}">{channel.replace("_", "-")}</span>')
    css = {drawing.GRID: "var(--jaw-line)"}
    css |= {colour: f"var(--jaw-{channel})" for channel, (colour, _) in zip(CHANNELS, LINES, strict=True)}
    drawn = picture(figure, maneuver.name, f"Targets of {maneuver.title} over {DRAWN_S:g} s", css)
    legend = " ".join(names) or "all targets stay at rest"
    return f'{drawn}<p class="legend">{legend}, {DRAWN_S:g} s</p>'


def _patients() -> str:
    """How many patients the table is of."""
    return re.search(r": (\d+) patients", TABLE.read_text(encoding="utf-8"))[1]  # type: ignore[index]


def _figures() -> dict[str, dict[str, str]]:
    """Maneuver -> heading of the table -> figure without its interval, in targets control and `Jaw-v3`."""
    found = {}
    for row in first_table(TABLE.read_text(encoding="utf-8")):
        if row["control"] == "targets" and "JawImaged" not in row.values():
            found[row["entry"].replace(" ", "_")] = {key: re.split(r" \(", row[key])[0] for key in FIGURES}
    return found


if __name__ == "__main__":
    try:
        film_all(Console(stderr=True))
    except KeyboardInterrupt:
        sys.exit("stopped; finished films are kept, and the same command goes on")
