"""A kept result fits only as long as nothing has changed that the entry is made of."""

import importlib.metadata
import json
from collections.abc import Callable
from pathlib import Path

import pytest

from eval.kept import digest as kept
from eval.kept.digest import fingerprint
from eval.kept.entries import Settings, load_entries
from jawenv.anatomy import cohort
from jawenv.base import versions
from tests.eval.runs import save_checkpoint, save_run
from tests.plain_policies import write_corrector


def print_of(spec: str | Path, **settings: str) -> str:
    """The fingerprint of an entry, loaded anew."""
    world = Settings.of(**{"control": "targets", **settings}).world
    (entry,) = load_entries([str(spec)], world, trust=True)
    return fingerprint(entry, {})


PARTS: dict[str, Callable[[Path], object]] = {
    "weights": lambda run: write_corrector(run, "slow_opening", gain=0.5),
    "scale": lambda run: write_corrector(run, "slow_opening", scale=0.4),
    "maneuver": lambda run: write_corrector(run, "chirp"),
}


@pytest.mark.parametrize("part", PARTS)
@pytest.mark.parametrize("file", ["", "card.json", "checkpoints/step_1.zip"])
def test_it_changes_with_every_part_of_a_run(tmp_path: Path, part: str, file: str) -> None:
    run = save_run(tmp_path / "run")
    before = print_of(run / file)
    assert print_of(run / file) == before
    PARTS[part](run)
    assert print_of(run / file) != before


def test_it_changes_with_the_weights_of_a_checkpoint(tmp_path: Path) -> None:
    run = save_run(tmp_path / "run")
    prints = {print_of(save_checkpoint(run / "checkpoints" / "step_1.zip", seed=seed)) for seed in (1, 2)}
    assert len(prints) == 2


def test_it_changes_with_the_file_of_the_cohort(tmp_path: Path) -> None:
    prints = set()
    for name in ("trismus", "wide"):
        (tmp_path / "cohort.json").write_text(json.dumps(cohort(name).to_dict()))
        prints.add(print_of("hold_still", cohort=str(tmp_path / "cohort.json")))
    assert len(prints) == 2


@pytest.mark.parametrize("package", versions.PACKAGES)
def test_it_changes_with_every_package(package: str, monkeypatch: pytest.MonkeyPatch) -> None:
    before, real = print_of("hold_still"), importlib.metadata.version
    monkeypatch.setattr(versions, "version", lambda name: "0.0" if name == package else real(name))
    assert print_of("hold_still") != before


@pytest.mark.parametrize(("changed", "decides"), [("filter/tick.py", True), ("live/page.py", False)])
def test_it_changes_with_what_can_change_a_number_and_with_nothing_else(
    changed: str, decides: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    package = tmp_path / "jawenv"
    for name in ("__init__.py", "filter/tick.py", "live/page.py"):
        (package / name).parent.mkdir(parents=True, exist_ok=True)
        (package / name).write_text("one = 1\n")
    monkeypatch.setattr(kept.jawenv, "__file__", str(package / "__init__.py"))
    before = kept._source.__wrapped__(package / "__init__.py")
    (package / changed).write_text("one = 2\n")
    assert (kept._source.__wrapped__(package / "__init__.py") != before) == decides
