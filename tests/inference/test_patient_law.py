"""The law of an environment's patients has the density of what it draws."""

from dataclasses import replace

import numpy as np
import pytest

import jawenv
from jawenv.inference.patient_law import PatientLaw
from jawenv.ladder import model_named

HINGE = "jawenv/JawHinge-v3"


def cells(law, counts):
    """Middles of the cells of a grid over all whom the cohort has, and the cells' volume."""
    low = (law.cohort.mean - 2.0 * law.cohort.sd).min(axis=0)
    width = ((law.cohort.mean + 2.0 * law.cohort.sd).max(axis=0) - low) / counts
    axes = [start + step * (np.arange(n) + 0.5) for start, step, n in zip(low, width, counts, strict=True)]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, len(counts)), width.prod()


@pytest.mark.parametrize("cohort", ["trismus", "healthy"])
def test_its_integral_is_1_and_its_entropy_that_of_its_density(cohort):
    law = PatientLaw.of(cohort, env_id=HINGE, draws=4000)
    theta, volume = cells(law, (60, 60))
    density = law.log_density(theta)
    probability = np.exp(density) * volume
    assert probability.sum() == pytest.approx(1.0, abs=0.02)
    mean = (probability * np.where(probability > 0.0, density, 0.0)).sum() / probability.sum()
    assert law.entropy == pytest.approx(-mean, abs=0.04)


def test_two_groups_are_a_mixture_and_the_untreatable_have_no_density():
    model = model_named("sides")
    groups = jawenv.cohort("severe").groups + jawenv.cohort("trismus").groups
    law = PatientLaw.of(replace(jawenv.cohort("severe"), groups=groups), env_id=model.env_id, draws=4000)
    assert 0.8 < law.share < 0.98
    rng = np.random.default_rng(1)
    low, high = (law.cohort.mean - 2 * law.cohort.sd).min(axis=0), (law.cohort.mean + 2 * law.cohort.sd).max(axis=0)
    density = np.exp(law.log_density(rng.uniform(low, high, (20_000, 4)))) * np.prod(high - low)
    assert density.mean() == pytest.approx(1.0, abs=4.0 * density.std() / np.sqrt(len(density)))
    whole = law.cohort.sample(300, 3)
    possible = np.isfinite(law.log_density(whole))
    np.testing.assert_array_equal(possible, jawenv.treatable(whole, env_id=model.env_id))
    assert np.isfinite(law.log_density(law.sample(50, 0))).all()


def test_what_is_refused():
    with pytest.raises(jawenv.InputError):
        PatientLaw.of("nobody")
    with pytest.raises(jawenv.InputError):
        PatientLaw.of(env_id="CartPole-v1")
    with pytest.raises(jawenv.InputError):
        PatientLaw.of(env_id=HINGE, draws=50).log_density(np.zeros((3, 12)))
