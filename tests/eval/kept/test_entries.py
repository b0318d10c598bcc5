"""Entries from outside the project: exported policies, checkpoints of unknown origin, agents of one's own."""

import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from eval.kept.digest import fingerprint
from eval.kept.entries import Settings, load_entries
from jawenv.base.errors import InputError
from jawenv.playing.policies.card import CARD
from tests.eval.runs import save_run
from tests.plain_policies import random_weights, write_policy

OWN = """
import numpy as np
class Mine:
    name = "mine"
    def __init__(self, control): self.control = control
    def reset(self, num_envs, seed=None): pass
    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        return np.zeros((*np.shape(observation)[:-1], 4), np.float32), None
"""


def exported(folder: Path, gain: float = 0.0) -> Path:
    """An exported policy, with something added to every weight."""
    return write_policy(folder, {name: values + np.float32(gain) for name, values in random_weights().items()})


@pytest.fixture
def own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """The module of an agent in the current folder."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", list(sys.path))
    (tmp_path / "entry_of_mine.py").write_text(OWN)
    yield tmp_path / "entry_of_mine.py"
    sys.modules.pop("entry_of_mine", None)


def test_an_exported_policy_plays_with_the_control_and_rate_of_its_card(tmp_path: Path) -> None:
    folder = exported(tmp_path / "shared")
    for spec in (folder, folder / CARD):
        (entry,) = load_entries([str(spec)], Settings().world)
        assert entry.trained and entry.label == "shared"
        assert (entry.env_kwargs["control"], entry.env_kwargs["control_hz"]) == ("trajectory", 10.0)
        assert entry.env_kwargs["episode_s"] == 30.0
        assert "played with control trajectory" in entry.note and "trained with episode_s 12.0" in entry.note


def test_a_policy_of_the_whole_jaw_is_played_where_that_is_known_within_sds(tmp_path: Path) -> None:
    folder = exported(tmp_path / "shared")
    (entry,) = load_entries([str(folder)], Settings.of(env="JawImaged").world)
    assert entry.env_id == "jawenv/JawImaged-v3" and "trained in jawenv/Jaw-v3" in entry.note
    (entry,) = load_entries(["ppo_trismus"])
    assert not entry.note


@pytest.mark.parametrize(
    ("trained", "asked", "noted"),
    [
        ({"knowledge": "imaged"}, {"knowledge": "imaged"}, False),
        ({"knowledge": "imaged"}, {}, True),
        ({"comfort": {"force_N": 24.0}}, {}, False),  # the default
        ({"comfort": {"force_N": 8.0}}, {}, True),
        ({}, {"device": {"cell_gain": 0.0}}, True),
    ],
)
def test_a_note_says_what_of_the_world_was_another_in_training(
    tmp_path: Path, trained: dict[str, Any], asked: dict[str, Any], noted: bool
) -> None:
    folder = save_run(tmp_path / "run", **trained)
    (entry,) = load_entries([str(folder)], Settings.of(**asked).world)
    (name,) = trained or asked
    assert (f"trained with another {name}" in entry.note) == noted


def test_the_fingerprint_changes_with_the_weights_and_with_ones_own_module(tmp_path: Path, own: Path) -> None:
    specs = [str(exported(tmp_path / "shared")), str(tmp_path / "shared" / CARD), "entry_of_mine:Mine"]
    before = [fingerprint(entry, {}) for entry in load_entries(specs, Settings().world)]
    assert before == [fingerprint(entry, {}) for entry in load_entries(specs, Settings().world)]
    exported(tmp_path / "shared", gain=0.1)
    own.write_text(OWN + "# changed\n")
    after = [fingerprint(entry, {}) for entry in load_entries(specs, Settings().world)]
    assert all(new != old for new, old in zip(after, before, strict=True))


def test_the_fingerprint_changes_with_the_files_that_ones_own_agent_names(tmp_path: Path, own: Path) -> None:
    own.write_text(OWN.replace('name = "mine"', 'name = "mine"\n    made_of = ["gains.txt"]'))
    prints = set()
    for gains in ("1", "2"):
        (tmp_path / "gains.txt").write_text(gains)
        (entry,) = load_entries(["entry_of_mine:Mine"], Settings().world)
        prints.add(fingerprint(entry, {}))
    assert len(prints) == 2
    entry.agent.made_of = "gains.txt"  # type: ignore[attr-defined]
    with pytest.raises(InputError):
        fingerprint(entry, {})


def test_an_agent_of_ones_own_gets_the_control_of_the_study(own: Path) -> None:
    (entry,) = load_entries(["entry_of_mine:Mine"], Settings.of(control="trajectory").world)
    assert entry.label == "mine" and not entry.trained
    assert entry.agent.control == "trajectory"  # type: ignore[attr-defined]
