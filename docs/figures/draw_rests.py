"""Figures of jaws at rest: opened slowly, and under a load from one side."""

from __future__ import annotations

import numpy as np
from drawing_style import BLUE, GREY, INK, PINK, RED, canvas
from matplotlib.figure import Figure

from jawenv.device.comfort_settings import Comfort
from jawenv.envs.world import reset_kernel
from jawenv.mechanics import build_jaw
from jawenv.mechanics.acceleration import acceleration
from jawenv.mechanics.dynamics import linear_dtype
from jawenv.mechanics.equilibrium import settle
from jawenv.mechanics.opening import opening_of

COMFORT = Comfort().in_si()


def opened_slowly(F_o: float, b: float, furthest: float = 14e-3, pieces: int = 600) -> np.ndarray:
    """Equilibria of the symmetric jaw under a vertical force: rows of x (m), opening (m), force down (N).

    Then by the condyle's place, along which the branch has no folds: for each x the angle and the force at which
    neither accelerates.
    """
    from scipy.optimize import root

    jaw, muscles, pose = build_jaw(), np.tile([F_o, b], (6, 1)), np.array([3e-3, 0.0, 0.05, 0.0, 0.0])
    scratch = np.zeros(1, dtype=linear_dtype(6))[0], np.empty((5, 5)), np.empty(5)
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


def first_fold(values: np.ndarray) -> int:
    """Number of the first maximum along the branch."""
    return int(np.flatnonzero(np.diff(values) < 0)[0])


def painless_end(branch: np.ndarray) -> int:
    """Number of the last pose of the painless range."""
    x, opening, force = branch.T
    furthest = opening[0] + min(COMFORT["painless_range"], COMFORT["largest_opening"] - opening[0])
    condyle = reset_kernel.CREST_SHARE * build_jaw()["crest"] - COMFORT["condyle_free"]
    return int(np.flatnonzero((force > COMFORT["painless_force"]) | (opening > furthest) | (x > condyle))[0]) - 1


def equilibrium() -> Figure:
    """Force and condyle over opening on the branch that starts at rest, with its folds."""
    jaw = build_jaw()
    figure, (pull, slide) = canvas(7.6, 6.4, 2, 1, sharex=True, height_ratios=(1.5, 1.0))
    for F_o, b, name, colour in (
        (0.7, 7.0, "healthy", BLUE),
        (4.0, 10.0, "trismus", RED),
        (10.0, 10.0, "severe", PINK),
    ):
        branch = opened_slowly(F_o, b)
        x, opening, force = branch.T
        of_force, of_opening, end = first_fold(force), first_fold(opening), painless_end(branch)
        label = rf"{name}: $F_o$ = {F_o:g} N, $b$ = {b:g}"
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
    pull.axhline(COMFORT["painless_force"], color=GREY, lw=0.9, ls=(0, (4, 3)))
    pull.text(0.4, COMFORT["painless_force"] + 0.3, f"{COMFORT['painless_force']:g} N", color=GREY, size=8)
    slide.axhline(1e3 * jaw["crest"], color=GREY, lw=0.9, ls=(0, (4, 3)))
    slide.text(0.4, 1e3 * jaw["crest"] - 0.3, "crest", color=GREY, size=8, va="top")
    pull.set(title="Vertical force that holds the mouth open", ylabel="force down (N)", ylim=(0, 60), xlim=(-1.5, 50))
    slide.set(title="The condyle slides as the jaw opens", ylabel="x of the condyle (mm)", ylim=(0, 15))
    slide.set(xlabel="opening at the incisors (mm)")
    figure.legend(*pull.get_legend_handles_labels(), loc="outside lower center", ncols=2)
    return figure
