"""Entries of several seeds of training against a reference and their replays."""

import io

import numpy as np
import pandas as pd
import pytest
from rich.console import Console

from eval.comparison.results import Results
from eval.comparison.trainings import DIFFERENCES, gains
from eval.figures.statistics import mean, mean_over_both
from eval.report import table

PATIENTS = 30
SHIFTS = {"ppo-seed0": -0.2, "ppo-seed1": -0.1, "ppo-seed2": 0.0, "ppo": -0.5, "base": 0.0}


def compared() -> Results:
    """Every entry's figures are nearly those of the base, times exp(shift); replays are the base itself."""
    rng = np.random.default_rng(0)
    base = {name: rng.uniform(0.5, 1.5, PATIENTS) for name in DIFFERENCES}
    tables, entries = [], []
    for label, shift in SHIFTS.items():
        columns = {name: values * np.exp(rng.normal(shift, 1e-3, PATIENTS)) for name, values in base.items()}
        entries.append({"label": label, "trained": "seed" in label, "planned": label == "ppo"})
        tables.append(pd.DataFrame({"entry": label, "patient": np.arange(PATIENTS), **columns}))
        if "seed" in label:
            for kind in ("replay", "yoked replay"):
                entries.append({"label": f"{kind} of {label}", "trained": False, "replay_of": label})
                tables.append(pd.DataFrame({"entry": f"{kind} of {label}", "patient": np.arange(PATIENTS), **base}))
    return Results(pd.concat(tables), pd.DataFrame(), {"entries": entries})


def test_every_seed_then_all_of_them_against_the_reference_and_each_replay():
    found = gains(compared(), "base")
    seeds = ["ppo-seed0", "ppo-seed1", "ppo-seed2", "ppo"]
    # What has no seed in its name is none of them.
    assert [each.name for each in found] == [*seeds, *seeds, *seeds, "ppo"]
    assert [each.against for each in found[3::4]] == ["base", "its replay", "its yoked replay"]
    assert [each.figures["worst_sd"].value for each in found[:4]] == pytest.approx([-0.2, -0.1, 0.0, -0.1], abs=1e-3)
    assert [each.seeds for each in found[:4]] == [1, 1, 1, 3]
    alone, together = found[1].figures["worst_sd"], found[3].figures["worst_sd"]
    assert alone.high - alone.low < 2e-3 and together.low < -0.15 and together.high > -0.05
    assert len(gains(compared(), None)) == 8  # without a reference against the replays alone


def test_an_interval_over_both_is_that_over_patients_where_seeds_agree():
    values = np.random.default_rng(1).normal(size=200)
    both, alone = mean_over_both(np.array([values, values, values])), mean(values)
    assert both.value == pytest.approx(alone.value)
    assert both.high - both.low == pytest.approx(alone.high - alone.low, rel=0.1)


def test_an_interval_over_both_covers_the_mean_of_all_seeds_and_patients():
    rng = np.random.default_rng(2)
    covered = 0
    for _ in range(200):
        of_seed, of_patient = 0.5 * rng.normal(size=(12, 1)), rng.normal(size=(1, 40))
        found = mean_over_both(of_seed + of_patient + 0.5 * rng.normal(size=(12, 40)))
        covered += found.low <= 0.0 <= found.high
    assert covered >= 176
    assert not mean_over_both(np.ones((1, 5))).exists


def test_they_are_printed_and_written(tmp_path):
    found = gains(compared(), "base")
    console = Console(file=io.StringIO(), width=140)
    table.gains_table(found, table.GAINS_SHOWN).show(console)
    assert "ppo" in console.file.getvalue() and "its yoked replay" in " ".join(console.file.getvalue().split())
    lines = table.gains_table(found).markdown().splitlines()
    assert len(lines) == 2 + len(found) and lines[5].startswith("| ppo | base | 3 | −0.1")
