"""Figures of jaws at rest: opened slowly, and under a load from one side."""

from __future__ import annotations

import numpy as np
from drawing_style import BLUE, GREY, INK, ORANGE, PINK, RED, canvas
from matplotlib.figure import Figure

from jawenv.device.comfort_settings import Comfort
from jawenv.envs.world import reset_kernel
from jawenv.mechanics import build_jaw
from jawenv.mechanics.acceleration import acceleration
from jawenv.mechanics.dynamics import linear_dtype
from jawenv.mechanics.equilibrium import settle
from jawenv.mechanics.passive_opening import opening_of

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


def midline_rests(wrenches: np.ndarray) -> np.ndarray:
    """Poses (n, 5) of the midline model at rest under wrenches (n, 6) that grow, by Newton's method from the last."""
    from scipy.optimize import root

    jaw, log_parameters = build_jaw(), np.log(np.tile([4.0, 10.0], 6))
    pose, units, rows = np.array([3e-3, 0.0, 0.05, 0.0, 0.0]), np.array([1e-3, 1e-3, 0.1, 0.1, 0.1]), []
    muscles, scratch = np.exp(log_parameters).reshape(6, 2), np.zeros(1, dtype=linear_dtype(6))[0]
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
    from jawenv.mechanics.bilateral import condyle_pressures, put_on_fossa, settle_bilateral
    from jawenv.mechanics.kinematics import split_body

    jaw, muscles = build_jaw(), np.tile([4.0, 10.0], (6, 1))
    figure, axes = canvas(9.6, 5.6, 2, 2, sharex="col", height_ratios=(1.3, 1.0))
    for column, (index, most, sign, title, xlabel) in enumerate((
        (1, 5.0, 1.0, "Side force to the left", "force at the mouthpiece (N)"),
        (3, 1.5, 1.0, "Moment that rolls the jaw", "moment (N m)"),
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
    axes[2].legend(loc="lower left")
    return figure
