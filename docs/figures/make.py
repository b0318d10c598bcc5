"""Make the figures of docs/model.md from the code that they describe.

``python docs/figures/make.py`` writes all, ``python docs/figures/make.py muscle_law`` one of them; ``--folder`` and
``--format png`` put them elsewhere. Needs the extras ``eval`` (matplotlib) and, for the comparisons, ``dev``: those
figures show the runs of the tests themselves. The same sources and matplotlib give the same bytes.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from matplotlib.patches import Arc

FOLDER = Path(__file__).parent
ROOT = FOLDER.parents[1]
for folder in (ROOT, ROOT / "tests", ROOT / "tests" / "validation"):
    if str(folder) not in sys.path:
        sys.path.append(str(folder))

from jawenv.anatomy import COHORTS, WHOLE_MUSCLES, attachment, attachment_rows  # noqa: E402
from jawenv.envs import beginning  # noqa: E402
from jawenv.envs.rendering import outlines  # noqa: E402
from jawenv.estimation.ekf import filter_scratch_dtype  # noqa: E402
from jawenv.mechanics import acceleration, build_jaw  # noqa: E402
from jawenv.mechanics.equilibrium import settle  # noqa: E402
from jawenv.mechanics.forces import capsule_force, muscle_pull  # noqa: E402
from jawenv.mechanics.kinematics import contact_point, fossa, rotation  # noqa: E402

# Okabe & Ito's colours, which the colour-blind can tell apart; line styles differ as well.
INK, GREY, PALE = "#2b2f36", "#7d858f", "#e4e7eb"
BLUE, ORANGE, GREEN, PINK, SKY, RED = "#0072b2", "#e69f00", "#009e73", "#cc79a7", "#56b4e9", "#d55e00"
STYLE = {
    "font.family": "DejaVu Sans",
    "font.size": 9.0,
    "axes.titlesize": 9.5,
    "axes.titlelocation": "left",
    "axes.titleweight": "bold",
    "axes.edgecolor": GREY,
    "axes.labelcolor": INK,
    "axes.titlecolor": INK,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.axisbelow": True,
    "axes.grid": True,
    "grid.color": PALE,
    "grid.linewidth": 0.7,
    "text.color": INK,
    "xtick.color": INK,
    "ytick.color": INK,
    "legend.frameon": False,
    "legend.fontsize": 8.5,
    "lines.linewidth": 1.8,
    "figure.facecolor": "white",
    "savefig.facecolor": "white",
    "svg.fonttype": "path",
    "svg.hashsalt": "jawenv",
    "mathtext.fontset": "dejavusans",
}
FORWARD, LEFT, UP = "x, forward (mm)", "y, left (mm)", "z, up (mm)"


def canvas(width: float, height: float, *shape: int, **options: object) -> tuple[Figure, list[Axes]]:
    """A figure and its axes in one list."""
    figure = Figure(figsize=(width, height), layout="constrained")
    return figure, list(np.atleast_1d(figure.subplots(*shape, **options)).ravel())


def bone(axes: Axes, first: int, second: int, turn: np.ndarray | None = None, shift: np.ndarray | None = None) -> None:
    """The mandible's drawing (mm) projected on two of the axes x, y, z; only the looks, no model."""
    left = outlines._RUNGS[:, :6].reshape(-1, 2, 3)
    ends = np.concatenate([left, left[::-1] * [1.0, -1.0, 1.0]])
    if turn is not None:
        ends = ends @ turn.T + shift
    flat = ends[:, :, [first, second]]
    quads = [np.array([a[0], a[1], b[1], b[0]]) for a, b in zip(flat[:-1], flat[1:], strict=True)]
    axes.add_collection(PolyCollection(quads, facecolors=PALE, edgecolors=PALE, linewidths=3.5, zorder=0))


def arrow(axes: Axes, start: np.ndarray, end: np.ndarray, colour: str, width: float = 1.6) -> None:
    """An arrow between two points."""
    style = {"arrowstyle": "-|>", "color": colour, "lw": width, "shrinkA": 0, "shrinkB": 0, "mutation_scale": 11}
    axes.annotate("", end, start, arrowprops=style, zorder=4)


def plain(axes: Axes, title: str, xlabel: str, ylabel: str) -> None:
    """Equal scales, no grid."""
    axes.set(title=title, xlabel=xlabel, ylabel=ylabel, aspect="equal")
    axes.grid(False)


def frames() -> Figure:
    """Head axes, body axes and the three angles, each turned alone."""
    jaw = build_jaw()
    figure, (side, top, front) = canvas(10.2, 4.1, 1, 3, width_ratios=(1.2, 1.0, 1.0))
    x_mm, angle = 8.0, 0.35
    height = 1e3 * fossa(jaw, 1e-3 * x_mm)[0]
    star = np.array([x_mm, 0.0, height])
    turn = np.array(rotation((0.0, 0.0, angle, 0.0, 0.0)))
    bone(side, 0, 2, turn, star)
    path = outlines.condyle_path(2.8e-3, 245.0)
    side.plot(*path[(path[:, 0] > -2) & (path[:, 0] < 18)].T, color=INK, lw=1.4)
    for axis, name in ((np.array([34.0, 0]), "x"), (np.array([0, 26.0]), "z")):
        arrow(side, np.zeros(2), axis, GREY)
        side.text(*(axis * 1.09), name, color=GREY, ha="center", va="center")
        body = turn[np.ix_([0, 2], [0, 2])] @ axis
        arrow(side, star[[0, 2]], star[[0, 2]] + body, BLUE)
        side.text(*(star[[0, 2]] + body * 1.11), f"{name}$_b$", color=BLUE, ha="center", va="center")
    for point, name, where in (
        (jaw["centre_of_mass"], "centre of mass", (4, -3)),
        (jaw["mouthpiece"], "mouthpiece", (2, -7)),
    ):
        place = (star + turn @ (1e3 * point))[[0, 2]]
        side.plot(*place, "o", color=INK, ms=4, zorder=5)
        side.annotate(name, place, xytext=where, textcoords="offset points", va="top")
    side.plot(0, 0, "o", color=GREY, ms=4)
    side.plot(*star[[0, 2]], "o", color=BLUE, ms=5, zorder=5)
    side.text(-3, 1, "o", color=GREY, ha="right")
    side.annotate("∗", star[[0, 2]], xytext=(-9, -13), textcoords="offset points", color=BLUE, size=13)
    side.add_patch(Arc(star[[0, 2]], 48, 48, theta1=-np.degrees(angle), theta2=0, color=RED, lw=1.4))
    side.plot([x_mm, x_mm + 34], [height, height], color=GREY, lw=0.8, ls=(0, (4, 3)))
    side.text(x_mm + 26.5, height - 7.0, r"$\theta$", color=RED, size=11)
    plain(side, "1. pitch θ about y: opening", FORWARD, UP)
    side.set(xlim=(-14, 112), ylim=(-112, 34))

    for axes, (a, b), angles, name, title in (
        (top, (1, 0), (0.0, 0.22, 0.0), r"$\psi$", "2. yaw ψ about z: from above"),
        (front, (1, 2), (0.0, 0.0, 0.22), r"$\alpha$", "3. roll α about x: from the front"),
    ):
        turn = np.array(rotation((0.0, 0.0, *angles)))
        bone(axes, a, b, turn, np.zeros(3))
        arms = np.array([[0, -56, 0], [0, 56, 0]]) if axes is top else np.array([[0, -66, 0], [0, 66, 0]])
        axes.plot(arms[:, a], arms[:, b], color=GREY, lw=0.8, ls=(0, (4, 3)))
        turned = arms @ turn.T
        axes.plot(turned[:, a], turned[:, b], color=BLUE, lw=1.2)
        long = np.array([100.0, 0, 0]) if axes is top else np.array([0, 0, -95.0])
        axes.plot([0, long[a]], [0, long[b]], color=GREY, lw=0.8, ls=(0, (4, 3)))
        tip = turn @ long
        axes.plot([0, tip[a]], [0, tip[b]], color=BLUE, lw=1.2)
        axes.plot(0, 0, "o", color=BLUE, ms=5)
        middle = 0.68 * (long + tip) / 2
        from_, to = sorted(np.degrees([np.arctan2(v[b], v[a]) for v in (long, tip)]))
        axes.add_patch(Arc((0, 0), 116, 116, theta1=from_, theta2=to, color=RED, lw=1.4))
        axes.text(middle[a], middle[b], name, color=RED, size=11, ha="center", va="center")
        plain(axes, title, LEFT, FORWARD if axes is top else UP)
    top.set(xlim=(70, -70), ylim=(-18, 106))
    front.set(xlim=(-70, 70), ylim=(-98, 22))
    return figure


def stretches_when_open(opening: float) -> np.ndarray:
    """Stretch (l - l_o)/l_o of masseter, temporalis, medial pterygoid of the trismus median jaw held open (m)."""
    jaw, muscles, pose = build_jaw(), np.tile([1.2, 7.0], (6, 1)), np.array([3e-3, 0.0, 0.05, 0.0, 0.0])
    scratch = np.zeros(1, dtype=filter_scratch_dtype())[0], np.empty((5, 5)), np.empty(5)
    for held in np.linspace(0.0, opening, 8):
        settle(jaw, muscles, pose, held, True, *scratch)
    contact, turn = contact_point(jaw, tuple(pose)), rotation(tuple(pose))
    lengths = [muscle_pull(jaw, muscles, i, contact, turn)[2] for i in range(3)]
    return np.array(lengths) / jaw["l_o"][:3] - 1.0


def muscle_law() -> Figure:
    """Tension over stretch of the cohorts' median muscles, and what tells F_o from b."""
    figure, (linear, logs) = canvas(9.6, 3.7, 1, 2)
    stretch = np.linspace(-0.02, 0.35, 200)
    # Stretch of the masseter when the trismus median jaw is opened that far.
    shown = (("healthy", BLUE, "-"), ("trismus", RED, "-"), ("blockage", GREEN, (0, (5, 2))), ("severe", PINK, "-."))
    for name, colour, dash in shown:
        cohort = COHORTS[name].groups[0][0]
        tension = cohort.F_o_N * np.exp(cohort.b * stretch)
        label = rf"{name}: $F_o$ = {cohort.F_o_N:g} N, $b$ = {cohort.b:g}"
        linear.plot(100 * stretch, tension, color=colour, ls=dash, label=label)
        logs.plot(100 * stretch, tension, color=colour, ls=dash)
        if name == "trismus":
            rng = np.random.default_rng(0)
            drawn = np.array([COHORTS[name].draw_log_parameters(rng)[:2] for _ in range(4000)])
            band = np.exp(drawn[:, :1] + np.exp(drawn[:, 1:]) * stretch)
            low, high = np.percentile(band, [2.5, 97.5], axis=0)
            for axes in (linear, logs):
                axes.fill_between(100 * stretch, low, high, color=colour, alpha=0.13, lw=0, label="95 % of trismus")
    xlabel = r"stretch $(l - l_o)/l_o$ (%)"
    linear.set(title="The law", xlabel=xlabel, ylabel="tension of one muscle (N)", ylim=(0, 20), xlim=(-2, 35))
    linear.legend(loc="upper left")
    logs.set(title=r"Its logarithm: height $\log F_o$, slope $b$", xlabel=xlabel, yscale="log", xlim=(-2, 35))
    logs.set(ylabel="tension of one muscle (N)", ylim=(0.1, 200))
    logs.axvline(0, color=GREY, lw=0.9)
    logs.text(0.4, 0.115, "0", color=GREY, size=8)
    for name in ("10", "20", "35 mm open"):
        place = 100 * stretches_when_open(1e-3 * float(name.split()[0]))[0]
        logs.axvline(place, color=GREY, lw=0.9, ls=(0, (4, 3)))
        logs.text(place + 0.4, 0.115, name, color=GREY, size=8)
    return figure


MUSCLE_COLOURS = {"masseter": RED, "temporalis": BLUE, "medial_pterygoid": GREEN}


def muscle_lines() -> Figure:
    """Lines of action of portions and of whole muscles, and the row that was rejected."""
    figure, (side, front) = canvas(9.6, 5.0, 1, 2, width_ratios=(1.15, 1.0))
    for axes, (a, b) in ((side, (0, 2)), (front, (1, 2))):
        bone(axes, a, b)
        for muscle, portions in WHOLE_MUSCLES.items():
            for which in ("right",) if axes is side else ("left", "right"):
                lines = [attachment(portion, which) for portion in portions]
                weights = [line.strength_N for line in lines]
                ends = [np.array([1e3 * line.origin_m, 1e3 * line.insertion_m]) for line in lines]
                for end in ends:
                    axes.plot(end[:, a], end[:, b], color=MUSCLE_COLOURS[muscle], lw=1.0)
                whole = np.average(ends, axis=0, weights=weights)
                label = muscle.replace("_", " ") if which == "right" and axes is side else None
                axes.plot(whole[:, a], whole[:, b], color=MUSCLE_COLOURS[muscle], lw=3.2, alpha=0.75, label=label)
                axes.plot(whole[1, a], whole[1, b], "o", color=MUSCLE_COLOURS[muscle], ms=5)
        (rejected,) = [row for row in attachment_rows() if row.status == "rejected"]
        end = np.array([rejected.origin, rejected.insertion]) + [0.9, 0.9, 0.0]
        label = "deep masseter as printed, rejected" if axes is side else None
        axes.plot(end[:, a], end[:, b], color=ORANGE, lw=1.8, ls=(0, (2, 1.5)), label=label)
        jaw = build_jaw()
        condyles = np.array([[0, 50.0, 0], [0, -50.0, 0]])
        axes.plot(condyles[:, a], condyles[:, b], "s", color=INK, ms=5, label="condyle" if axes is side else None)
        axes.plot(
            *(1e3 * jaw["mouthpiece"])[[a, b]], "D", color=INK, ms=5, label="mouthpiece" if axes is side else None
        )
        axes.plot(
            *(1e3 * jaw["centre_of_mass"])[[a, b]],
            "P",
            color=INK,
            ms=6,
            label="centre of mass" if axes is side else None,
        )
    plain(side, "From the side", FORWARD, UP)
    plain(front, "From the front", LEFT, UP)
    side.set(xlim=(-18, 108), ylim=(-88, 44))
    front.set(xlim=(-72, 72), ylim=(-88, 44))
    figure.legend(*side.get_legend_handles_labels(), loc="outside lower center", ncols=4)
    return figure


def condyle_path() -> Figure:
    """The path of the condyle's centre, and the stops at both ends."""
    jaw = build_jaw()
    x = np.linspace(-3e-3, 17e-3, 401)
    heights = np.array([fossa(jaw, value)[:2] for value in x])
    figure, (path, stop) = canvas(7.0, 5.2, 2, 1, sharex=True, height_ratios=(1.5, 1.0))
    inside = (x >= 0) & (x <= jaw["crest"])
    path.plot(1e3 * x, 1e3 * heights[:, 0], color=GREY, lw=1.2, ls=(0, (4, 3)))
    path.plot(1e3 * x[inside], 1e3 * heights[inside, 0], color=BLUE, lw=2.4)
    steep = 0.5e3 * jaw["crest"]
    d = 1e3 * jaw["fossa_drop"]
    for place, name, where in (((0, 0), "roof", (0, 7)), ((2 * steep, -2 * d), "crest of the eminence", (0, -15))):
        path.plot(*place, "o", color=BLUE, ms=5)
        path.annotate(name, place, xytext=where, textcoords="offset points", ha="center")
    slope = jaw["fossa_drop"] * jaw["fossa_frequency"]
    run = np.array([-2.2, 2.2])
    path.plot(steep + run, -d - slope * run, color=RED, lw=1.2)
    path.annotate(f"steepest {np.degrees(np.arctan(slope)):.1f}°", (steep, -d), xytext=(8, 6),
                  textcoords="offset points", color=RED)  # fmt: skip
    path.set(title=r"$z = d\,(\cos f x - 1)$", ylabel=UP, ylim=(-7.2, 1.8))
    push = np.array([capsule_force(jaw, value)[0] for value in x])
    stop.plot(1e3 * x, push, color=ORANGE)
    stop.set(title="Capsule", xlabel="x of the condyle's centre, forward (mm)", ylabel="force forward (N)")
    for axes in (path, stop):
        axes.axvspan(-3, 0, color=ORANGE, alpha=0.10, lw=0)
        axes.axvspan(1e3 * jaw["crest"], 17, color=ORANGE, alpha=0.10, lw=0)
        axes.set(xlim=(-3, 17))
    return figure


def printed_equations() -> Figure:
    """Errors of equations as printed and as corrected, from the tests' own evaluation."""
    from printed_equations import errors_of_printed_equations

    rows = errors_of_printed_equations()[::-1]
    figure, (axes,) = canvas(9.6, 4.6, 1, 1)
    for place, row in enumerate(rows):
        scale = 180 / np.pi if row.unit == "degrees" else 1.0
        axes.plot([row.median / scale, row.largest / scale], [place, place], color=RED, lw=5, solid_capstyle="butt")
        axes.plot(row.median / scale, place, "o", color=RED, ms=7, mec="white", mew=0.8)
        axes.plot(max(row.corrected / scale, 1e-17), place, "D", color=BLUE, ms=6)
    axes.plot([], [], "o-", color=RED, lw=5, label="as printed: median (dot) to largest of 300 states")
    axes.plot([], [], "D", color=BLUE, label="corrected form, largest")
    labels = [f"{row.equation}\n{row.fault}" for row in rows]
    axes.set_yticks(range(len(rows)), labels, fontsize=8)
    axes.axvline(1.0, color=GREY, lw=0.9)
    axes.axvline(np.finfo(float).eps, color=GREY, lw=0.9, ls=(0, (4, 3)))
    axes.text(np.finfo(float).eps * 0.8, len(rows) - 0.45, "rounding", color=GREY, ha="right", va="bottom", size=8)
    axes.text(1.0, len(rows) - 0.45, "as large as the quantity", color=GREY, ha="right", va="bottom", size=8)
    axes.set(xscale="log", xlim=(3e-18, 1e3), xlabel="error relative to the quantity in question (4.28: radians)")
    axes.grid(axis="y", visible=False)
    figure.legend(loc="outside lower center", ncols=2)
    return figure


def opened_slowly(F_o: float, b: float, furthest: float = 14e-3, pieces: int = 600) -> np.ndarray:
    """Equilibria of the symmetric jaw under a vertical force: rows of x (m), opening (m), force down (N).

    Then by the condyle's place, along which the branch has no folds: for each x the angle and the force at which
    neither accelerates.
    """
    from scipy.optimize import root

    jaw, muscles, pose = build_jaw(), np.tile([F_o, b], (6, 1)), np.array([3e-3, 0.0, 0.05, 0.0, 0.0])
    scratch = np.zeros(1, dtype=filter_scratch_dtype())[0], np.empty((5, 5)), np.empty(5)
    settle(jaw, muscles, pose, 0.0, False, *scratch)
    rows = [(pose[0], opening_of(jaw, pose), 0.0)]
    # The teeth part first, by the opening: until then the condyle hardly moves, and may move back.
    for opening in np.arange(rows[0][1], 5e-3, 0.2e-3):
        force, _ = settle(jaw, muscles, pose, opening, True, *scratch)
        rows.append((pose[0], opening_of(jaw, pose), force))
    log_parameters, guess = np.log(muscles).ravel(), np.array([pose[2] / 0.1, rows[-1][2]])
    for x in np.linspace(pose[0], furthest, pieces)[1:]:

        def left_over(unknown: np.ndarray, x: float = x) -> np.ndarray:
            theta, force = 0.1 * unknown[0], unknown[1]
            down = [force * np.sin(theta), 0.0, -force * np.cos(theta)]
            return acceleration(jaw, [x, 0, theta, 0, 0], np.zeros(5), log_parameters, down)[[0, 3]]

        found = root(left_over, guess, tol=1e-12)
        if np.abs(found.fun).max() > 1e-5:
            break
        guess = found.x
        rows.append((x, opening_of(jaw, np.array([x, 0.0, 0.1 * guess[0], 0.0, 0.0])), guess[1]))
    return np.array(rows)


def opening_of(jaw: np.void, pose: np.ndarray) -> float:
    """How far the mouthpiece is below its place in the closed jaw (m)."""
    place = np.array(contact_point(jaw, tuple(pose))) + np.array(rotation(tuple(pose))) @ jaw["mouthpiece"]
    return float(jaw["mouthpiece"][2] - place[2])


def first_fold(values: np.ndarray) -> int:
    """Number of the first maximum along the branch."""
    return int(np.flatnonzero(np.diff(values) < 0)[0])


def painless_end(branch: np.ndarray) -> int:
    """Number of the last pose of the painless range."""
    x, opening, force = branch.T
    furthest = opening[0] + min(beginning.PAINLESS_RANGE, beginning.LARGEST_OPENING - opening[0])
    condyle = beginning.CREST_SHARE * build_jaw()["crest"] - beginning.CONDYLE_FREE
    return int(np.flatnonzero((force > beginning.PAINLESS_FORCE) | (opening > furthest) | (x > condyle))[0]) - 1


def equilibrium() -> Figure:
    """Force and condyle over opening on the branch that starts at rest, with its folds."""
    jaw = build_jaw()
    figure, (pull, slide) = canvas(7.6, 6.4, 2, 1, sharex=True, height_ratios=(1.5, 1.0))
    for F_o, name, colour in ((0.25, "healthy", BLUE), (1.2, "trismus", RED), (4.0, "severe", PINK)):
        branch = opened_slowly(F_o, 7.0)
        x, opening, force = branch.T
        of_force, of_opening, end = first_fold(force), first_fold(opening), painless_end(branch)
        label = rf"{name}: $F_o$ = {F_o:g} N, $b$ = 7"
        for axes, values in ((pull, force), (slide, 1e3 * x)):
            first = min(of_force, of_opening)
            axes.plot(1e3 * opening[: first + 1], values[: first + 1], color=colour, label=label)
            axes.plot(1e3 * opening[first:], values[first:], color=colour, lw=1.2, ls=(0, (2, 1.5)))
            axes.plot(1e3 * opening[0], values[0], "o", color=colour, ms=6, clip_on=False)
            axes.plot(1e3 * opening[end], values[end], "s", color=colour, ms=7, mfc="white", mew=1.6)
            axes.plot(1e3 * opening[of_force], values[of_force], "v", color=colour, ms=7)
            axes.plot(1e3 * opening[of_opening], values[of_opening], ">", color=colour, ms=7)
    for marker, name, fill in (
        ("o", "rest", INK),
        ("s", "end of the painless range", "white"),
        ("v", "fold under a prescribed force", INK),
        (">", "fold under a prescribed opening", INK),
    ):
        pull.plot([], [], marker, color=INK, mfc=fill, label=name, ls="none")
    pull.plot([], [], color=INK, lw=1.2, ls=(0, (2, 1.5)), label="beyond the first fold")
    pull.axhline(beginning.PAINLESS_FORCE, color=GREY, lw=0.9, ls=(0, (4, 3)))
    pull.text(0.4, beginning.PAINLESS_FORCE + 0.3, f"{beginning.PAINLESS_FORCE:g} N", color=GREY, size=8)
    slide.axhline(1e3 * jaw["crest"], color=GREY, lw=0.9, ls=(0, (4, 3)))
    slide.text(0.4, 1e3 * jaw["crest"] - 0.3, "crest", color=GREY, size=8, va="top")
    pull.set(title="Vertical force that holds the mouth open", ylabel="force down (N)", ylim=(0, 34), xlim=(-1.5, 50))
    slide.set(title="The condyle slides as the jaw opens", ylabel="x of the condyle (mm)", ylim=(0, 15))
    slide.set(xlabel="opening at the incisors (mm)")
    figure.legend(*pull.get_legend_handles_labels(), loc="outside lower center", ncols=2)
    return figure


def friction() -> Figure:
    """Opening and closing in 20 s in the plane, with contact and Coulomb friction."""
    import sagittal_plane as plane
    from test_sagittal_against_midline import MOST, SECONDS, rising

    from jawenv.mechanics.sagittal import SagittalJaw

    jaw = plane.flat_jaw()
    figure, (loops, lags) = canvas(9.6, 3.8, 1, 2, width_ratios=(1.7, 1.0))
    reference = plane.midline_opening(jaw, SECONDS, rising)
    heights = np.column_stack([reference[:, 0], [fossa(jaw, x)[0] for x in reference[:, 0]], reference[:, 1]])
    times = 0.01 * np.arange(1, 1 + 100 * int(SECONDS))
    for mu, colour, dash in ((0.0, BLUE, "-"), (0.0145, GREEN, "-"), (0.05, ORANGE, "-"), (0.2, RED, "-")):
        sagittal = SagittalJaw(jaw, plane.muscles(), teeth="elastic", friction=mu)
        sagittal.settle(*plane.midline_rest(jaw))
        states = plane.pulled_down(sagittal, 2 * SECONDS, lambda t: rising(SECONDS - abs(SECONDS - t)))
        opening = 1e3 * plane.opening(jaw, states)
        force = np.concatenate([rising(times), rising(times[::-1] - 0.01)])
        loops.plot(opening, force, color=colour, ls=dash, lw=1.4, label=f"friction {mu:g}")
        up, down = opening[:1000], opening[1998:998:-1]
        lags.plot(rising(times), down - up, color=colour, lw=1.4)
        lags.plot(2.5, (down - up)[499], "o", color=colour, ms=5)
    opening = 1e3 * plane.opening(jaw, np.column_stack([heights, np.zeros((len(heights), 3))]))
    loops.plot(opening[::60], rising(times)[::60], "x", color=INK, ms=5, label="midline model, opening")
    loops.set(title="Opening and closing", xlabel="opening at the incisors (mm)", ylabel="force down (N)")
    loops.set(ylim=(0, MOST * 1.04))
    loops.legend(loc="upper left")
    lags.set(title="Width of the loop", xlabel="force down (N)", ylabel="closing less opening (mm)", xlim=(0, MOST))
    lags.set(ylim=(0, None))
    return figure


def midline_rests(wrenches: np.ndarray) -> np.ndarray:
    """Poses (n, 5) of the midline model at rest under wrenches (n, 6) that grow, by Newton's method from the last."""
    from scipy.optimize import root

    jaw, log_parameters = build_jaw(), np.log(np.tile([1.2, 7.0], 6))
    pose, units, rows = np.array([3e-3, 0.0, 0.05, 0.0, 0.0]), np.array([1e-3, 1e-3, 0.1, 0.1, 0.1]), []
    muscles, scratch = np.exp(log_parameters).reshape(6, 2), np.zeros(1, dtype=filter_scratch_dtype())[0]
    settle(jaw, muscles, pose, 0.0, False, scratch, np.empty((5, 5)), np.empty(5))
    for wrench in wrenches:

        def left_over(scaled: np.ndarray, wrench: np.ndarray = wrench) -> np.ndarray:
            # Scaled to size: where there is no rest the search may run away.
            return acceleration(jaw, np.clip(scaled * units, -1, 1), np.zeros(5), log_parameters, wrench)

        # An exact zero, where rounding left 1e-18: MINPACK's differences are relative.
        found = root(left_over, np.round(pose / units, 12), tol=1e-13)
        if np.abs(found.fun).max() > 1e-5:
            break
        pose = found.x * units
        rows.append(pose)
    rows += [np.full(5, np.nan)] * (len(wrenches) - len(rows))
    return np.array(rows)


def bilateral() -> Figure:
    """Rest under a side force and under a roll moment: one point in the middle against two condyles on discs."""
    from jawenv.mechanics.bilateral import condyle_pressures, put_on_fossa, settle_bilateral, split_body

    jaw, muscles = build_jaw(), np.tile([1.2, 7.0], (6, 1))
    figure, axes = canvas(9.6, 5.6, 2, 2, sharex="col", height_ratios=(1.3, 1.0))
    for column, (index, most, sign, title, xlabel) in enumerate((
        (1, 1.5, 1.0, "Side force to the left", "force at the mouthpiece (N)"),
        (3, 0.5, 1.0, "Moment that rolls the jaw", "moment (N m)"),
    )):  # fmt: skip
        size = np.linspace(0, most, 41)
        wrenches = np.zeros((len(size), 6))
        wrenches[:, index] = sign * size
        midline = midline_rests(wrenches)
        poses, pressures = [], []
        for wrench in wrenches:
            state = np.empty(12)
            put_on_fossa(jaw, midline[0], state)
            found = settle_bilateral(jaw, muscles, tuple(wrench), state, np.empty((6, 6)), np.empty(6))
            poses.append(state[3:6] if found else np.full(3, np.nan))
            pressures.append(condyle_pressures(jaw, *split_body(state)) if found else (np.nan, np.nan))
        two, press = np.degrees(poses), np.array(pressures)
        one = np.degrees(midline[:, 2:])
        turn, load = axes[column], axes[2 + column]
        for number, name, colour in ((1, "yaw", BLUE), (2, "roll", RED)):
            turn.plot(size, one[:, number], color=colour, ls=(0, (5, 2)), label=f"{name}, midline model")
            turn.plot(size, two[:, number], color=colour, label=f"{name}, two condyles")
        load.plot(size, press[:, 0], color=INK, label="left condyle")
        load.plot(size, press[:, 1], color=ORANGE, ls=(0, (5, 2)), label="right condyle")
        lifted = np.flatnonzero(press.min(axis=1) == 0.0)
        if len(lifted):
            for each in (turn, load):
                each.axvspan(size[lifted[0]], most, color=ORANGE, alpha=0.12, lw=0)
            load.text(size[lifted[0]] + 0.01 * most, 0.93, "right condyle lifted off", size=8, va="top",
                      transform=load.get_xaxis_transform())  # fmt: skip
        turn.set(title=title, ylabel="angle (degrees)", xlim=(0, most))
        load.set(xlabel=xlabel, ylabel="force on the disc (N)", ylim=(0, None))
    axes[1].legend(loc="upper left")
    axes[2].legend(loc="upper left")
    return figure


def integration() -> Figure:
    """Error of ten seconds of motion over the step, against steps of 0.05 ms, and the cost of the true motion."""
    from jaw_motion import motion, random_patient
    from test_trajectories import SECONDS, therapy

    figure, (place, turn) = canvas(9.6, 3.6, 1, 2)
    start = np.array([3e-3, 0, 0.1, 0, 0, 0, 0, 0, 0, 0])
    steps = np.array([10e-3, 5e-3, 2.5e-3, 1.25e-3, 0.625e-3])
    cases = (("trismus", 4.0, 0.5, BLUE, "o", "opened wide and shifted"),
             ("severe", 10.0, 1.0, RED, "s", "snapping shut onto teeth and fossa"))  # fmt: skip
    for cohort, down, side, colour, marker, name in cases:
        log_parameters, jaw, wrench = random_patient(np.random.default_rng(3), cohort), build_jaw(), therapy(down, side)
        fine = motion(jaw, log_parameters, start, wrench, 0.05e-3, round(SECONDS / 0.05e-3))[::200]
        errors = []
        for step in steps:
            states = motion(jaw, log_parameters, start, wrench, step, round(SECONDS / step))[:: round(10e-3 / step)]
            off = np.abs(states - fine)
            errors.append((off[:, :2].max(), off[:, 2:5].max()))
        for axes, values, unit in ((place, np.array(errors)[:, 0], 1e6), (turn, np.array(errors)[:, 1], 1e3)):
            axes.plot(1e3 * steps, unit * values, marker=marker, color=colour, label=name)
    place.plot(1e3 * steps, 0.5 * steps**4 / 5e-3**4, color=GREY, lw=1.0, ls=(0, (4, 3)), label="fourth order")
    turn.plot(1e3 * steps, 0.01 * steps**4 / 5e-3**4, color=GREY, lw=1.0, ls=(0, (4, 3)))
    for axes, noise, text in (
        (place, 100.0, "encoder noise 0.1 mm"),
        (turn, 1e3 * np.radians(0.1), "encoder noise 0.1°"),
    ):
        axes.axhline(noise, color=GREEN, lw=1.0)
        axes.text(0.6, noise * 1.15, text, color=GREEN, size=8, va="bottom")
        axes.axvline(5, color=GREY, lw=0.9)
        axes.set(xscale="log", yscale="log", xlabel="step (ms)")
        axes.set_xticks(1e3 * steps, [f"{1e3 * step:g}" for step in steps])
        axes.minorticks_off()
    place.set(title="Place of the condyle", ylabel="largest error in 10 s (µm)")
    turn.set(title="Angles", ylabel="largest error in 10 s (mrad)", ylim=(None, 300))
    for axes in (place, turn):
        axes.text(4.8, axes.get_ylim()[0] * 2, "true motion", color=GREY, size=8, rotation=90, ha="right", va="bottom")
        axes.text(9.6, axes.get_ylim()[0] * 2, "filter", color=GREY, size=8, rotation=90, ha="right", va="bottom")
    turn.legend(*place.get_legend_handles_labels(), loc="upper left")
    return figure


FIGURES: dict[str, Callable[[], Figure]] = {
    "frames": frames,
    "muscle_law": muscle_law,
    "muscle_lines": muscle_lines,
    "condyle_path": condyle_path,
    "printed_equations": printed_equations,
    "equilibrium": equilibrium,
    "integration": integration,
    "friction": friction,
    "bilateral": bilateral,
}


def freeze(figure: Figure) -> None:
    """Round what the layout found: its last bits differ from run to run, and the names in the SVG hang on them."""
    figure.draw_without_rendering()
    figure.set_layout_engine("none")
    for axes in figure.axes:
        axes.set_position(np.round(axes.get_position(original=True).bounds, 4))


def make(name: str, folder: Path = FOLDER, form: str = "svg") -> Path:
    """Draw one figure and write it to ``folder``; returns the file."""
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{name}.{form}"
    with mpl.rc_context(STYLE):
        figure = FIGURES[name]()
        freeze(figure)
        metadata = {"Date": None} if form == "svg" else {}
        figure.savefig(path, metadata=metadata, dpi=110)
    if form == "svg":  # matplotlib leaves blanks at the ends of lines
        lines = path.read_text(encoding="utf-8").splitlines()
        path.write_text("\n".join(line.rstrip() for line in lines) + "\n", encoding="utf-8")
    return path


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description="Make the figures of docs/model.md.")
    parser.add_argument("names", nargs="*", choices=[[], *FIGURES], metavar="NAME", help=", ".join(FIGURES))
    parser.add_argument("--folder", type=Path, default=FOLDER)
    parser.add_argument("--format", default="svg", choices=["svg", "png"])
    given = parser.parse_args()
    for name in given.names or FIGURES:
        print(make(name, given.folder, given.format))


if __name__ == "__main__":
    main()
