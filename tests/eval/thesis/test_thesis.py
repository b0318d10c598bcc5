"""The thesis's results drawn again: the command, its resuming, and verdicts that follow from the draws."""

import json

import numpy as np
import pandas as pd
import pytest
from rich.console import Console

from eval.commands.app import main
from eval.kept.parts import Run
from eval.thesis import catalogue, kalman, kinematics, least_squares, maneuver, rates, rows, run, study, two_stage
from eval.thesis.histograms import histograms
from eval.thesis.item import Item, Judgement, one_by_one
from jawenv.anatomy import PARAMETER_NAMES
from jawenv.anatomy.muscles import known_muscle_sets
from jawenv.base.errors import InputError

SETS = known_muscle_sets()


def test_the_command_draws_judges_and_reports(tmp_path, capsys):
    arguments = ["thesis", "--quick", "--only", "kinematics", "--only", "linear", "--output", str(tmp_path)]
    assert main([*arguments, "--draws", "3"]) == 0
    printed = capsys.readouterr().out
    assert "Inverse kinematics" in printed and "report:" in printed
    page = (tmp_path / "report.html").read_text()
    for key in ("kinematics", "linear"):
        told = json.loads((tmp_path / f"{key}.json").read_text())
        assert told["verdict"] in ("reproduced", "partly", "not reproduced")
        assert told["numbers"] and told["settings"] == {"draws": 3, "seed": 0, "quick": True}
        assert set(pd.read_parquet(tmp_path / f"{key}.parquet")["draw"]) == {0, 1, 2}
        assert f'id="{key}"' in page
    assert page.count("<svg") == 2 and "http" not in page.replace("http://www.w3.org", "")

    assert main([*arguments, "--draws", "3"]) == 0
    assert "6 of 6 draws of all results kept from an earlier run" in capsys.readouterr().out


def test_bad_input_is_refused_in_one_line(tmp_path, capsys):
    for arguments, told in (
        (["--only", "fig_6_3"], "fig_6_3"),
        (["--draws", "1"], "draws is 1; allowed"),
        (["--seed", "-1"], "seed is -1; allowed: a whole number, 0 to 4294967295"),
        (
            ["--seed", "1" + 24 * "0"],
            "seed is 1000000000000000000000000; allowed: a whole number, 0 to 4294967295",
        ),
    ):
        assert main(["thesis", *arguments, "--output", str(tmp_path)]) == 2
        error = capsys.readouterr().err
        assert told in error and error.count("\n") == 1
    (tmp_path / "file").write_text("")
    assert main(["thesis", "--output", str(tmp_path / "file")]) == 2


@pytest.fixture
def toy(monkeypatch):
    """An item that counts its draws, and can be told to be interrupted in one of them."""
    state = {"drawn": [], "interrupt": None}

    def draw(rng, quick):
        if len(state["drawn"]) == state["interrupt"]:
            raise KeyboardInterrupt
        state["drawn"].append(quick)
        return pd.DataFrame({"value": [rng.normal()]})

    def judge(table):
        return Judgement("nothing", "reproduced", "it is a toy", {"mean": float(table["value"].mean())})

    def figure(table):
        from matplotlib.figure import Figure

        return Figure()

    item = Item("toy", "Toy", "nowhere", "nothing", "none", one_by_one(draw), judge, figure, "")
    monkeypatch.setattr(catalogue, "ITEMS", {"toy": item})
    monkeypatch.setattr("os.cpu_count", lambda: 1)
    return state


def test_a_run_goes_on_where_it_was_interrupted(toy, tmp_path, capsys):
    arguments = ["thesis", "--draws", "25", "--output", str(tmp_path)]
    toy["interrupt"] = 14
    assert main(arguments) == 130
    assert "interrupted" in capsys.readouterr().err
    assert not (tmp_path / "toy.parquet").exists()
    toy["interrupt"] = None
    assert main(arguments) == 0
    assert len(toy["drawn"]) == 14 + 15  # the first ten were kept, the four of the broken chunk are drawn again
    whole = pd.read_parquet(tmp_path / "toy.parquet")
    assert list(whole["draw"]) == list(range(25))

    other = tmp_path / "other"
    assert main([*arguments[:-1], str(other)]) == 0
    pd.testing.assert_frame_equal(whole, pd.read_parquet(other / "toy.parquet"))

    assert main([*arguments, "--fresh"]) == 0
    assert len(toy["drawn"]) == 29 + 25 + 25
    assert main([*arguments, "--seed", "1"]) == 0
    assert not whole["value"].equals(pd.read_parquet(tmp_path / "toy.parquet")["value"])


def test_a_damaged_file_says_what_to_do(toy, tmp_path):
    console = Console(quiet=True)
    study.study(None, run.Draws(3, quick=True), tmp_path, Run(), "", console)
    (chunk,) = (tmp_path / "draws").glob("*.parquet")
    chunk.write_text("no parquet")
    with pytest.raises(InputError):
        study.study(None, run.Draws(3, quick=True), tmp_path, Run(), "", console)


@pytest.mark.parametrize(("options", "shown"), [([], "reproduced"), (["--quick"], None), (["--draws", "19"], None)])
def test_a_verdict_is_shown_where_the_draws_are_enough(toy, tmp_path, capsys, options, shown):
    assert main(["thesis", "--draws", "20", *options, "--output", str(tmp_path)]) == 0
    page, printed = (tmp_path / "report.html").read_text(), capsys.readouterr().out
    for text in (page.partition("<body>")[2], printed):
        assert ("it is a toy" in text) == (shown is not None)
        assert ("too few draws" in text) == (shown is None)
    assert page.count('<span class="badge reproduced">') == (2 if shown else 0)
    assert page.count('<span class="badge">too few draws</span>') == (0 if shown else 2)


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
    assert "With ticks divided into 10 ms: 10 Hz 4." in rates.judge(slow).measured
    assert verdicts(rates.judge, slow, estimates(PARAMETER_NAMES, cases)) == ["reproduced", "not reproduced"]
    slow.loc[slow["case"] == "10 Hz", "estimate"] = np.nan
    assert "10 Hz diverges" in rates.judge(slow).measured


def test_verdict_on_the_two_stages_follows_the_errors():
    cases = [
        f"{m}: {c}" for m in two_stage.RECORDS for c in (two_stage.NOISY, two_stage.PURE, two_stage.SECOND, "nonlinear")
    ]
    bias = {case: 0.7 if case.startswith("three") and "nonlinear" not in case else 0.0 for case in cases}
    failing, working = estimates(PAIRS, cases, bias=bias), estimates(PAIRS, cases)
    assert verdicts(two_stage.judge, failing, working) == ["reproduced", "not reproduced"]
    assert "logarithm of a sum" in two_stage.judge(failing).why
    assert "does not explain" in two_stage.judge(estimates(PAIRS, cases, bias=0.7)).why


def test_verdict_on_inverse_kinematics_follows_the_path(monkeypatch):
    monkeypatch.setattr(kinematics, "_aside_range", lambda: np.array([-0.1, 0.1]))
    table = pd.concat([kinematics.draw(np.random.default_rng(k), True).assign(draw=k) for k in range(3)])
    assert verdicts(kinematics.judge, table, table.assign(pose_y_mm=9.0)) == ["reproduced", "not reproduced"]
    monkeypatch.setattr(kinematics, "_aside_range", lambda: np.array([-4.0, 4.0]))
    assert verdicts(kinematics.judge, table) == ["partly"]


@pytest.mark.parametrize("draws", [4, 40])
def test_few_estimates_are_drawn_one_by_one(draws):
    table = estimates(PAIRS, ["linear"], draws)
    for axes, name in zip(histograms(table, 6).axes, sorted(PAIRS, key=lambda name: "log_b" in name), strict=True):
        values = table.loc[table["parameter"] == name, "value"].to_numpy()
        dots = [line.get_xdata() for line in axes.lines if line.get_marker() == "o"]
        if draws == 4:
            np.testing.assert_array_equal(dots[0], values)
        assert bool(axes.patches) == (draws == 40) and len(dots) == (draws == 4)


def test_no_value_in_some_draws_counts_as_wrong_not_as_absent():
    table = estimates(SIDES, ["log"])
    table.loc[table["draw"] < 30, "estimate"] = np.nan
    assert rows.rmse(table).value == np.inf


def test_parts_share_what_does_not_change_and_differ_in_what_does(tmp_path):
    item = catalogue.ITEMS["physician_view"]
    ten, more = (run.parts_of_item(item, run.Draws(draws), tmp_path) for draws in (10, 20))
    assert ten == more[:1]
    assert ten == run.parts_of_item(catalogue.ITEMS["nonlinear_full"], run.Draws(10), tmp_path)
    for other in (run.Draws(10, seed=1), run.Draws(10, quick=True)):
        assert run.parts_of_item(item, other, tmp_path)[0].files != ten[0].files
