"""What is drawn into a truth: told and untold add up, one draw moves no other, and sds are those asked for."""

import numpy as np
import pytest

from jawenv.anatomy import known_muscle_sets
from jawenv.anatomy.knowledge import Knowledge
from jawenv.envs.world.record import truth_dtype
from jawenv.envs.world.unknown_truth import draw_truth
from jawenv.kernels.noise import Streams
from jawenv.kernels.records import record_zeros
from jawenv.mechanics import build_jaw
from jawenv.reality import Reality

MUSCLES, LINES = known_muscle_sets()["whole"], 6
MASS = {"mass": 0.1, "head_tilt_deg": 3.0, "mouthpiece_deg": 0.5, "cell_offset_N": 0.1}
UNTOLD = {"mass_error": 0.1, "head_tilt_error_deg": 3.0, "mouthpiece_error_deg": 0.5, "cell_error_deg": 0.5}


def truths(worlds=1, knowledge=None, reality=None, anatomy_seed=None):
    """Records of truths that were drawn."""
    records = record_zeros(worlds, truth_dtype(6, LINES, 0, 0))
    for i, truth in enumerate(records):
        truth["jaw"] = build_jaw(MUSCLES)
        streams = Streams.of(np.array([7, i], dtype=np.uint64))
        told, untold = Knowledge(**(knowledge or {})), Reality(**(reality or {}))
        draw_truth(truth, told, untold, MUSCLES, streams, anatomy_seed)
    return records


def tilt(jaw):
    return np.degrees(np.arctan2(jaw["gravity"][..., 0], -jaw["gravity"][..., 2]))


def test_told_and_untold_add_up():
    exact = truths()
    told = truths(knowledge=MASS)
    untold = truths(reality=UNTOLD)
    both = truths(knowledge=MASS, reality=UNTOLD)
    nominal = exact["jaw"]["mass"][0]
    assert both["jaw"]["mass"][0] == pytest.approx(told["jaw"]["mass"][0] * untold["jaw"]["mass"][0] / nominal)
    assert tilt(both["jaw"])[0] == pytest.approx(tilt(told["jaw"])[0] + tilt(untold["jaw"])[0])
    for name in ("turn", "cell_turn", "cell_offset"):
        np.testing.assert_allclose(both[name][0], told[name][0] + untold[name][0], rtol=1e-12, atol=1e-15)


def test_attachments_that_are_told_and_others_that_are_not_add_up():
    exact = truths()
    told = truths(knowledge={"attachments": 0.1})
    both = truths(knowledge={"attachments": 0.1}, reality={"attachment_error": 0.3})
    shifts = [each["jaw"]["origin"][0] - exact["jaw"]["origin"][0] for each in (told, both)]
    assert np.std(shifts[1] - shifts[0]) > 1.5 * np.std(shifts[0]) > 0.0


def test_untold_errors_move_no_other_draw():
    plain, other = (truths(reality={"fossa_error": 0.1, **more}) for more in ({}, UNTOLD))
    assert plain["jaw"]["fossa_drop"][0] == other["jaw"]["fossa_drop"][0]
    assert plain["jaw"]["mass"][0] != other["jaw"]["mass"][0]


def test_a_world_that_is_drawn_again_has_nothing_left_of_its_last_truth():
    record = truths(knowledge=MASS)[:1]
    record["jaw"][0] = build_jaw(MUSCLES)
    draw_truth(record[0], Knowledge(), Reality(), MUSCLES, Streams.of(np.array([7, 0], dtype=np.uint64)), None)
    for name in ("turn", "cell_turn", "cell_offset"):
        np.testing.assert_array_equal(record[name], 0.0)


def test_untold_errors_have_their_sds():
    every = {
        "mass_error": 0.1,
        "inertia_error": 0.05,
        "damping_error": 0.2,
        "centre_of_mass_error_mm": 4.0,
        "mouthpiece_error_mm": 0.5,
    }
    drawn = truths(400, reality={**every, **UNTOLD})
    jaws, nominal = drawn["jaw"], build_jaw(MUSCLES)
    assert np.std(jaws["mass"] / nominal["mass"]) == pytest.approx(0.1, rel=0.15)
    assert np.std(jaws["inertia"][:, 1, 1] / nominal["inertia"][1, 1]) == pytest.approx(0.05, rel=0.15)
    assert np.std(jaws["damping_sliding"] / nominal["damping_sliding"]) == pytest.approx(0.2, rel=0.15)
    assert np.std(tilt(jaws)) == pytest.approx(3.0, rel=0.15)
    for name, sd in (("centre_of_mass", 4e-3), ("mouthpiece", 0.5e-3)):
        np.testing.assert_allclose(np.std(jaws[name], axis=0), sd, rtol=0.15)
    np.testing.assert_allclose(np.std(drawn["turn"], axis=0), np.radians(0.5), rtol=0.15)
    np.testing.assert_allclose(np.std(drawn["cell_turn"] - drawn["turn"], axis=0), np.radians(0.5), rtol=0.15)
