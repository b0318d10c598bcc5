"""The figure of whether an estimate can be believed, and its words."""

from dataclasses import replace

import numpy as np
import pytest

from eval.patient import believed
from jawenv.recordings.untold.shown import Shown


@pytest.fixture
def shown():
    opening = np.linspace(0.0, 0.2, 5)
    force = np.outer(opening, [1.0, 0.0, 3.0])
    return Shown(1.0, opening, force, np.full((5, 3), 0.1), np.array([0.05, 0.15]), np.array([0.8, 40.0]))


def test_the_figure_names_its_axes_and_follows_the_pages_colours(shown):
    drawn = str(believed.figure(shown))
    assert drawn.startswith("<svg") and "var(--band)" in drawn and "left out" in drawn


def test_words_say_whether_parts_agree_and_how_much_wider_error_bars_are(shown):
    assert "agree with each other" in believed.in_words(shown)
    assert "3.0 times as wide" in believed.in_words(replace(shown, temperature=9.0))
