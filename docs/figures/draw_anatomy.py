"""Figures of what the model is made of: frames, muscles, the condyle's path."""

from __future__ import annotations

import numpy as np
from drawing_style import BLUE, FORWARD, GREEN, GREY, INK, LEFT, ORANGE, PINK, RED, UP, arrow, bone, canvas, plain
from matplotlib.figure import Figure
from matplotlib.patches import Arc

from jawenv.anatomy import COHORTS, WHOLE_MUSCLES, attachment, attachment_rows
from jawenv.mechanics import build_jaw
from jawenv.mechanics.dynamics import linear_dtype
from jawenv.mechanics.equilibrium import settle
from jawenv.mechanics.forces import capsule_force, muscle_pull
from jawenv.mechanics.kinematics import contact_point, fossa, rotation

MUSCLE_COLOURS = {"masseter": RED, "temporalis": BLUE, "medial_pterygoid": GREEN}


def frames() -> Figure:
    """Head axes, body axes and the three angles, each turned alone."""
    jaw = build_jaw()
    figure, (side, top, front) = canvas(10.2, 4.1, 1, 3, width_ratios=(1.2, 1.0, 1.0))
    x_mm, angle = 8.0, 0.35
    height = 1e3 * fossa(jaw, 1e-3 * x_mm)[0]
    star = np.array([x_mm, 0.0, height])
    turn = np.array(rotation((0.0, 0.0, angle, 0.0, 0.0)))
    bone(side, 0, 2, turn, star)
    path = [(x, 1e3 * fossa(jaw, 1e-3 * x)[0]) for x in np.linspace(-1.5, 17.5, 39)]
    side.plot(*np.transpose(path), color=INK, lw=1.4)
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
    scratch = np.zeros(1, dtype=linear_dtype(6))[0], np.empty((5, 5)), np.empty(5)
    for held in np.linspace(0.0, opening, 8):
        settle(jaw, muscles, pose, held, True, *scratch)
    contact, turn = contact_point(jaw, tuple(pose)), rotation(tuple(pose))
    lengths = [muscle_pull(jaw, muscles, i, contact, turn)[2] for i in range(3)]
    return np.array(lengths) / jaw["l_o"][:3] - 1.0


def muscle_law() -> Figure:
    """Tension over stretch of the cohorts' median muscles, and what tells F_o from b."""
    figure, (linear, logs) = canvas(9.6, 4.0, 1, 2)
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
    linear.set(title="The law", xlabel=xlabel, ylabel="tension of one muscle (N)", ylim=(0, 40), xlim=(-2, 35))
    figure.legend(
        *linear.get_legend_handles_labels(), loc="outside lower center", ncols=5, columnspacing=1.2, handlelength=1.8
    )
    logs.set(title=r"Its logarithm: height $\log F_o$, slope $b$", xlabel=xlabel, yscale="log", xlim=(-2, 35))
    logs.set(ylabel="tension of one muscle (N)", ylim=(0.4, 300))
    logs.axvline(0, color=GREY, lw=0.9)
    logs.text(0.4, 0.45, "0", color=GREY, size=8)
    for name in ("10", "20", "35 mm open"):
        place = 100 * stretches_when_open(1e-3 * float(name.split()[0]))[0]
        logs.axvline(place, color=GREY, lw=0.9, ls=(0, (4, 3)))
        logs.text(place + 0.4, 0.45, name, color=GREY, size=8)
    return figure


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
