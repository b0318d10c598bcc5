"""What a page saves: one pair of files a drive, so many at most, and what was driven before an error."""

import numpy as np
import pytest

from jawenv.base.errors import InputError
from jawenv.live import saving
from jawenv.live.page import Page
from jawenv.live.saving import Saves
from jawenv.live.server import serving
from jawenv.live.session import DriveSession
from jawenv.live.setup import Setup
from jawenv.recordings.files import load_record

SHORT = Setup.of(seed=500, episode_s=2.0)
OPEN = [0.4, 0.0, 0.0, 0.0]


@pytest.fixture
def session():
    return DriveSession(SHORT)


def test_a_later_save_of_a_drive_replaces_the_earlier_one(session, tmp_path):
    saves = Saves(tmp_path)
    session.drive(OPEN)
    first = saves.save(session)
    written = first[1].stat().st_mtime_ns
    assert saves.save(session) == first and first[1].stat().st_mtime_ns == written
    session.drive(OPEN)
    assert saves.save(session) == first and len(load_record(first[1]).time) == 11
    saves.begin()
    assert [path.name for path in saves.save(session)] == ["my_drive_2.yaml", "my_drive_2.csv"]
    assert len(list(tmp_path.iterdir())) == 4


@pytest.mark.parametrize(("limit", "value"), [("MOST_DRIVES", 1), ("MOST_BYTES", 1000)])
def test_saves_are_bounded_in_number_and_size(session, tmp_path, monkeypatch, limit, value):
    monkeypatch.setattr(saving, limit, value)
    saves = Saves(tmp_path)
    session.drive(OPEN)
    saves.save(session)
    saves.begin()
    with pytest.raises(InputError):
        saves.save(session)
    assert len(list(tmp_path.iterdir())) == 2


class Broken:
    """An agent that opens the jaw for a while."""

    name = "broken"

    def __init__(self):
        self.decisions = 0

    def reset(self, num_envs, seed=None):
        pass

    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        self.decisions += 1
        if self.decisions > 3:
            raise RuntimeError("the agent is at its wits' end")
        return np.zeros((1, 4), dtype=np.float32), None


def test_a_drive_that_an_error_ends_is_saved(tmp_path):
    with serving(0) as server:
        page = Page(server, SHORT, tmp_path, "broken", {"broken": Broken()})
        for wish in (page._single_step, page._pause):
            page._wishes[wish] = wish
        with pytest.raises(RuntimeError, match="wits' end"):
            page.run()
    assert len(load_record(tmp_path / "my_drive_1.csv").time) == 41
