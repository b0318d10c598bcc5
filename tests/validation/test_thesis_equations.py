"""Where Young (2016) is wrong as printed, the form used here is right."""

from functools import cache

import numpy as np
import pytest
from mujoco_twin import MujocoTwin
from printed_equations import errors_of_printed_equations

from jawenv.anatomy import attachment_rows


@cache
def rows():
    return {row.equation: row for row in errors_of_printed_equations()}


def test_corrected_form_is_exact_and_the_printed_one_is_off_as_stated():
    """In docs/tables/model.md, whose figures ``test_model_documentation.py`` compares with these rows."""
    for row in rows().values():
        assert row.corrected < (1e-9 if row.equation == "4.31" else 1e-12)  # 4.31's truth is a finite difference


def test_the_printed_derivative_of_angular_momentum_errs_with_the_square_of_speed():
    """Equation 4.21's spurious m r x (omega x v) does not matter in therapy, only in fast motion."""
    assert rows()["4.21, 10 x faster"].median == pytest.approx(100 * rows()["4.21"].median, rel=1e-6)


def test_strain_must_be_in_percent():
    """Equations 4.1 and 4.2: with the strain as a fraction, b = 0.057 b~/SL_o leaves the muscles without stiffness.

    b~ = 6 and SL_o = 2.73 um after van Ruijven & Weijs (1990); Young's own simulations take b = 6 to 8.
    """
    printed, right = 0.057 * 6 / 2.73, 5.7 * 6 / 2.73
    assert (printed, right) == (pytest.approx(0.125, abs=1e-3), pytest.approx(12.5, abs=0.1))
    twin = MujocoTwin()
    twin.move(twin.state(np.array([8e-3, 0, 0.36, 0, 0]), np.zeros(5)))  # about 35 mm open
    assert twin.mandible.mouthpiece_m[2] - twin.place(twin.mouthpiece)[2] == pytest.approx(35e-3, abs=3e-3)
    strain = twin.strains()[0]
    rise = np.exp(printed * strain.max()) - 1
    print(f"opened 35 mm, muscles are stretched by up to {strain.max():.0%}; force rises by {rise:.1%} as printed")
    assert rise < 0.04
    assert np.exp(right * strain.max()) > 8


def test_the_deep_masseter_row_is_a_copy_of_the_anterior_temporalis():
    """Table A.1: five of six numbers, and a muscle that starts above the zygomatic arch."""
    lines = {(row.portion, row.status): row for row in attachment_rows()}
    printed, repaired = lines["deep_masseter", "rejected"], lines["deep_masseter", "accepted"]
    copied = lines["anterior_temporalis", "accepted"]
    same = np.array([*printed.origin, *printed.insertion]) == [*copied.origin, *copied.insertion]
    assert same.tolist() == [False, True, True, True, True, True]

    def line(row):
        return np.subtract(row.origin, row.insertion)

    assert np.linalg.norm(line(printed)) == pytest.approx(49.7, abs=0.1)
    assert np.linalg.norm(line(repaired)) == pytest.approx(34.2, abs=0.1)
    cosine = line(printed) @ line(repaired) / np.linalg.norm(line(printed)) / np.linalg.norm(line(repaired))
    assert np.degrees(np.arccos(cosine)) > 25  # the pull would come from elsewhere
