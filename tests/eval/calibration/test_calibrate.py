"""The command that asks whether filters are honest: its figures against numpy, its resuming, and what it refuses."""

import json
from dataclasses import replace

import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest

import jawenv
from agents import load_agent
from eval.calibration import cells, scores, summary
from eval.calibration import nuisances as tables
from eval.commands.app import main
from eval.rows import beliefs, nuisances
from eval.rows.beliefs import OTHERS
from jawenv.recordings.estimate import Estimate
from jawenv.references.extended_kalman import ExtendedKalman
from tests.metrics.linear_gaussian import linear_gaussian

MANEUVER = "opening_with_swings_and_fore_aft"
SHORT = ["--patients", "3", "--times", "0.5,1", "--control", "force"]


@pytest.fixture(autouse=True)
def one_process(monkeypatch):
    monkeypatch.setattr("os.cpu_count", lambda: 1)


def run(output, *arguments):
    return main(["calibrate", *arguments, "--output", str(output)])


@pytest.fixture(scope="module")
def recording():
    kwargs = {"episode_s": 1.0, "record": True, "cohort": "trismus"}
    return jawenv.play(load_agent(MANEUVER, control="force"), patients=3, seed=4, env_kwargs=kwargs)


def test_the_figures_are_those_of_the_recordings(tmp_path, capsys, recording):
    assert run(tmp_path, MANEUVER, *SHORT, "--seed", "4", "--filters", "tension,ekf-none") == 0
    assert "ekf-none" in capsys.readouterr().out
    table = pd.read_parquet(tmp_path / "calibration.parquet").set_index(["filter", "time_s"])
    assert list(table.index) == [("tension", 0.5), ("tension", 1.0), ("ekf-none", 0.5), ("ekf-none", 1.0)]
    other = [ExtendedKalman("log", 0.0).estimate(record) for record in recording.records]
    for time, step in ((0.5, 10), (1.0, 20)):
        believed = {
            "tension": (recording.belief_mean[:, step], recording.belief_cov[:, step]),
            "ekf-none": (np.array([one.mean[step] for one in other]), np.array([one.cov[step] for one in other])),
        }
        for name, (mean, cov) in believed.items():
            row, error = table.loc[(name, time)], mean - recording.truth
            size = error.shape[1]
            nees = np.einsum("ni,nij,nj->n", error, np.linalg.inv(cov), error)
            sd = np.sqrt(np.diagonal(cov, axis1=1, axis2=2))
            claimed = np.log(recording.prior_sd).sum() - 0.5 * np.linalg.slogdet(cov)[1]
            before = np.sum(((recording.truth - recording.prior_mean) / recording.prior_sd) ** 2, axis=1)
            expected = {
                "patients": 3,
                "nees_per_parameter": nees.mean() / size,
                "claimed": claimed.mean(),
                "true": np.mean(claimed - 0.5 * (nees - before)),
                "gap": np.mean(nees - before) / 2.0,
                "ended": 0,
                "diverged": 0,
                "parameters": size,
            }
            expected |= {f"inside_{k}": np.mean(np.abs(error) <= k * sd) for k in (1, 2, 3)}
            bound = recording.bound_sd[:, step]
            expected["rmse_over_bound"] = np.sqrt((error**2).mean(axis=0) / (bound**2).mean(axis=0)).mean()
            for key, value in expected.items():
                assert row[key] == pytest.approx(value, rel=1e-9), (name, time, key)
            for key in ("nees_per_parameter", "true", "gap", "rmse_over_bound"):
                assert row[f"{key}_low"] <= row[key] <= row[f"{key}_high"]
    page = (tmp_path / "calibration.md").read_text().splitlines()
    lines = [line for line in page if line.startswith("|")]
    assert len(lines) == 2 * (2 + 4) and len({line.count("|") for line in lines}) == 2, "figures, and scores"
    made_with = json.loads(pq.read_schema(tmp_path / "calibration.parquet").metadata[b"jawenv.eval"])
    assert made_with["settings"]["seed"] == 4 and made_with["times"] == [0.5, 1.0]


def test_a_run_goes_on_where_it_was_interrupted(tmp_path, plays, monkeypatch, capsys):
    monkeypatch.setattr(cells, "PATIENTS_IN_A_PART", 1)
    plays.fail_at = 2
    assert run(tmp_path, "refined", *SHORT) == 130
    assert "interrupted" in capsys.readouterr().err and not (tmp_path / "calibration.parquet").exists()
    plays.fail_at = None
    assert run(tmp_path, "refined", *SHORT) == 0
    assert plays.seeds == [0, 1, 2]
    assert "2 of 3 estimates kept from an earlier run" in capsys.readouterr().out
    rows = pd.read_parquet(tmp_path / "beliefs.parquet")
    assert list(rows["seed"]) == [0, 0, 1, 1, 2, 2]

    assert run(tmp_path, "refined", *SHORT) == 0
    assert plays.seeds == [0, 1, 2], "nothing is left to play"
    assert run(tmp_path, "refined", *SHORT, "--filters", "tension,ekf-decaying") == 0
    assert plays.seeds == [0, 1, 2] * 2, "another filter needs the episodes again"
    both = pd.read_parquet(tmp_path / "beliefs.parquet")
    assert list(both["filter"]) == ["tension"] * 6 + ["ekf-decaying"] * 6
    pd.testing.assert_frame_equal(both[both["filter"] == "tension"], rows)
    assert run(tmp_path, "refined", *SHORT, "--fresh") == 0
    assert run(tmp_path, "refined", *SHORT, "--reality", "cell_bias_N=0.2") == 0
    assert plays.seeds == [0, 1, 2] * 4
    biased = pd.read_parquet(tmp_path / "beliefs.parquet")
    assert not biased["nees"].equals(rows["nees"])
    assert run(tmp_path, "refined", *SHORT, "--device", "cell_force_N=0.2") == 0
    noisy = pd.read_parquet(tmp_path / "beliefs.parquet")
    assert noisy["claimed"].mean() < rows["claimed"].mean()


def ended(recording, world, step, violation):
    """The recording with one world over after that step, at a hard limit or because its filter diverged."""
    valid, terminated, crossed = recording.valid.copy(), recording.terminated.copy(), recording.violation.copy()
    valid[world, step + 1 :], terminated[world], crossed[world, step] = False, True, violation
    return replace(recording, valid=valid, terminated=terminated, violation=crossed)


def test_a_patient_counts_only_at_times_that_it_reached(recording):
    over = ended(recording, 1, 10, True)
    for name in ("tension", "ekf-none"):
        rows = beliefs.rows_of(over, name, (0.5, 1.0), 4).assign(entry="some", filter="some")
        table = summary.summarise(rows).set_index("time_s")
        assert list(table["patients"]) == [3, 2] and list(table["ended"]) == [0, 1]
        assert list(table["diverged"]) == [0, 0]
        others = rows[(rows["seed"] != 5) & (rows["time_s"] == 1.0)]
        assert table.loc[1.0, "nees_per_parameter"] == pytest.approx(others["nees"].mean() / 12)


def test_a_bias_of_a_known_size_is_found_and_named():
    """A belief that is exact, and the same with one parameter shifted by half its sd in every patient."""
    exact = linear_gaussian(patients=200)
    name = "log_b/temporalis_right"
    place = exact.parameter_names.index(name)
    biased = exact.belief_mean.copy()
    biased[..., place] -= 0.5 * exact.belief_sd[..., place]
    tables = [
        summary.summarise(beliefs.rows_of(each, "tension", (10.0,), 0).assign(entry="some", filter="some"))
        for each in (exact, replace(exact, belief_mean=biased))
    ]
    honest, shifted = (table.iloc[0] for table in tables)
    assert all(honest[f"mean_z/{each}_low"] <= 0.0 <= honest[f"mean_z/{each}_high"] for each in exact.parameter_names)
    assert shifted["largest_mean_z_of"] == name
    assert shifted["largest_mean_z"] == pytest.approx(honest[f"mean_z/{name}"] - 0.5, abs=1e-9)
    assert shifted["largest_mean_z_low"] <= -0.5 <= shifted["largest_mean_z_high"] < 0.0
    cell = summary.COLUMNS["largest mean z"](shifted)
    assert cell.startswith("−0.") and cell.endswith("), b of temporalis right")


def test_scores_tell_calibrated_beliefs_from_sds_that_are_half_as_large():
    exact, halved = (
        summary.summarise(beliefs.rows_of(each, "tension", (10.0,), 0).assign(entry="some", filter="some")).iloc[0]
        for each in (linear_gaussian(patients=400), linear_gaussian(patients=400, shrink=0.25))
    )
    sd = linear_gaussian(patients=400).belief_sd[:, 20]
    assert exact["crps"] == pytest.approx(sd.mean() / np.sqrt(np.pi), rel=0.03), "of a normal distribution"
    assert exact["pit_deviation"] < exact["pit_limit"] < halved["pit_deviation"]
    for level in scores.NOMINAL:
        assert exact[f"covered_{100 * level:g}"] == pytest.approx(level, abs=3 * np.sqrt(level * (1 - level) / 400))
        assert halved[f"covered_{100 * level:g}"] < level - 0.3
    assert halved["crps"] > exact["crps"] and halved["energy"] > exact["energy"]


def test_a_filter_without_a_belief_has_diverged(recording, monkeypatch):
    lost = ended(recording, 1, 10, False)
    rows = beliefs.rows_of(lost, "tension", (0.5, 1.0), 4).set_index(["seed", "time_s"])
    assert rows.loc[(5, 1.0), "outcome"] == "diverged" and rows.loc[(5, 0.5), "outcome"] == "judged"
    assert beliefs.rows_of(lost, "ekf-none", (1.0,), 4)["outcome"].tolist() == ["judged", "ended", "judged"]

    class Broken:
        def estimate(self, record):
            good = ExtendedKalman().estimate(record)
            mean, cov = good.mean.copy(), good.cov.copy()
            mean[10], cov[20] = np.nan, -np.eye(12)
            return Estimate("broken", good.time, mean, cov)

    monkeypatch.setattr(beliefs, "OTHERS", {**OTHERS, "broken": lambda every: Broken()})
    rows = beliefs.rows_of(recording, "broken", (0.25, 0.5, 1.0), 4).assign(entry="some", filter="some")
    table = summary.summarise(rows)
    assert list(table["diverged"]) == [0, 3, 3] and list(table["patients"]) == [3, 0, 0]
    assert "–" in summary.markdown(table, "lead"), "nobody left to judge"


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        ([], "nothing to calibrate on"),
        (["no_such_maneuver"], "agent is 'no_such_maneuver'; "),
        (["hold_still", "--filters", "tension,kalman"], "filters is 'kalman'; allowed: tension, ekf-decaying"),
        (["hold_still", "--filters", ""], "filters is ''; allowed"),
        (["hold_still", "--times", "10,x"], "times is 'x'; allowed: seconds"),
        (["hold_still", "--times", "2,1"], "times is 2,1; allowed: growing"),
        (["hold_still", "--times", "0,1"], "times is 0,1; allowed: growing"),
        (["hold_still", "--times", "0.51"], "times is 0.51; allowed: multiples of the control step, 0.2 s"),
        (["hold_still", "--device", "cell_force_N=-1"], "device.cell_force_N is -1.0; allowed: a finite number"),
        (["hold_still", "--set", "comfort=strict"], "strict: no file, as its name has no ending; allowed: .json, "),
        (["hold_still", "--set", "anatomy=README.md"], "README.md: unknown file type '.md'"),
    ],
)
def test_bad_input_is_refused_in_one_line(arguments, told, tmp_path, capsys):
    assert run(tmp_path, *arguments) == 2
    error = capsys.readouterr().err
    assert told in error and error.count("\n") == 1


def test_what_is_known_within_sds_is_judged_by_groups(tmp_path, capsys):
    """Each group's figures are those of the belief about all nuisances, and a short episode leaves most unknown."""
    given = [MANEUVER, "--patients", "2", "--times", "0.6,1", "--knowledge", "imaged", "--seed", "6000"]
    assert run(tmp_path, *given) == 0
    assert "mouthpiece" in (tmp_path / "calibration.md").read_text()
    rows, table = (pd.read_parquet(tmp_path / f"{name}.parquet") for name in ("beliefs", "calibration"))
    absent = ("cell, angles", "force of each motor", "inertia", "wrench of no muscle")
    groups = [group for group in nuisances.GROUPS if group not in absent]
    assert tables.groups_in(table) == groups
    for group in groups:
        left, squares = (rows[f"{kind}/{group}"].to_numpy().reshape(2, 2) for kind in (nuisances.LEFT, nuisances.ERROR))
        assert ((left > 0.0) & (left < 1.01)).all() and (left[:, 1] <= left[:, 0] + 0.02).all(), group
        np.testing.assert_allclose(table[f"{nuisances.ERROR}/{group}"], squares.mean(axis=0))
    assert "of the sd before anything was measured" in (tmp_path / "calibration.md").read_text()
