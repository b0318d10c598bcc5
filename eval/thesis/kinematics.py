"""Figs. 6.1 and 6.2: from the measured mouthpiece to the condyle on the fossa."""

from __future__ import annotations

import numpy as np
import pandas as pd

from eval.figures import statistics
from eval.thesis import rows
from eval.thesis.item import NO_NUMBER, Item, Judgement, judged, one_by_one
from eval.thesis.methods.point_kinematics import compatible_range
from eval.thesis.prescribed import with_noise
from eval.thesis.settings import DEVICE, lowering_then_sideways
from jawenv.recordings import defaults

POINTS = 60
CLOSE_MM = 0.5  # a condyle that is found this closely follows the path that the figure shows
BOUNDS = (np.array([-5e-4, -5e-3, 0.0, -0.2, -0.2]), np.array([12.8e-3, 5e-3, 0.7, 0.2, 0.2]))
"""Limits of x, y (m), theta, psi, alpha (rad): 5 mm and 11 degrees to each side."""


def draw(rng: np.random.Generator) -> pd.DataFrame:
    """Condyle and three points of the mandible at some times, found from noisy readings of pose and of the point."""
    clean = lowering_then_sideways()
    noisy = with_noise(clean, DEVICE, rng)
    assert clean.states is not None, "a prescribed motion has its states"
    rows = []
    for k in np.linspace(0, len(clean.time) - 1, POINTS).astype(int):
        point = np.full(12, np.nan)
        point[:3], point[6:9] = noisy.measured[k, :3], noisy.measured[k, 6:9]
        row = {"time_s": clean.time[k], "theta_deg": np.degrees(clean.states[k, 2])}
        row |= {
            f"true_{axis}_mm": value for axis, value in zip("xyz", _condyle(clean.jaw, clean.states[k]), strict=True)
        }
        for name, reading in (("pose", noisy.measured[k]), ("point", point)):
            state = defaults.motion_of_reading(clean.jaw, reading, clean.measurement_sd)
            row |= {f"{name}_{axis}_mm": v for axis, v in zip("xyz", _condyle(clean.jaw, state), strict=True)}
        row |= {f"mouth_{axis}_mm": 1e3 * clean.measured[k, i] for i, axis in enumerate("xyz")}
        rows.append(row)
    return pd.DataFrame(rows)


def _condyle(jaw: object, state: np.ndarray) -> tuple[float, float, float]:
    """Mm in head axes."""
    drop, frequency = float(jaw["fossa_drop"]), float(jaw["fossa_frequency"])  # type: ignore[index]
    return 1e3 * state[0], 1e3 * state[1], 1e3 * drop * (np.cos(frequency * state[0]) - 1.0)


def _aside_range() -> np.ndarray:
    """(2,) mm: range of a condyle's position aside, with the mouthpiece as far aside as in Fig. 6.1."""
    clean = lowering_then_sideways()
    assert clean.states is not None, "a prescribed motion has its states"
    furthest = clean.states[np.argmax(np.abs(clean.measured[:, 1]))]
    return 1e3 * np.asarray(compatible_range(clean.jaw, furthest[:5], *BOUNDS)[1])


def _errors(table: pd.DataFrame, name: str) -> np.ndarray:
    """Root mean square error of the condyle's place in each draw, mm."""
    estimated, true = (table[[f"{source}_{axis}_mm" for axis in "xyz"]].to_numpy() for source in (name, "true"))
    squares = pd.Series(((estimated - true) ** 2).sum(axis=1)).groupby(table["draw"].to_numpy()).mean()
    return np.asarray(np.sqrt(squares.to_numpy()))


def judge(table: pd.DataFrame) -> Judgement:
    """Whether the path is found, from the pose and from the one point that the thesis measures."""
    pose, point = (statistics.mean(_errors(table, name)) for name in ("pose", "point"))
    first = table[table["draw"] == table["draw"].min()]
    opened = first["theta_deg"].idxmax()
    forward, down = first.loc[opened, "pose_x_mm"], -first.loc[opened, "pose_z_mm"]
    path_known = pose.value < CLOSE_MM and forward > 0.0 and down > 0.0
    aside = _aside_range()
    figures = {
        "condyle's error from the pose, mm": pose,
        "condyle's error from the place, the smallest motion taken, mm": point,
        "condyle forward, fully open, mm": rows.alone(forward),
        "condyle down, fully open, mm": rows.alone(down),
        "condyle to the left from the place alone, least, mm": rows.alone(float(aside[0])),
        "condyle to the left from the place alone, greatest, mm": rows.alone(float(aside[1])),
    }
    return judged(path_known and float(np.ptp(aside)) < 2.0 * CLOSE_MM, path_known, figures)


ITEM = Item(
    "kinematics",
    "Inverse kinematics",
    "Figs. 6.1, 6.2; section 6.1",
    "The condyle's path on the fossa is found from the mouthpiece in a lowering followed by a sideways motion; “by "
    f"limiting the bounds” the solution is unique. {NO_NUMBER}",
    "The jaw is lowered to 20° in 4 s and led 5° to the left; one reading at a time, without smoothing.",
    one_by_one(draw),
    judge,
)
