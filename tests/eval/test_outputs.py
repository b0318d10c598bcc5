"""Outputs of ``python -m eval`` belong to one process at a time."""

import pytest

from eval.commands.app import main
from eval.comparison import results
from jawenv.base.locks import alone
from tests.eval.studies import study

SHORT = ["--episode-s", "1", "--seed", "5000"]


@pytest.mark.parametrize(
    ("command", "output"),
    [
        (["play", "hold_still", *SHORT, "--video"], "film.webp"),
        (["compare", "hold_still", *SHORT, "--patients", "2", "--output"], "compare"),
        (["replay", "refined", *SHORT, "--patients", "2", "--output"], "replay.yaml"),
        (["report"], "report"),
    ],
)
def test_an_output_in_use_is_refused_in_one_line(tmp_path, capsys, command, output):
    path = tmp_path / output
    if command == ["report"]:
        results.save(study(patients=3), path)
    before = list(tmp_path.rglob("*"))
    with alone(path):
        assert main([*command, str(path)]) == 2
    error = capsys.readouterr().err.splitlines()[-1]
    assert error == f"error: {path}: in use by another process; wait for it, or name another output"
    assert list(tmp_path.rglob("*")) == before
