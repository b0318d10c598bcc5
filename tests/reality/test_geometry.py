"""Errors of attachments and fossa: their sds by sampling, and what stays consistent."""

import numpy as np
import pytest

from jawenv.anatomy import attachment_rows, known_muscle_sets, load_quantities
from jawenv.mechanics import build_jaw
from jawenv.reality import Reality
from jawenv.reality.geometry import perturb_geometry

DRAWS = 4000
ROWS = {row.portion: row for row in attachment_rows() if row.status == "accepted"}
MASSETER = ("superficial_masseter", "deep_masseter")


def drawn(name, rng, draws=DRAWS, **options):
    """Jaws of a muscle set with errors."""
    muscles, reality = known_muscle_sets()[name], Reality(**options)
    jaws = np.repeat(np.array([build_jaw(muscles)]), draws)
    for i in range(draws):
        perturb_geometry(reality, muscles, jaws[i], rng)
    return jaws


def assert_sd(sample, sd):
    """Mean 0 and the sd, to five standard errors."""
    sample = np.asarray(sample)
    error = 5 / np.sqrt(len(sample))
    np.testing.assert_array_less(np.abs(sample.mean(axis=0)), error * sd + 1e-15)
    np.testing.assert_array_less(np.abs(sample.std(axis=0) - sd), error * sd + 1e-15)


@pytest.mark.parametrize("name", known_muscle_sets())
def test_errors_have_the_sds_of_the_lines_times_the_option(name, rng):
    muscles = known_muscle_sets()[name]
    jaws = drawn(name, rng, attachment_error=0.5)
    assert_sd(jaws["origin"] - muscles.origin_m, 0.5 * muscles.origin_sd_m)
    assert_sd(jaws["insertion"] - muscles.insertion_m, 0.5 * muscles.insertion_sd_m)


@pytest.mark.parametrize("name", known_muscle_sets())
def test_F_o_still_belongs_to_the_closed_jaw_and_bones_to_the_patient(name, rng):
    before = build_jaw(known_muscle_sets()[name])
    for jaw in drawn(name, rng, draws=20, attachment_error=1.0):
        np.testing.assert_allclose(jaw["l_o"], np.linalg.norm(jaw["insertion"] - jaw["origin"], axis=1), rtol=1e-15)
        assert np.all(jaw["l_o"] != before["l_o"])
        for field in set(before.dtype.names) - {"origin", "insertion", "l_o"}:
            assert np.array_equal(jaw[field], before[field])


def test_portions_have_the_sds_of_the_table():
    muscles = known_muscle_sets()["portions"]
    for name, origin_sd, insertion_sd in zip(muscles.names, muscles.origin_sd_m, muscles.insertion_sd_m, strict=True):
        row = ROWS[name.rsplit("_", 1)[0]]
        np.testing.assert_allclose(origin_sd, np.array(row.origin_sd) / 1e3)
        np.testing.assert_allclose(insertion_sd, np.array(row.insertion_sd) / 1e3)


@pytest.mark.parametrize(("name", "line"), [("whole", 0), ("whole", 3), ("sides", 3)])
def test_a_whole_muscle_varies_as_the_mean_of_its_portions(name, line, rng):
    """Sampled: portions moved one by one, then averaged with the weights of the muscle's line."""
    force = load_quantities("strengths.toml")
    weights = [float(force[portion].si()) for portion in MASSETER]
    for end in ("origin", "insertion"):
        sd = np.array([getattr(ROWS[portion], f"{end}_sd") for portion in MASSETER]) / 1e3
        moved = np.average(rng.standard_normal((DRAWS, 2, 3)) * sd, axis=1, weights=weights)
        assert_sd(moved, getattr(known_muscle_sets()[name], f"{end}_sd_m")[line])


def test_a_line_of_the_midplane_varies_as_the_mean_of_both_sides_and_stays_there(rng):
    whole, pairs = known_muscle_sets()["whole"], known_muscle_sets()["pairs"]
    for end in ("origin_sd_m", "insertion_sd_m"):
        expected = getattr(whole, end)[:3] / np.sqrt(2) * [1, 0, 1]
        np.testing.assert_allclose(getattr(pairs, end), expected, rtol=1e-12)
    assert np.all(drawn("pairs", rng, draws=5, attachment_error=1.0)["origin"][:, :, 1] == 0.0)


def test_sides_err_independently(rng):
    muscles = known_muscle_sets()["whole"]
    errors = drawn("whole", rng, attachment_error=1.0)["origin"] - muscles.origin_m
    for line in range(3):
        for axis in range(3):
            correlation = np.corrcoef(errors[:, line, axis], errors[:, 3 + line, axis])[0, 1]
            assert abs(correlation) < 5 / np.sqrt(DRAWS)


def test_the_fossa_errs_and_its_crest_follows(rng):
    before = build_jaw()
    jaws = drawn("whole", rng, fossa_error=0.1)
    for field in ("fossa_drop", "fossa_frequency"):
        assert_sd(np.log(jaws[field] / before[field])[:, np.newaxis], np.array([0.1]))
    np.testing.assert_allclose(jaws["crest"], np.pi / jaws["fossa_frequency"], rtol=1e-15)
    assert abs(np.corrcoef(jaws["fossa_drop"], jaws["fossa_frequency"])[0, 1]) < 5 / np.sqrt(DRAWS)
    assert np.array_equal(jaws["origin"][0], before["origin"])
