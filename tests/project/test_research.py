"""Each study of ``research`` and the benchmark are commands, and what the ablation changes exists."""

from importlib import import_module
from pathlib import Path

import pytest

from research import ablation
from tests.processes import python

STUDIES = sorted(path.stem for path in (Path(__file__).parents[2] / "research").glob("[a-z]*.py"))


@pytest.mark.parametrize("name", STUDIES)
def test_a_study_is_a_command(name: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr("sys.argv", [name, "--help"])
    with pytest.raises(SystemExit) as ended:
        import_module(f"research.{name}").main()
    assert ended.value.code == 0
    assert "usage:" in capsys.readouterr().out.lower()


def test_constants_that_the_ablation_changes_exist() -> None:
    for row in ablation.ROWS:
        for constant in row.constants:
            module, _, name = (ablation.FILTER + constant).rpartition(".")
            assert hasattr(import_module(module), name), constant


def test_the_benchmark_is_a_command() -> None:
    bench = Path(__file__).parents[1] / "benchmarks" / "bench.py"
    assert "--quick" in python(bench, "--help").stdout
