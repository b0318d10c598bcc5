"""Worth of what ``jawenv identify`` says of a clinical stretcher's logs, force and opening alone.

    python -m research.stretcher --patients 48 > docs/tables/stretcher.md

Logs are of the environment: force control, both vertical motors alike, a force that grows and falls in 30 s. Rows have
noise of 0.5 mm and 0.3 N at 10 Hz. *Off*: what the patient has and nobody told, each drawn anew with the sds that are
assumed: teeth meet at another opening, tone of the muscles, tilt of the head. Coverage: share of believed logs whose
90 % interval has the truth. Error bars are sds of natural logs, of the median log. A row is printed as soon as it is
there.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

import jawenv
from jawenv.anatomy import cohort
from jawenv.recordings.stretcher.fit import Assumed
from jawenv.recordings.stretcher.identified import pulls, stretched
from jawenv.recordings.stretcher.log import StretchLog, log_of_record
from jawenv.recordings.stretcher.statics import Statics

Array = NDArray[np.float64]

SECONDS, STEPS_PER_S = 30.0, 20.0
LARGEST_N = {"severe": 40.0}
USUAL_N = 22.0
OPENINGS_MM = (15.0, 25.0)
BAND = (0.05, 0.95)
KNOWN = Assumed()
ALL = {"head_tilt_error_deg": KNOWN.tilt_deg, "closing_tone_error_N": KNOWN.tone_N}
OFF: Mapping[str, Any] = {
    "none": {"reality": {}, "reference_mm": 0.0},
    "reference, tone, tilt": {"reality": ALL, "reference_mm": KNOWN.reference_mm},
    "creep, 0.3": {"reality": {"creep_share": 0.3}, "reference_mm": 0.0},
}
NAMES = ("trismus", "one_sided", "severe")
ROWS = (
    *((name, name, "reference, tone, tilt") for name in NAMES),
    ("trismus", "trismus", "creep, 0.3"),
    *((name, name, "none") for name in NAMES),
    *((name, "anyone", "reference, tone, tilt") for name in NAMES),
)
"""Cohort, cohort that is assumed, what is off."""


class _Stretch:
    """A pull of both vertical motors that grows and falls."""

    control, steps_per_s = "force", STEPS_PER_S

    def reset(self, n: int, seed: int | None = None) -> None:
        """Begin at rest."""
        self._step = 0

    def predict(
        self, observation: Array, state: Any = None, episode_start: Any = None, deterministic: bool = True
    ) -> tuple[NDArray[np.float32], Any]:
        """The same action for every patient."""
        action = np.zeros((len(observation), 4), dtype=np.float32)
        action[:, :2] = np.sin(np.pi * self._step / STEPS_PER_S / SECONDS) ** 2
        self._step += 1
        return action, None


def _logs(name: str, patients: int, seed: int, off: str) -> tuple[list[StretchLog], Array]:
    """Logs of patients, and their natural-log parameters (n, 12)."""
    newton, effect = LARGEST_N.get(name, USUAL_N), OFF[off]
    world = {"cohort": name, "episode_s": SECONDS, "record": True, "track_bound": False, "reality": effect["reality"]}
    world["device"] = {"full_scale_N": newton / 2.0}
    if newton > USUAL_N:
        world["comfort"] = {"painless_force_N": newton, "force_N": newton}
    played = jawenv.play(_Stretch(), patients=patients, seed=seed, env_kwargs=world)
    assert played.records is not None
    shifts = effect["reference_mm"] * np.random.default_rng(seed).standard_normal(patients)
    found = [log_of_record(record, seed=seed + i) for i, record in enumerate(played.records)]
    return [replace(log, opening=log.opening + shift) for log, shift in zip(found, shifts, strict=True)], played.truth


def _row(name: str, assumed: str, off: str, patients: int, seed: int) -> list[str]:
    """Cells of a row."""
    statics, population = Statics(), cohort(assumed)
    curves: list[list[tuple[bool, float]]] = [[] for _ in OPENINGS_MM]
    total: list[tuple[bool, float]] = []
    told, refused = [], 0
    made, truth = _logs(name, patients, seed, off)
    begun = time.process_time()
    for log, theta in zip(made, truth, strict=True):
        found = stretched(log, population)
        refused += not found.believed
        if not found.believed:
            continue
        for mm, curve in zip(OPENINGS_MM, curves, strict=True):
            if mm in found.openings:
                draws = np.log(found.forces[:, list(found.openings).index(mm)])
                curve.append(_judged(draws, float(np.log(statics.forces(theta, np.array([mm]))[0]))))
        pull, true = pulls(found.theta), pulls(theta)
        total.append(_judged(pull["all"], float(true["all"])))
        told.append(np.std(pull["left : right"]) / np.std(pulls(found.prior)["left : right"]))
    seconds = (time.process_time() - begun) / patients
    cells = [name, assumed, off, f"{refused} of {patients}"]
    cells += [*map(_cell, curves), _cell(total)]
    return [*cells, f"{np.median(told):.2f}" if told else "", f"{seconds:.1f}"]


def _judged(draws: Array, truth: float) -> tuple[bool, float]:
    """Whether the 90 % interval has the truth, and the sd."""
    low, high = np.nanquantile(draws, BAND)
    return bool(low <= truth <= high), float(np.nanstd(draws))


def _cell(judged: list[tuple[bool, float]]) -> str:
    if not judged:
        return ""
    inside, sds = zip(*judged, strict=True)
    return f"{sum(inside)} of {len(inside)}, {100.0 * np.median(sds):.2g} %"


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--patients", type=int, default=48, help="of each row")
    parser.add_argument("--seed", type=int, default=450_000)
    arguments = parser.parse_args()
    print("# Logs of force and opening\n")
    print(f"`python -m research.stretcher --patients {arguments.patients} --seed {arguments.seed}`:\n")
    heads = ("patient", "assumed", "off", "refused", *(f"force at {mm:g} mm" for mm in OPENINGS_MM), "total pull")
    print(f"| {' | '.join((*heads, 'left : right, sd over prior', 's'))} |\n|---|---|---|{6 * '--:|'}", flush=True)
    for name, assumed, off in ROWS:
        print(f"| {' | '.join(_row(name, assumed, off, arguments.patients, arguments.seed))} |", flush=True)


if __name__ == "__main__":
    main()
