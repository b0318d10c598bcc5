"""Cohorts against the theory of truncated normals, and the prior that stands beside each."""

import numpy as np
import pytest
from scipy.stats import kstest, truncnorm

from jawenv.anatomy import COHORTS, MUSCLE_NAMES, Patient, cohort
from jawenv.base.errors import InputError
from tests.passive_opening import passive_opening

PATIENTS = 4000
SINGLE_GROUP = ["trismus", "healthy", "severe", "patchy", "blockage", "wide"]
TRUNCATED = truncnorm(-2, 2)


def draws(name: str, n: int = PATIENTS) -> np.ndarray:
    rng = np.random.default_rng(20160501)
    return np.array([cohort(name).draw_log_parameters(rng) for _ in range(n)])


@pytest.mark.parametrize("name", SINGLE_GROUP)
def test_draws_are_the_priors_normal_truncated_at_two_sd(name: str) -> None:
    one = cohort(name)
    standard = (draws(name) - one.mean[0]) / one.sd[0]
    assert np.all(np.abs(standard) <= 2)
    assert np.abs(standard).max() > 1.99
    error = TRUNCATED.std() / np.sqrt(PATIENTS)
    assert np.all(np.abs(standard.mean(axis=0)) < 4 * error)
    np.testing.assert_allclose(standard.std(axis=0), TRUNCATED.std(), rtol=0.04)
    # Parameters are independent, so the pooled sample is one of 12 x PATIENTS.
    assert kstest(standard.ravel(), TRUNCATED.cdf).pvalue > 1e-3
    correlation = np.corrcoef(standard.T) - np.eye(12)
    assert np.abs(correlation).max() < 5 / np.sqrt(PATIENTS)


@pytest.mark.parametrize("name", [*SINGLE_GROUP, "one_sided"])
def test_the_prior_is_honest(name: str) -> None:
    """Its mean and sd are those of the draws: mean NEES 12."""
    prior = cohort(name).prior
    nees = (((draws(name) - prior.mean) / prior.sd) ** 2).sum(axis=1)
    assert nees.mean() == pytest.approx(12.0, abs=0.4)


def test_one_sided_is_stiff_on_one_side_at_random() -> None:
    theta = draws("one_sided")
    # Single F_o of the two sides overlap; the mean over a side's three muscles tells the sides apart.
    left, right = theta[:, 0:6:2].mean(axis=1), theta[:, 6:12:2].mean(axis=1)
    assert np.mean(left > right) == pytest.approx(0.5, abs=0.04)
    stiff = np.where((left > right)[:, None], theta[:, :6], theta[:, 6:])
    healthy = np.where((left > right)[:, None], theta[:, 6:], theta[:, :6])
    assert np.median(stiff[:, ::2]) == pytest.approx(np.log(4.0), abs=0.05)
    assert np.median(healthy[:, ::2]) == pytest.approx(np.log(0.7), abs=0.05)


@pytest.mark.parametrize("name", COHORTS)
def test_any_draw_is_a_valid_patient_even_at_the_bounds(name: str) -> None:
    one = cohort(name)
    for mean, sd in zip(one.mean, one.sd, strict=True):
        for corner in (-2, 2):
            Patient.from_log_parameters(mean + corner * sd)
    patient = one.draw(np.random.default_rng(1))
    expected = one.draw_log_parameters(np.random.default_rng(1))
    np.testing.assert_allclose(patient.log_parameters(), expected, rtol=1e-14)
    assert patient.name == name and patient.head_tilt_deg == 0.0
    assert set(patient.F_o_N) == set(MUSCLE_NAMES)


@pytest.mark.parametrize("name", COHORTS)
def test_a_sample_is_that_many_draws(name: str) -> None:
    one = cohort(name)
    sample = one.sample(50, 3)
    rng = np.random.default_rng(3)
    np.testing.assert_array_equal(sample, [one.draw_log_parameters(rng) for _ in range(50)])
    np.testing.assert_array_equal(one.sample(20, 3), sample[:20])
    assert one.sample(0, 3).shape == (0, 12)


def test_a_sample_of_those_accepted_is_the_cohort_without_the_others() -> None:
    one = cohort("trismus")
    sample, everybody = one.sample(30, 3, accept=soft), one.sample(200, 3)
    np.testing.assert_array_equal(sample, everybody[soft(everybody)][:30])
    np.testing.assert_array_equal(one.sample(10, 3, accept=soft), sample[:10])


def soft(theta: np.ndarray) -> np.ndarray:
    return theta[:, 0] < np.log(3.5)


@pytest.mark.parametrize(
    ("n", "seed", "accept"),
    [(-1, 0, None), (2.0, 0, None), (1, -1, None), (2, 0, lambda theta: np.zeros(len(theta), dtype=bool))],
)
def test_what_a_sample_refuses(n, seed, accept) -> None:
    with pytest.raises(InputError):
        cohort("trismus").sample(n, seed, accept=accept)


@pytest.mark.parametrize(
    "name, rest_mm, at_20_N_mm, at_40_N_mm",
    [
        ("healthy", (2.0, 4.0), (45.0, 60.0), (45.0, 60.0)),
        ("trismus", (-2.0, 0.0), (15.0, 35.0), (15.0, 35.0)),
        ("severe", (-3.0, 0.0), (5.0, 15.0), (10.0, 20.0)),
        ("blockage", (0.0, 4.0), (20.0, 35.0), (20.0, 35.0)),
        ("patchy", (-2.0, 2.0), (20.0, 45.0), (30.0, 45.0)),
    ],
)
def test_the_median_patient_keeps_to_the_clinical_criteria(name, rest_mm, at_20_N_mm, at_40_N_mm):
    """Trismus: at most 35 mm (Dijkstra 2006), severe: at most 20 mm, under therapeutic 20 to 40 N."""
    openings = np.median(passive_opening(cohort(name).sample(30, seed=7), (0.0, 20.0, 40.0)), axis=0)
    for opening, (least, most) in zip(openings, (rest_mm, at_20_N_mm, at_40_N_mm), strict=True):
        assert least <= opening <= most
