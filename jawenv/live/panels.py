"""Panels beside the jaw, as HTML: the posteriors, comfort, and the lines of the score."""

from __future__ import annotations

import math
from collections.abc import Sequence
from html import escape

from jawenv.answers.tension import Tension
from jawenv.live.outcome import KNOWN, LARGEST_DISCOMFORT_S, DriveOutcome
from jawenv.live.session import Shown
from jawenv.live.stiffness import stiff_from_N
from jawenv.metrics.calibration import alarm_word
from jawenv.metrics.diagnosis import whole_muscles_per_line
from jawenv.rendering import palette
from jawenv.rendering.scene import Scene

_BEST_SD = 0.01
_TRACK = "var(--live-track)"
_CARD = (
    "font:13px/1.35 system-ui,sans-serif;color:var(--live-ink);background:var(--live-card);"
    "border:1px solid var(--live-line);border-radius:8px;padding:10px 12px;margin:8px"
)
_SHORT = {"anterior": "ant.", "posterior": "post.", "medial": "med.", "superficial": "sup.", "left": "L", "right": "R"}


def posterior_html(scene: Scene) -> str:
    """A row for each muscle, a bar for each of its two parameters: longer and bluer the better it is known."""
    worst = float(scene.prior_sd.max())
    index = {name: i for i, name in enumerate(scene.parameter_names)}
    head = f"<tr><th></th>{_heads(_POSTERIOR_HEADS)}</tr>"
    rows = []
    for muscle in scene.muscles:
        cells = []
        for parameter in ("log_F_o", "log_b"):
            i = index[f"{parameter}/{muscle}"]
            value = f"{math.exp(float(scene.belief_mean[i])):#.3g}".rstrip(".")
            sd = _sd_cell(float(scene.belief_sd[i]), worst)
            cells.append(f"<td style='text-align:right;padding-left:8px'>{value}</td>{sd}")
        rows.append(f"<tr><th style='{_NAME}'>{escape(muscle_name(muscle))}</th>{''.join(cells)}</tr>")
    counts = " · ".join(f"{int((scene.belief_sd <= sd).sum())} within {100 * sd:.0f} %" for sd in KNOWN)
    title = f"<b>Posterior</b> <span data-known>of {len(scene.parameter_names)}: {counts}</span>"
    table = f"<table style='border-collapse:collapse;width:100%;font-size:12px'>{head}{''.join(rows)}</table>"
    return f"<div id='posterior' style='{_CARD}'>{title}{table}</div>"


def strip_html(scene: Scene) -> str:
    """A bar for each muscle, of the less known of its two parameters, for pages too narrow for the posterior."""
    worst, bars = float(scene.prior_sd.max()), []
    for muscle in scene.muscles:
        rows = [scene.parameter_names.index(f"{parameter}/{muscle}") for parameter in ("log_F_o", "log_b")]
        bar = _sd_bar(float(scene.belief_sd[rows].max()), worst)
        bars.append(f"<div style='flex:1;min-width:0'>{bar}<span>{escape(_initials(muscle))}</span></div>")
    return f"<div id='strip' style='{_CARD};gap:6px;font-size:11px'>{''.join(bars)}</div>"


def legend_html(scene: Scene, by_stiffness: bool = False) -> str:
    """Legend of the jaw's colours and sizes."""
    words = "The thicker a muscle, the harder it pulls. The arrow is the force of the device."
    if by_stiffness:
        limit = stiff_from_N(scene)
        ends = f"F<sub>o</sub> {limit / palette.STIFFEST:.2g} N", f"{limit * palette.STIFFEST:.2g} N"
        colours = [palette.stiffness(palette.STIFFEST ** (i / 3 - 1)) for i in range(7)]
        title = f"<b>Colour of a muscle</b> believed F<sub>o</sub>, stiff above {limit:g} N"
    else:
        ends = f"unknown: {100 * palette.UNKNOWN_SD:.0f} %", f"known: {100 * _BEST_SD:.0f} %"
        shares = [i / 6 for i in range(7)]
        colours = [palette.knowledge(palette.UNKNOWN_SD ** (1 - share) * _BEST_SD**share) for share in shares]
        title = "<b>Colour of a muscle</b> its error bars: red is not known yet, not stiff"
    ramp = ",".join(_css(colour) for colour in colours)
    scale = (
        f"<div style='display:flex;gap:8px;align-items:center'><span>{ends[0]}</span>"
        f"<div style='flex:1;height:10px;border-radius:5px;background:linear-gradient(90deg,{ramp})'></div>"
        f"<span>{ends[1]}</span></div>"
    )
    return f"<div id='legend' style='{_CARD};font-size:12px'>{title}{scale}{words}</div>"


def comfort_html(scene: Scene) -> str:
    """A bar for each comfort limit: used share of the soft limit, with the soft limit as a line."""
    if not scene.comfort:
        return ""
    rows = []
    for name, used in scene.comfort.items():
        hard = scene.comfort_hard[name]
        colour = _css(palette.comfort(used, hard))
        share = 72.0 * min(used, 1.0) + 28.0 * min(max((used - 1.0) / (hard - 1.0), 0.0), 1.0)
        mark = "<i style='position:absolute;left:72%;top:-2px;width:2px;height:14px;background:var(--live-ink)'></i>"
        label = _limit(name)
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
    costly = [_limit(name) for name, used in scene.comfort.items() if used > 1.0]
    below = f"allowed {allowed:.2g} s"
    if costly:
        below = f"<span style='color:var(--live-remark)'>{' and '.join(costly)}</span>"
    elif shown.spent_on:
        below = f"{'all' if len(shown.spent_on) == 1 else 'spent'} on {' and '.join(map(_limit, shown.spent_on))}"
    discomfort = f"{outcome.discomfort_s:.2f} s"
    if outcome.discomfort_s > allowed:
        discomfort = f"<span style='color:var(--live-remark)'>{discomfort}</span>"
    figures = (
        ("time", f"{scene.time_s:.1f} s", f"of {scene.episode_s:g} s"),
        (_hint("worst sd", _WORST), f"<span data-worst={worst}>{worst} %</span>", f"driven by {escape(shown.driver)}"),
        ("all within 10 %", _seconds(outcome.time_to_s[0]), _verdicts(shown)),
        ("all within 5 %", _seconds(outcome.time_to_s[1]), ""),
        (_hint("discomfort", _DISCOMFORT), discomfort, below),
        ("opening", f"{scene.opening_mm:.1f} mm", ""),
    )
    cells = "".join(
        f"<div><div style='color:var(--live-soft);font-size:11.5px'>{name}</div><b style='font-size:17px'>{value}</b>"
        f"<div style='color:var(--live-soft);font-size:11px;min-height:14px'>{below}</div></div>"
        for name, value, below in figures
    )
    words = [escape(text) for text in (shown.why, remark) if text]
    if alarm_word(shown.misfit) != "silent":
        words.append(_ALARMS[alarm_word(shown.misfit)])
    below = "".join(f"<div style='margin-top:4px;color:var(--live-remark)'>{text}</div>" for text in words)
    grid = "display:grid;grid-template-columns:repeat(3,1fr);gap:4px 8px"
    return f"<div id='status' style='{_CARD}'><div style='{grid}'>{cells}</div>{below}</div>"


def _verdicts(shown: Shown) -> str:
    """Number of the muscles on which the data have a verdict; empty where lines are no whole muscles."""
    if whole_muscles_per_line(shown.scene.parameter_names) != 1.0:
        return ""
    return f"{shown.stands.sum()} of {len(shown.stands)} verdicts stand"


def ghost_html(shown: Shown) -> str:
    """Line about how far the ghost has come."""
    outcome = shown.outcome
    words = f"worst sd {100 * outcome.worst_sd:.1f} %, all within 5 % {_seconds(outcome.time_to_s[1])}"
    style = "font:12px/1.4 system-ui,sans-serif;color:var(--live-soft);margin:0 20px 4px"
    return f"<div id='ghost' style='{style}'>ghost of {escape(shown.driver.replace('_', ' '))}: {words}</div>"


def score_html(outcomes: Sequence[DriveOutcome], forces: Sequence[Tension], saved: Sequence[str] = ()) -> str:
    """Scores of the drive and of the maneuvers on this patient, and the closing force that the drive told."""
    head = f"<tr><th></th>{_heads(_SCORE_HEADS)}</tr>"
    rows = []
    for one in outcomes:
        figures = (
            _seconds(one.time_to_s[0]),
            _seconds(one.time_to_s[1]),
            f"{100 * one.worst_sd:.1f} %",
            f"{one.discomfort_s:.2f} s{'' if one.within_comfort else ', over'}",
        )
        cells = "".join(f"<td style='{_FIGURE}'>{figure}</td>" for figure in figures)
        rows.append(f"<tr><th style='{_NAME};white-space:normal'>{escape(one.name.replace('_', ' '))}</th>{cells}</tr>")
    pulls = [f"{one.opening_mm:g} mm {one.force_N:.2f} ± {one.force_sd_N:.2f} N" for one in forces]
    pulled = f"<div>closing force at the incisors, opened by {', '.join(pulls)}</div>" if pulls else ""
    files = "".join(f"<div style='overflow-wrap:anywhere'>saved: {escape(path)}</div>" for path in saved)
    table = f"<table style='border-collapse:collapse;width:100%;font-size:12px'>{head}{''.join(rows)}</table>"
    return f"<div id='score' style='{_CARD}'><b>Score on this patient</b>{table}{pulled}{files}</div>"


_STEPS = ("Hold <b>S</b>: the jaw opens.", "Swing with <b>A</b> and <b>D</b>.", "Watch the bars fill.")
STEPS = (
    f"<div id='steps' style='{_CARD}'><ol style='margin:0;padding-left:20px'>"
    + "".join(f"<li>{step}</li>" for step in _STEPS)
    + "</ol></div>"
)
"""First steps of a driver."""
_ALARMS = {
    "yellow": "The readings fit the model badly: look twice at the estimates.",
    "rings": "The readings do not fit the model.",
}
_WORST = "standard deviation of the natural log of the least known parameter: 5 % is 0.05"
_DISCOMFORT = "0.5 s: half a second at a hard limit, or a second halfway to it; nobody has measured the pain"
_POSTERIOR_HEADS = (
    ("F<sub>o</sub>, N", "pull of the muscle in the closed jaw"),
    ("sd", "standard deviation of its natural log"),
    ("b", "how quickly the pull grows with stretch: at 7 a stretch of 10 % doubles it"),
    ("sd", "standard deviation of its natural log"),
)
_SCORE_HEADS = (
    ("10 %", "time until every parameter is within 10 %"),
    ("5 %", "time until every parameter is within 5 %"),
    ("worst", f"{_WORST}, at the end"),
    ("discomfort", _DISCOMFORT),
)
_NAME = "text-align:left;font-weight:400;white-space:nowrap;padding:1px 6px 1px 0"
_FIGURE = "text-align:right;white-space:nowrap;padding-left:4px"


def _hint(words: str, meaning: str) -> str:
    """Words that say what they mean when one points at them."""
    return f"<abbr title='{escape(meaning)}' style='text-underline-offset:3px'>{words}</abbr>"


def _heads(heads: Sequence[tuple[str, str]]) -> str:
    return "".join(
        f"<th style='text-align:right;padding-left:6px;white-space:nowrap'>{_hint(*head)}</th>" for head in heads
    )


def _sd_cell(sd: float, worst: float) -> str:
    words = f"{100 * sd:.1f} %" if sd < 0.0995 else f"{100 * sd:.0f} %"
    bar = _sd_bar(sd, worst)
    return (
        f"<td style='width:26%;padding-left:6px'><div style='display:flex;gap:4px;align-items:center'>"
        f"<div style='flex:1'>{bar}</div><span style='width:42px;text-align:right'>{words}</span></div></td>"
    )


def _sd_bar(sd: float, worst: float) -> str:
    """A bar that is longer and bluer the smaller an sd is, from the worst of the prior on."""
    share = 100.0 * min(max(math.log(worst / sd) / math.log(worst / _BEST_SD), 0.02), 1.0)
    return _bar(share, _css(palette.knowledge(sd)))


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


def muscle_name(muscle: str) -> str:
    """A muscle's name, shortened."""
    return " ".join(_SHORT.get(word, word) for word in muscle.split("_"))


def _initials(muscle: str) -> str:
    """The first letters of a muscle's name; a side keeps its own."""
    *words, side = muscle.split("_")
    return "".join(word[0] for word in words) + " " + _SHORT.get(side, side)


def _limit(name: str) -> str:
    """Name of a comfort limit."""
    return escape(name.replace("_", " ").replace("fore aft", "fore-aft"))
