"""The share of the gap that an entry closes, on entries of known outcome."""

import math

import numpy as np
import pandas as pd
import pytest

from agents.clairvoyant import Clairvoyant
from eval.comparison.contest import contestants, markdown
from eval.comparison.cost import Cost, cost
from eval.comparison.results import Results, compare
from eval.figures.statistics import ratio_over_both
from eval.kept.entries import Settings, load_entries
from eval.kept.tables import made_with
from jawenv.base.errors import InputError
from jawenv.playing.policies.card import card_of

PATIENTS = 40
SHIFTS = {"refined": 0.0, "quick": -0.1, "apg-seed0": -0.2, "apg-seed1": -0.3, "clairvoyant": -0.5}
DISCOMFORT = {"quick": 1.0}


def compared(*without: str) -> Results:
    """Every entry's worst sd is that of the maneuver times exp(shift); replays are the maneuver itself."""
    rng, tables, entries = np.random.default_rng(0), [], []
    base = rng.uniform(0.01, 0.05, PATIENTS)

    def add(label, shift, **about):
        values = base * np.exp(rng.normal(shift, 1e-3, PATIENTS))
        columns = {
            "time_to_0.05_s": 100.0 * values,
            "verdicts_s": 2.0,
            "worst_sd": values,
            "rmse": values,
            "nees": 12.0,
            "duration_s": 10.0,
        }
        columns |= {"discomfort_s": DISCOMFORT.get(label, 0.01), "patient": np.arange(PATIENTS), "entry": label}
        entries.append({"label": label, **about})
        tables.append(pd.DataFrame(columns | {f"{kind}/{k}": 0.1 for kind in ("sd", "truth") for k in range(12)}))

    for label, shift in SHIFTS.items():
        if label in without:
            continue
        add(label, shift, trained="seed" in label, clairvoyant=label == "clairvoyant", planned=label == "clairvoyant")
        if "seed" in label:
            add(f"replay of {label}", 0.0, replay_of=label)
            add(f"yoked replay of {label}", 0.1, replay_of=label)
    about = made_with("eval compare", entries=entries, settings={"patients": PATIENTS, "seed": 5000})
    return Results(pd.concat(tables), pd.DataFrame(), about)


def test_seeds_are_one_row_on_a_scale_from_the_admitted_maneuver_to_the_clairvoyant():
    found = contestants(compared())
    assert [(row.name, row.seeds) for row in found] == [("clairvoyant", 1), ("apg", 2), ("quick", 1), ("refined", 1)]
    sure, late, verdicts, worst, closed, _, replay, yoked, discomfort, above, nees = found[1].figures
    assert 1.0 < sure.value < late.value < 5.0 and verdicts.value == 2.0
    assert (worst.value, replay.value, yoked.value) == pytest.approx((-0.25, -0.25, -0.35), abs=1e-3)
    assert (closed.value, closed.low, closed.high) == pytest.approx((50.0, 40.0, 60.0), abs=0.3)
    assert (discomfort.value, above.value, nees.value) == pytest.approx((0.01, 0.0, 1.0))
    assert found[2].figures[9].value == 100.0 and not found[0].figures[6].known


def test_a_page_has_a_table_for_each_comparison_its_command_and_the_bound():
    page = markdown({"trismus": compared(), "one_sided": compared()}, lambda about, settings: Cost(384000.0, 0.123))
    assert (
        page.count("| apg | 2 |") == 2
        and "## one_sided" in page
        and "`eval compare`, 20" in page
        and "seeds 5000–5039" in page
        and page.count("Static bound of the first 12 patients") == 2
    )
    assert page.count("| 384,000 | 0.12 |") == 8


def test_a_cost_has_the_steps_of_the_card_and_a_time():
    settings = Settings.of(patients=1, seed=5000, cohort="one_sided", episode_s=10.0).to_mapping()
    steps, spent_ms = cost({"spec": "apg_anyone"}, settings)
    assert steps == card_of("apg_anyone")[1].steps and 0.0 < spent_ms < 1000.0
    assert math.isnan(cost({"spec": "refined"}, settings).trained_steps)
    assert np.isnan([cost({"spec": gone}, settings) for gone in ("a_module:Agent", "runs/none")]).all()


def test_a_plans_time_is_that_of_the_comparison_and_no_plan_is_made(monkeypatch):
    monkeypatch.setattr(Clairvoyant, "_search", lambda *_: pytest.fail("planned once more"))
    planner = {"spec": "clairvoyant", "planned": True}
    settings = Settings.of(patients=1, seed=5000, episode_s=10.0).to_mapping()
    assert cost(planner | {"plan_ms": 1234.0}, settings).decision_ms == 1234.0
    assert math.isnan(cost(planner, settings).decision_ms)


def test_a_comparison_keeps_the_time_of_its_plans(tmp_path):
    settings = Settings.of(patients=2, seed=5000, episode_s=1.0)
    for _ in range(2):  # played, and kept
        entries = load_entries(["slow_opening", "clairvoyant"], settings.world)
        entries[1].agent.updates = 1
        fixed, planned = compare(entries, settings, tmp_path).about["entries"]
        assert planned["plan_ms"] > 0.0 and "plan_ms" not in fixed


@pytest.mark.parametrize("without", ["clairvoyant", "refined"])
def test_a_comparison_without_both_ends_is_refused(without):
    with pytest.raises(InputError):
        contestants(compared(without))


def test_a_share_is_that_of_the_means():
    values, whole = np.array([[1.0, 2.0], [3.0, 2.0]]), np.array([4.0, 4.0])
    assert ratio_over_both(values, whole).value == 0.5
    assert not ratio_over_both(values[:, :1], whole[:1]).known
