"""Logs of force and opening, made of the statics alone: a jaw that is opened slowly and let go again."""

import csv
from dataclasses import replace

import numpy as np

from jawenv.anatomy import cohort
from jawenv.recordings.stretcher.log import COLUMNS, StretchLog
from jawenv.recordings.stretcher.statics import Statics

TRISMUS = cohort("trismus")
MM = 25.0


def patient(seed=3, population=TRISMUS):
    return population.sample(1, seed)[0]


def log_of(theta, *, mm=MM, seed=0, creep=0.0, reference_mm=0.0):
    """30 s at 10 Hz, 0.5 mm and 0.3 N of noise; with ``creep`` the return takes so much less force."""
    rng, time = np.random.default_rng(seed), 0.1 * np.arange(300)
    opening = mm * np.sin(np.pi * time / 30.0) ** 2
    grid = np.linspace(0.5, mm, 25)
    force = np.interp(opening, np.append(0.0, grid), np.append(0.0, Statics().forces(theta, grid)))
    force *= np.where(time > 15.0, 1.0 - creep, 1.0)
    noise = rng.standard_normal((2, len(time)))
    return StretchLog("log", time, opening + reference_mm + 0.5 * noise[0], force + 0.3 * noise[1])


def written(log, path, names=COLUMNS, factors=(1.0, 1.0, 1.0)):
    """The log as a file, with names and units of one's own."""
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(names)
        for row in zip(log.time, log.opening, log.force, strict=True):
            writer.writerow([f"{factor * value:.6g}" for factor, value in zip(factors, row, strict=True)])
    return replace(log, path=str(path))
