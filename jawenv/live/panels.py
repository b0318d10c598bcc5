"""What stands beside the jaw, as HTML: the posteriors, comfort, and the lines of the score."""

from __future__ import annotations

import math
from collections.abc import Sequence
from html import escape

from jawenv.live.outcome import KNOWN, LARGEST_DISCOMFORT_S, Outcome
from jawenv.live.session import Shown
from jawenv.rendering import palette
from jawenv.rendering.scene import Scene

_BEST_SD = 0.01
_TRACK = "#eeebe5"
_CARD = (
    "font:13px/1.35 system-ui,sans-serif;color:#222a35;background:#fff;border:1px solid #e2ded5;"
    "border-radius:8px;padding:10px 12px;margin:8px"
)
_SHORT = {"anterior": "ant.", "posterior": "post.", "medial": "med.", "superficial": "sup.", "left": "L", "right": "R"}


def posterior_html(scene: Scene) -> str:
    """A row for each muscle, a bar for each of its two parameters: longer and bluer the better it is known."""
    worst = float(scene.prior_sd.max())
    index = {name: i for i, name in enumerate(scene.parameter_names)}
    head = "<tr><th></th><th>F<sub>o</sub>, N</th><th>sd</th><th>b</th><th>sd</th></tr>"
    rows = []
    for muscle in scene.muscles:
        cells = []
        for parameter in ("log_F_o", "log_b"):
            i = index[f"{parameter}/{muscle}"]
            value = f"{math.exp(float(scene.belief_mean[i])):#.3g}".rstrip(".")
            sd = _sd_cell(float(scene.belief_sd[i]), worst)
            cells.append(f"<td style='text-align:right;padding-left:8px'>{value}</td>{sd}")
        rows.append(f"<tr><th style='{_NAME}'>{escape(_name(muscle))}</th>{''.join(cells)}</tr>")
    known = " · ".join(f"{int((scene.belief_sd <= sd).sum())} to {100 * sd:.0f} %" for sd in KNOWN)
    title = f"<b>Posterior</b> <span data-known>of {len(scene.parameter_names)} known: {known}</span>"
    table = f"<table style='border-collapse:collapse;width:100%;font-size:12px'>{head}{''.join(rows)}</table>"
    return f"<div id='posterior' style='{_CARD}'>{title}{table}</div>"


def comfort_html(scene: Scene) -> str:
    """A bar for each comfort limit: used share of the soft limit, with the soft limit as a line."""
    if not scene.comfort:
        return ""
    rows = []
    for name, used in scene.comfort.items():
        hard = scene.comfort_hard[name]
        colour = _css(palette.comfort(used, hard))
        share = 72.0 * min(used, 1.0) + 28.0 * min(max((used - 1.0) / (hard - 1.0), 0.0), 1.0)
        mark = "<i style='position:absolute;left:72%;top:-2px;width:2px;height:14px;background:#222a35'></i>"
        label = escape(name.replace("_", " ").replace("fore aft", "fore-aft"))
        rows.append(
            f"<tr><th style='{_NAME}'>{label}</th><td style='width:52%'>{_bar(share, colour, mark)}</td>"
            f"<td style='text-align:right;width:44px'>{100 * used:.0f} %</td></tr>"
        )
    title = "<b>Comfort</b> used share of each soft limit (line)"
    table = f"<table style='border-collapse:collapse;width:100%;font-size:12px'>{''.join(rows)}</table>"
    return f"<div id='comfort' style='{_CARD}'>{title}{table}</div>"


def status_html(shown: Shown, remark: str = "") -> str:
    """Time, what is known by when, discomfort; a remark or the end of the episode below."""
    scene, outcome = shown.scene, shown.outcome
    worst = f"{100 * outcome.worst_sd:.1f}"
    allowed = LARGEST_DISCOMFORT_S * scene.episode_s / 30.0
    figures = (
        ("time", f"{scene.time_s:.1f} s", f"of {scene.episode_s:g} s"),
        ("worst sd", f"<span data-worst='{worst}'>{worst} %</span>", f"driven by {escape(shown.driver)}"),
        ("all to 10 %", _seconds(outcome.time_to_s[0]), ""),
        ("all to 5 %", _seconds(outcome.time_to_s[1]), ""),
        ("discomfort", f"{outcome.discomfort_s:.2f} s", f"allowed {allowed:.2g} s"),
        ("opening", f"{scene.opening_mm:.1f} mm", ""),
    )
    cells = "".join(
        f"<div><div style='color:#606873;font-size:11.5px'>{name}</div><b style='font-size:17px'>{value}</b>"
        f"<div style='color:#606873;font-size:11px;min-height:14px'>{below}</div></div>"
        for name, value, below in figures
    )
    words = [escape(each) for each in (shown.why, remark) if each]
    if shown.misfit > 1.0:
        words.append("The readings do not fit the model.")
    below = "".join(f"<div style='margin-top:4px;color:#8a4b08'>{each}</div>" for each in words)
    grid = "display:grid;grid-template-columns:repeat(3,1fr);gap:4px 8px"
    return f"<div id='status' style='{_CARD}'><div style='{grid}'>{cells}</div>{below}</div>"


def score_html(outcomes: Sequence[Outcome], saved: Sequence[str] = ()) -> str:
    """What the drive and the maneuvers reached on this patient."""
    head = "<tr><th></th><th>10 %</th><th>5 %</th><th>worst</th><th>discomfort</th></tr>"
    rows = []
    for one in outcomes:
        figures = (
            _seconds(one.time_to_s[0]),
            _seconds(one.time_to_s[1]),
            f"{100 * one.worst_sd:.1f} %",
            f"{one.discomfort_s:.2f} s{'' if one.within_comfort else ' (too much)'}",
        )
        cells = "".join(f"<td style='text-align:right;padding-left:6px'>{each}</td>" for each in figures)
        rows.append(f"<tr><th style='{_NAME}'>{escape(one.name.replace('_', ' '))}</th>{cells}</tr>")
    files = "".join(f"<div style='overflow-wrap:anywhere'>saved: {escape(path)}</div>" for path in saved)
    table = f"<table style='border-collapse:collapse;width:100%;font-size:12px'>{head}{''.join(rows)}</table>"
    return f"<div id='score' style='{_CARD}'><b>Score on this patient</b>{table}{files}</div>"


_NAME = "text-align:left;font-weight:400;white-space:nowrap;padding:1px 6px 1px 0"


def _sd_cell(sd: float, worst: float) -> str:
    share = 100.0 * min(max(math.log(worst / sd) / math.log(worst / _BEST_SD), 0.02), 1.0)
    words = f"{100 * sd:.1f} %" if sd < 0.0995 else f"{100 * sd:.0f} %"
    bar = _bar(share, _css(palette.knowledge(sd)))
    return (
        f"<td style='width:26%;padding-left:6px'><div style='display:flex;gap:4px;align-items:center'>"
        f"<div style='flex:1'>{bar}</div><span style='width:42px;text-align:right'>{words}</span></div></td>"
    )


def _bar(share: float, colour: str, mark: str = "") -> str:
    """A bar of so many per cent."""
    return (
        f"<div style='position:relative;height:10px;border-radius:5px;background:{_TRACK}'>"
        f"<div style='height:10px;border-radius:5px;width:{share:.1f}%;background:{colour}'></div>{mark}</div>"
    )


def _css(colour: palette.Colour) -> str:
    return f"rgb({colour[0]},{colour[1]},{colour[2]})"


def _seconds(time: float) -> str:
    return f"{time:.1f} s" if math.isfinite(time) else "–"


def _name(muscle: str) -> str:
    return " ".join(_SHORT.get(word, word) for word in muscle.split("_"))
