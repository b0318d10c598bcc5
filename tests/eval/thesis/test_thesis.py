"""The thesis's results drawn again: the command, its resuming, and verdicts that follow from the draws."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from eval.commands.app import main
from eval.kept.parts import Run
from eval.studies.design import read
from eval.thesis import catalogue, kalman, kinematics, least_squares, maneuver, rates, rows, study, two_stage
from eval.thesis.item import Item, judged, one_by_one
from jawenv.anatomy import PARAMETER_NAMES
from jawenv.anatomy.muscles import known_muscle_sets

SETS = known_muscle_sets()


def written(folder, draws, *results, seed=0):
    """A study's file of results."""
    folder.mkdir(exist_ok=True)
    content = f"title: Results\nresults: [{', '.join(results)}]\npatients: {draws}\nseed: {seed}\n"
    (folder / "results.yaml").write_text(content)
    return ["study", str(folder / "results.yaml"), "--output", str(folder / "out")]


def test_the_study_draws_judges_and_writes(tmp_path, capsys):
    arguments = written(tmp_path, 3, "kinematics", "linear")
    assert main(arguments) == 0
    printed = capsys.readouterr().out
    assert "Inverse kinematics" in printed and "too few draws" in printed
    page = (tmp_path / "out" / "study.md").read_text()
    for key in ("kinematics", "linear"):
        assert set(pd.read_parquet(tmp_path / "out" / f"{key}.parquet")["draw"]) == {0, 1, 2}
        assert f"## {catalogue.ITEMS[key].title}" in page
    assert main(arguments) == 0
    assert "6 of 6 draws of all results kept from an earlier run" in capsys.readouterr().out


def test_the_study_that_comes_along_has_every_result():
    assert list(read("thesis")[1].results) == list(catalogue.ITEMS)


def test_an_unknown_result_is_refused_in_one_line(tmp_path, capsys):
    assert main(written(tmp_path, 3, "fig_6_3")) == 2
    error = capsys.readouterr().err
    assert "results is 'fig_6_3'; allowed: kinematics" in error and error.count("\n") == 1


@pytest.fixture
def toy(monkeypatch):
    """An item that counts its draws, and can be told to be interrupted in one of them."""
    state = {"drawn": [], "interrupt": None}

    def draw(rng):
        if len(state["drawn"]) == state["interrupt"]:
            raise KeyboardInterrupt
        state["drawn"].append(rng)
        return pd.DataFrame({"value": [rng.normal()]})

    def judge(table):
        return judged(True, False, {"mean of a toy": rows.alone(float(table["value"].mean()))})

    item = Item("toy", "Toy", "nowhere", "nothing", "none", one_by_one(draw), judge)
    monkeypatch.setitem(catalogue.ITEMS, "toy", item)
    monkeypatch.setattr("os.cpu_count", lambda: 1)
    return state


def test_a_run_goes_on_where_it_was_interrupted(toy, tmp_path, capsys):
    arguments, rows = written(tmp_path, 25, "toy"), tmp_path / "out" / "toy.parquet"
    toy["interrupt"] = 14
    assert main(arguments) == 130
    assert "interrupted" in capsys.readouterr().err
    assert not rows.exists()
    toy["interrupt"] = None
    assert main(arguments) == 0
    assert len(toy["drawn"]) == 14 + 15  # the first ten were kept, the four of the broken part are drawn again
    whole = pd.read_parquet(rows)
    assert list(whole["draw"]) == list(range(25))

    assert main(written(tmp_path / "other", 25, "toy")) == 0
    pd.testing.assert_frame_equal(whole, pd.read_parquet(tmp_path / "other" / "out" / "toy.parquet"))
    assert main(written(tmp_path, 25, "toy", seed=1)) == 0
    assert not whole["value"].equals(pd.read_parquet(rows)["value"])


@pytest.mark.parametrize(("draws", "shown"), [(20, True), (19, False)])
def test_a_verdict_is_shown_where_the_draws_are_enough(toy, tmp_path, capsys, draws, shown):
    assert main(written(tmp_path, draws, "toy")) == 0
    for text in ((tmp_path / "out" / "study.md").read_text(), capsys.readouterr().out):
        assert ("reproduced" in text) == shown and ("too few draws" in text) != shown and "mean of a toy" in text


def estimates(names, cases, draws=40, times=(30.0,), error=0.02, sd=0.02, bias=0.0):
    """A table as ``rows.of_estimate`` gives it, with errors of that size about that bias; numbers or by case."""

    def of(value, case):
        return value[case] if isinstance(value, dict) else value

    rng, truth = np.random.default_rng(1), 1.0
    found = []
    for case in cases:
        for draw in range(draws):
            for time in times:
                spread = of(sd, case)(time) if callable(of(sd, case)) else of(sd, case)
                shift = of(bias, case) + of(error, case) * rng.normal(size=len(names))
                found.append(
                    pd.DataFrame(
                        {
                            "case": case,
                            "draw": draw,
                            "time_s": time,
                            "parameter": names,
                            "truth": truth,
                            "estimate": truth + shift,
                            "sd": spread,
                            "nees": len(names),
                            "true_value": np.exp(truth),
                            "value": np.exp(truth + shift),
                        }
                    )
                )
    return pd.concat(found, ignore_index=True)


PAIRS, SIDES = SETS["pairs"].parameter_names, SETS["sides"].parameter_names
NOISES = tuple(least_squares.NOISES)


def verdicts(judge, *tables):
    return [judge(table).verdict for table in tables]


def test_verdict_of_the_linear_method_follows_its_bias():
    biased = estimates(PAIRS, ["linear"], bias=0.5)
    right = estimates(PAIRS, ["linear"])
    assert verdicts(least_squares.judge_linear, biased, right) == ["reproduced", "not reproduced"]


def test_verdict_of_the_nonlinear_method_follows_its_means():
    tables = [estimates(PAIRS, NOISES, bias=bias) for bias in (0.0, 0.5)]
    assert verdicts(least_squares.judge_plane, *tables) == ["reproduced", "not reproduced"]
    tables = [estimates(PARAMETER_NAMES, NOISES, bias=bias) for bias in (0.0, 0.05, -1.5)]
    assert verdicts(least_squares.judge_full, *tables) == ["reproduced", "partly", "not reproduced"]
    assert verdicts(least_squares.judge_physician, *tables) == ["reproduced", "reproduced", "not reproduced"]


def test_verdict_of_the_two_sided_filter_follows_its_errors():
    cases = ("linear", "log")
    good = estimates(SIDES, cases)
    too_sure = estimates(SIDES, cases, sd=0.004)
    far = estimates(SIDES, cases, bias=0.8)
    assert verdicts(kalman.judge_sides, good, too_sure, far) == ["reproduced", "partly", "not reproduced"]


def test_verdict_of_the_full_filter_follows_its_speed():
    def tracked(slow, fast, bias=0.0):
        times = tuple(np.linspace(0.0, 30.0, 7))
        sd = {"log": lambda t: 0.5 if t < slow else 0.05, "two sides": lambda t: 0.5 if t < fast else 0.05}
        sd["linear"] = sd["log"]
        return estimates(PARAMETER_NAMES, ("linear", "log", "two sides"), 10, times, sd=sd, bias=bias)

    tables = tracked(20.0, 5.0), tracked(5.0, 20.0), tracked(5.0, 20.0, bias=1.0)
    assert verdicts(kalman.judge_full, *tables) == ["reproduced", "partly", "not reproduced"]


def test_verdict_on_parameter_noise_follows_the_errors_without_it():
    cases = tuple(kalman.NOISES)
    no_noise = cases[0]
    times = (0.0, 30.0)
    sd = dict.fromkeys(cases, lambda t: 0.5 if t == 0.0 else 0.05)

    def table(**bias):
        return estimates(PARAMETER_NAMES, cases, 20, times, sd=sd, bias=dict.fromkeys(cases, 0.0) | bias)

    assert verdicts(kalman.judge_noise, table(**{no_noise: 1.0}), table(**{no_noise: 0.1}), table()) == [
        "reproduced",
        "partly",
        "not reproduced",
    ]


def test_verdict_on_maneuvers_follows_the_errors(monkeypatch):
    class Jaw:
        class prior:  # noqa: N801
            sd = np.full(12, 0.5)

    monkeypatch.setattr(maneuver, "maneuver_record", lambda degrees, to_the_side: Jaw)

    def table(small, large, swings):
        error = {}
        for degrees in maneuver.OPENINGS:
            for aside in (False, True):
                for method in maneuver.METHODS:
                    size = (small if degrees == maneuver.SMALL else large) * (swings if aside else 1.0)
                    error[maneuver._case(degrees, aside, method)] = size
        return estimates(PARAMETER_NAMES, tuple(error), error=error)

    tables = table(0.5, 0.05, 0.3), table(0.1, 0.05, 0.3), table(0.05, 0.05, 1.0)
    assert verdicts(maneuver.judge, *tables) == ["reproduced", "partly", "not reproduced"]


def test_verdict_on_rates_follows_the_errors():
    cases = ("100 Hz", "10 Hz", "10 Hz, divided")
    slow = estimates(PARAMETER_NAMES, cases, error={"100 Hz": 0.02, "10 Hz": 0.2, "10 Hz, divided": 0.04})
    assert rates.judge(slow).figures["error at 10 Hz, divided, %"].value == pytest.approx(4.0, abs=1.0)
    assert verdicts(rates.judge, slow, estimates(PARAMETER_NAMES, cases)) == ["reproduced", "not reproduced"]
    slow.loc[slow["case"] == "10 Hz", "estimate"] = np.nan
    assert rates.judge(slow).figures["error at 10 Hz, %"].value == np.inf


def test_verdict_on_the_two_stages_follows_the_errors():
    cases = [
        f"{m}: {c}" for m in two_stage.RECORDS for c in (two_stage.NOISY, two_stage.PURE, two_stage.SECOND, "nonlinear")
    ]
    bias = {case: 0.7 if case.startswith("three") and "nonlinear" not in case else 0.0 for case in cases}
    failing, working = estimates(PAIRS, cases, bias=bias), estimates(PAIRS, cases)
    assert verdicts(two_stage.judge, failing, working) == ["reproduced", "not reproduced"]


def test_verdict_on_inverse_kinematics_follows_the_path(monkeypatch):
    monkeypatch.setattr(kinematics, "_aside_range", lambda: np.array([-0.1, 0.1]))
    table = pd.concat([kinematics.draw(np.random.default_rng(k)).assign(draw=k) for k in range(3)])
    assert verdicts(kinematics.judge, table, table.assign(pose_y_mm=9.0)) == ["reproduced", "not reproduced"]
    monkeypatch.setattr(kinematics, "_aside_range", lambda: np.array([-4.0, 4.0]))
    assert verdicts(kinematics.judge, table) == ["partly"]


def test_no_value_in_some_draws_counts_as_wrong_not_as_absent():
    table = estimates(SIDES, ["log"])
    table.loc[table["draw"] < 30, "estimate"] = np.nan
    assert rows.rmse(table).value == np.inf


def test_results_of_the_same_draws_are_drawn_once(toy, tmp_path):
    again = replace(catalogue.ITEMS["toy"], key="again", same_draws_as="toy")
    tables = study.draw_all([catalogue.ITEMS["toy"], again], 3, 0, tmp_path, Run(workers=1))
    assert tables["again"] is tables["toy"] and len(toy["drawn"]) == 3
