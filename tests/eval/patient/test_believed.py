"""The figure of whether an estimate can be believed, and its words."""

from dataclasses import replace

import numpy as np
import pytest

from eval.patient import believed
from jawenv.recordings.untold_errors import Learnt
from jawenv.recordings.untold_shown import Shown


@pytest.fixture
def learnt():
    opening = np.linspace(0.0, 0.2, 5)
    force = np.outer(opening, [1.0, 0.0, 3.0])
    shown = Shown(opening, force, np.full((5, 3), 0.1), np.array([0.05, 0.15]), np.array([0.8, 40.0]))
    return Learnt(np.zeros(12), np.eye(12), 1.0, np.zeros(4), shown)


def test_the_figure_names_its_axes_and_follows_the_pages_colours(learnt):
    drawn = str(believed.figure(learnt))
    assert drawn.startswith("<svg") and "var(--band)" in drawn and "left out" in drawn


def test_words_say_whether_parts_agree_and_how_much_wider_error_bars_are(learnt):
    assert "agree with each other" in believed.in_words(learnt)
    assert "3.0 times as wide" in believed.in_words(replace(learnt, temperature=9.0))
