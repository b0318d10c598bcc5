"""`jawenv.compare`: the numbers of `python -m eval compare`, for entries of every kind."""

import sys

import numpy as np
import pytest

import jawenv
from eval.comparison.ranking import rank
from eval.comparison.results import compare
from eval.kept.entries import Settings, load_entries
from jawenv.metrics.intervals import mean

WORLD = {"cohort": "one_sided", "episode_s": 1.0}
NAMES = ["refined", "slow_opening", "apg_anyone"]


def still(observation):
    assert observation.shape == (63,)
    return [0.0, 0.0, 0.0, 0.0]


@pytest.fixture(scope="module")
def table():
    return jawenv.compare([*NAMES, still, jawenv.Maneuver.named("hold_still")], patients=3, seed=5, **WORLD)


def test_the_numbers_are_those_of_the_command(table):
    settings = Settings.of(3, 5, **WORLD)
    ranking = rank(compare(load_entries(NAMES, settings.world), settings), "refined")
    for row in ranking.rows:
        ours = table.loc[row.entry]
        shown = {
            "nine in ten, s": row["time_to_5_p90"].value,
            "worst error bar, %": 100.0 * row["worst_sd"].value,
            "within 2 sd, %": 100.0 * row["inside_2_sigma"].value,
            "NEES/12": row["nees_per_parameter"].value,
            "discomfort, s": row["discomfort_s"].value,
        }
        if row.entry != "refined":
            gained = row["difference"]
            shown |= {"gain over refined, nats": gained.value, "from": gained.low, "to": gained.high}
        for name, value in shown.items():
            np.testing.assert_allclose(ours[name], value, rtol=1e-12, err_msg=f"{row.entry}: {name}")


def test_entries_of_every_kind_stand_in_their_order(table):
    assert list(table.index) == [*NAMES, "still", "hold_still"]
    assert table["gain over refined, nats"].iloc[0] == 0.0 and (table["gain over refined, nats"].iloc[1:] != 0.0).all()


def test_who_never_knows_counts_as_the_whole_episode():
    played = jawenv.compare(["refined"], patients=6, seed=5, episode_s=3.0).loc["refined"]
    score = jawenv.score(jawenv.play(jawenv.Player("refined"), patients=6, seed=5, env_kwargs={"episode_s": 3.0}))
    known = score.time_to_s[0.05]
    assert np.isfinite(known).any() and np.isinf(known).any()
    assert played["all within 5 %, s"] == pytest.approx(np.minimum(known, 3.0).mean())
    assert mean(score.nees).value / 12 == pytest.approx(played["NEES/12"])


@pytest.mark.parametrize(("entries", "says"), [([], "entries is empty"), ([3], "entry is 3"), (["refind"], "refined")])
def test_what_is_no_entry_is_refused(entries, says):
    with pytest.raises(jawenv.InputError, match=says):
        jawenv.compare(entries, patients=1, episode_s=1.0)


def test_without_pandas_the_rows_are_mappings(monkeypatch):
    monkeypatch.setitem(sys.modules, "pandas", None)
    (row,) = jawenv.compare(["hold_still"], patients=1, seed=5, episode_s=1.0)
    assert row["entry"] == "hold_still" and row["all within 5 %, s"] == 1.0 and np.isnan(row["from"])
