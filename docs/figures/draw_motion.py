"""Figures of errors and motion: printed equations, the integration's step, friction."""

from __future__ import annotations

import numpy as np
from drawing_style import BLUE, GREEN, GREY, INK, ORANGE, RED, canvas
from matplotlib.figure import Figure

from jawenv.mechanics import build_jaw
from jawenv.mechanics.kinematics import fossa


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
        sagittal = SagittalJaw(jaw, plane.muscles(), friction=mu)
        sagittal.place(plane.on_path(jaw, *plane.midline_rest(jaw)))
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
