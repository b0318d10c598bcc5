"""Playing a study: what is kept, also when a run is killed, and the same numbers from any number of processes."""

import errno
import os

import pandas as pd
import pyarrow.parquet as pq
import pytest
import yaml

from eval.commands.app import main
from eval.kept import tables
from eval.kept.cells import play_cells
from eval.kept.parts import Run
from eval.studies import grid
from eval.studies.design import Design

SMALL = {
    "title": "Small",
    "entries": ["hold_still", "chirp", "random"],
    "reality": {"none": {}, "creep": {"creep_share": 0.3}},
    "patients": 3,
    "seed": 5000,
    "episode_s": 1.0,
    "pairs": [["chirp", "hold_still"]],
}
FILES = ["cells.parquet", "pairs.parquet", "parts", "patients.parquet", "study.md"]


@pytest.fixture
def study(tmp_path):
    """Runs the command on a small study, in one process."""
    path, output = tmp_path / "small.yaml", tmp_path / "out"

    def command(*arguments, **changes):
        path.write_text(yaml.safe_dump(SMALL | changes))
        return main(["study", str(path), "--output", str(output), "--workers", "1", *arguments])

    command.output = output
    return command


def parts(folder):
    return {path: path.stat().st_mtime_ns for path in (folder / "parts").glob("[!.]*")}


def test_a_study_writes_its_results_and_what_they_were_made_with(study, capsys):
    assert study() == 0
    told = capsys.readouterr().out
    assert "18 of 18 episodes" in told or "making 18 episodes" in told
    assert sorted(path.name for path in study.output.iterdir()) == FILES
    rows, about = tables.read_table(study.output / "patients.parquet")
    assert len(rows) == 2 * 3 * 3 and not rows.duplicated(["reality", "entry", "seed"]).any()
    truths = rows.groupby("seed")[[name for name in rows if name.startswith("truth/")]].nunique()
    assert (truths == 1).all(axis=None), "the same patients everywhere"
    assert about["study"]["entries"][1]["agent"] == "chirp" and about["study"]["seed"] == 5000
    assert {"command", "versions", "git", "machine", "finished"} <= set(about)
    assert about["machine"]["cores"] == os.cpu_count()
    again = Design(**about["study"])
    assert again == Design(**SMALL)
    for name in ("cells", "pairs"):
        assert len(pd.read_parquet(study.output / f"{name}.parquet"))
    assert "Small" in (study.output / "study.md").read_text()


def test_only_what_is_missing_is_played(study, plays, capsys):
    assert study() == 0 and len(plays.names) == 6
    first = pd.read_parquet(study.output / "patients.parquet")
    assert study() == 0 and len(plays.names) == 6
    assert "18 of 18 episodes kept from an earlier run" in capsys.readouterr().out
    pd.testing.assert_frame_equal(pd.read_parquet(study.output / "patients.parquet"), first)
    assert study(entries=["prbs", "chirp"], pairs=[]) == 0
    assert plays.names[6:] == ["prbs", "prbs"], "the other entry is kept"
    assert study("--patients", "2", title="Another") == 0 and len(plays.names) == 6 + 2 + 6
    assert study("--fresh") == 0 and len(plays.names) == 6 + 2 + 6 + 6


def test_another_metric_alone_plays_nothing_again_but_the_bound_is_played(study, plays):
    assert study(entries=["chirp"], pairs=[]) == 0
    assert study(entries=["chirp"], pairs=[], metrics=["rmse", "time_to_2"]) == 0 and len(plays.names) == 2
    assert study(entries=["chirp"], pairs=[], metrics=["information_bound"]) == 0 and len(plays.names) == 4
    cells = pd.read_parquet(study.output / "cells.parquet")
    assert cells["value"].notna().all()


def test_an_interrupt_keeps_what_is_finished(study, plays, capsys):
    plays.fail_at = 4
    assert study() == 130
    assert "the same command goes on from there" in capsys.readouterr().err
    kept = parts(study.output)
    assert len(kept) == 4 and not (study.output / "patients.parquet").exists()
    plays.fail_at = None
    assert study() == 0 and len(plays.names) == 6
    assert kept.items() <= parts(study.output).items()


def test_a_full_disk_is_one_line_and_what_is_finished_is_kept(study, plays, monkeypatch, capsys):
    written, original = [], pq.write_table

    def full(table, path, **options):
        if len(written) == 2:
            raise OSError(errno.ENOSPC, "No space left on device")
        written.append(path)
        original(table, path, **options)

    monkeypatch.setattr(pq, "write_table", full)
    assert study() == 2
    error = capsys.readouterr().err
    assert "cannot be written: No space left on device" in error and error.count("\n") == 1
    kept = parts(study.output)
    assert len(kept) == 2
    monkeypatch.setattr(pq, "write_table", original)
    assert study() == 0 and kept.items() <= parts(study.output).items()


def played(folder, run):
    return play_cells(grid.cells_of(Design(**SMALL)), folder, run)


@pytest.fixture(scope="module")
def alone(tmp_path_factory):
    """The rows from one process."""
    return played(tmp_path_factory.mktemp("alone"), Run(workers=1))


def test_two_processes_give_the_same_numbers(alone, tmp_path):
    pd.testing.assert_frame_equal(played(tmp_path, Run(workers=2)), alone, check_exact=True)


def test_parts_of_another_size_give_the_same_numbers(alone, tmp_path, monkeypatch):
    monkeypatch.setattr(grid, "PATIENTS_IN_A_PART", 2)
    pd.testing.assert_frame_equal(played(tmp_path, Run(workers=1)), alone, check_exact=True)
