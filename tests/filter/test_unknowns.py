"""Numbers of a jaw that are known within an sd: what one of each changes, and the directions that have an effect."""

import numpy as np
import pytest

from jawenv.anatomy import COHORTS, cohort
from jawenv.anatomy.knowledge import BENCH, IMAGED, Knowledge
from jawenv.filter.nuisances.directions import directions
from jawenv.filter.nuisances.unknowns import cell_turn_of, changed_jaw, draw_unknowns, no_unknowns, offset_of, turn_of
from jawenv.mechanics import build_jaw

TRISMUS = cohort("trismus")
MUSCLES, MEAN = TRISMUS.muscles, TRISMUS.prior.mean
LINES = len(MUSCLES.muscle)


def test_nothing_unknown_changes_nothing():
    jaw = build_jaw()
    for known, values in ((IMAGED, no_unknowns(LINES)), (Knowledge(), draw_unknowns(LINES, np.random.default_rng(0)))):
        changed = changed_jaw(jaw, known, MUSCLES, values)
        for name in jaw.dtype.names:
            np.testing.assert_allclose(changed[name], jaw[name], rtol=1e-12, atol=1e-15, err_msg=name)


def test_draws_have_the_sds_that_are_known():
    jaw, generator = build_jaw(), np.random.default_rng(1)
    draws = [draw_unknowns(LINES, generator) for _ in range(2000)]
    jaws = [changed_jaw(jaw, IMAGED, MUSCLES, values) for values in draws]

    def sd(name):
        return np.std([changed[name] for changed in jaws], axis=0)

    assert sd("mass") == pytest.approx(IMAGED.mass * float(jaw["mass"]), rel=0.1)
    assert sd("fossa_drop") == pytest.approx(IMAGED.fossa * float(jaw["fossa_drop"]), rel=0.1)
    np.testing.assert_allclose(sd("centre_of_mass"), [4e-3, 1e-3, 6e-3], rtol=0.1)
    np.testing.assert_allclose(sd("mouthpiece"), 0.5e-3, rtol=0.1)
    np.testing.assert_allclose(sd("origin"), IMAGED.attachments * MUSCLES.origin_sd_m, rtol=0.1)
    np.testing.assert_allclose(np.std([turn_of(IMAGED, v) for v in draws], axis=0), np.radians(0.5), rtol=0.1)
    offsets = np.std([offset_of(IMAGED, v)[:6] for v in draws], axis=0)
    np.testing.assert_allclose(offsets, np.repeat([IMAGED.cell_offset_N, IMAGED.cell_offset_N_m], 3), rtol=0.1)


def test_lines_keep_their_length_at_the_closed_jaw():
    """F_o is the tension of the closed jaw, whose l_o is that of the true attachments."""
    changed = changed_jaw(build_jaw(), IMAGED, MUSCLES, draw_unknowns(LINES, np.random.default_rng(2)))
    np.testing.assert_allclose(np.linalg.norm(changed["origin"] - changed["insertion"], axis=1), changed["l_o"])


def test_mouthpiece_and_teeth_are_shifted_together_and_the_encoders_zeroed_there():
    jaw, values = build_jaw(), draw_unknowns(LINES, np.random.default_rng(3))
    changed = changed_jaw(jaw, IMAGED, MUSCLES, values)
    shift = changed["mouthpiece"] - jaw["mouthpiece"]
    np.testing.assert_allclose(changed["zero"], shift)
    np.testing.assert_allclose(changed["teeth"] - jaw["teeth"], np.tile(shift, (3, 1)))


def acting(*parts):
    """The directions before the zeros that fill the columns."""
    return [values for values in directions(*parts) if any(map(np.any, values.values()))]


def test_shifts_along_a_line_need_no_direction():
    known = Knowledge(attachments=0.1)
    found = acting(known, MUSCLES, build_jaw(), MEAN)
    assert 2 * LINES <= len(found) < 6 * LINES
    for values in found:
        assert np.isclose(np.sum(values["origin"] ** 2) + np.sum(values["insertion"] ** 2), 1.0)
    assert len(acting(IMAGED, MUSCLES, build_jaw(), MEAN)) == len(found) + 22
    assert directions(Knowledge(), MUSCLES, build_jaw(), MEAN) == []


def test_a_tilted_head_is_tilted_further():
    jaw, values = build_jaw(head_tilt_deg=10.0), no_unknowns(LINES)
    values["head_tilt"][:] = 2.0
    changed = changed_jaw(jaw, Knowledge(head_tilt_deg=3.0), MUSCLES, values)
    np.testing.assert_allclose(changed["gravity"], build_jaw(head_tilt_deg=16.0)["gravity"], atol=1e-12)


def test_inertia_is_drawn_and_has_no_direction_and_the_cell_turns_by_itself():
    known, values = Knowledge(inertia=0.1, cell_deg=0.5), no_unknowns(LINES)
    values["inertia"][:], values["cell_turn"][:] = 2.0, [1.0, 0.0, -1.0]
    jaw = build_jaw()
    changed = changed_jaw(jaw, known, MUSCLES, values)
    np.testing.assert_allclose(changed["inertia"], 1.2 * jaw["inertia"])
    np.testing.assert_allclose(cell_turn_of(known, values), np.radians([0.5, 0.0, -0.5]))
    np.testing.assert_array_equal(turn_of(known, values), 0.0)
    found = acting(known, MUSCLES, jaw, MEAN)
    assert len(found) == 3 and all(np.sum(np.abs(each["cell_turn"])) == 1.0 for each in found)


def test_a_tone_is_drawn_with_its_sd_and_beside_the_other_draws():
    jaw, known = build_jaw(), Knowledge(closing_tone_N=0.1)
    drawn = [draw_unknowns(LINES, generator, known) for generator in map(np.random.default_rng, range(500))]
    tones = [float(changed_jaw(jaw, known, MUSCLES, values)["tone"]) for values in drawn]
    assert np.std(tones) == pytest.approx(0.1, rel=0.1) and abs(np.mean(tones) - float(jaw["tone"])) < 0.02
    for name, plain in draw_unknowns(LINES, np.random.default_rng(0)).items():
        if name != "tone":
            np.testing.assert_array_equal(plain, drawn[0][name])


def test_a_wrench_of_no_muscle_hides_by_shapes_of_the_pose_and_moves_no_other_draw():
    known = Knowledge(wrench_N=0.2)
    drawn = [draw_unknowns(LINES, generator, known) for generator in map(np.random.default_rng, range(400))]
    offsets = np.array([offset_of(known, values) for values in drawn]).reshape(-1, 6, 6)
    for component, unit in enumerate((1.0, 1.0, 1.0, 0.03, 0.0, 0.03)):
        np.testing.assert_allclose(np.std(offsets[:, :, component], axis=0), 0.2 * unit, rtol=0.15)
    for name, plain in draw_unknowns(LINES, np.random.default_rng(0)).items():
        if name != "wrench":
            np.testing.assert_array_equal(plain, drawn[0][name])
    assert len(acting(known, MUSCLES, build_jaw(), MEAN)) == 30
    assert not np.any(offset_of(IMAGED, drawn[0])[6:])


def test_a_bench_has_the_same_columns_whatever_the_cohort():
    """One compiled filter serves every cohort that ``identify`` tries."""
    found = {len(directions(BENCH, one.muscles, build_jaw(), one.typical)) for one in COHORTS.values()}
    assert len(found) == 1
