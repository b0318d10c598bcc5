"""Directions made by hand, and what is to be said of them."""

import numpy as np
import pytest

from jawenv.analysis.wording import in_words
from jawenv.anatomy import PARAMETER_NAMES
from jawenv.ladder import MODELS


def direction(names, **weights):
    """Weights by the names' ends, as F_o_masseter_left."""
    short = [name.removeprefix("log_").replace("/", "_") for name in names]
    found = np.zeros(len(names))
    for name, weight in weights.items():
        found[short.index(name)] = weight
    return found


@pytest.mark.parametrize(
    ("weights", "words"),
    [
        ({"F_o_temporalis_left": 1, "F_o_temporalis_right": -1}, "F_o: temporalis, left against right"),
        ({"F_o_temporalis_left": -1, "F_o_temporalis_right": 1}, "F_o: temporalis, left against right"),
        ({"F_o_masseter_left": 0.6, "F_o_medial_pterygoid_left": -0.7}, "F_o: masseter against medial pterygoid, left"),
        ({"F_o_masseter_left": 1, "b_masseter_left": -1}, "F_o against b: masseter, left"),
        ({"b_masseter_right": 3}, "b: masseter, right"),
        ({"b_masseter_left": 1, "b_masseter_right": 1}, "b: masseter, both sides"),
        (
            {"b_masseter_left": 1, "b_temporalis_left": 1, "b_masseter_right": -1, "b_temporalis_right": -1},
            "b: masseter and temporalis, left against right",
        ),
        (
            {"F_o_masseter_left": 1, "b_masseter_left": -1, "F_o_masseter_right": 1, "b_masseter_right": -1},
            "F_o against b: masseter, both sides",
        ),
        (
            {"F_o_masseter_left": 1, "F_o_temporalis_right": 1, "F_o_medial_pterygoid_left": -1},
            "F_o masseter left and F_o temporalis right against F_o medial pterygoid left",
        ),
        ({"F_o_masseter_left": 1, "b_temporalis_right": -1}, "F_o masseter left against b temporalis right"),
        (
            {"F_o_masseter_left": 1, "b_masseter_left": 1, "b_temporalis_left": -1},
            "F_o masseter left and b masseter left against b temporalis left",
        ),
    ],
)
def test_of_the_reference_model(weights, words):
    assert in_words(direction(PARAMETER_NAMES, **weights), PARAMETER_NAMES) == words


def test_of_whole_groups():
    names = np.array(PARAMETER_NAMES)
    strength = np.char.startswith(names, "log_F_o").astype(float)
    left = np.where(np.char.endswith(names, "left"), 1.0, -1.0)
    assert in_words(strength, names) == "F_o: all muscles, both sides"
    assert in_words(strength * left, names) == "F_o: all muscles, left against right"
    assert in_words(2.0 * strength - 1.0, names) == "F_o against b: all muscles, both sides"


def test_small_parts_are_left_out_and_equal_ones_stay_together():
    weights = direction(PARAMETER_NAMES, b_masseter_left=1.0, b_masseter_right=-1.0, F_o_temporalis_left=0.2)
    assert in_words(weights, PARAMETER_NAMES) == "b: masseter, left against right"
    alike = direction(PARAMETER_NAMES, b_masseter_left=1, b_temporalis_left=1, b_medial_pterygoid_left=1)
    assert in_words(alike, PARAMETER_NAMES) == "b: all muscles, left"


def test_of_models_without_sides_or_muscles():
    hinge, sides = (MODELS[name].muscles.parameter_names for name in ("hinge", "sides"))
    assert in_words([1, -1], hinge) == "F_o against b: closers"
    assert in_words([0, 1], hinge) == "b: closers"
    assert in_words([1, 0, -1, 0], sides) == "F_o: left against right"
    assert in_words([1, -1, 0, 0], sides) == "F_o against b: left"
    assert in_words([1, 0, 0, -1], sides) == "F_o left against b right"


@pytest.mark.parametrize("name", MODELS)
def test_every_parameter_alone_and_random_directions_have_words(name, rng):
    names = MODELS[name].muscles.parameter_names
    alone = {in_words(row, names) for row in np.eye(len(names))}
    assert len(alone) == len(names), "no two are called the same"
    for _ in range(50):
        weights = rng.normal(size=len(names))
        assert in_words(weights, names) == in_words(-weights, names)
        assert "  " not in in_words(weights, names)
