"""The muscle sets of the ladder of models, their cohorts and patients."""

import gymnasium as gym
import numpy as np
import pytest

from jawenv.anatomy import (
    COHORTS,
    PORTIONS,
    WHOLE_MUSCLES,
    Patient,
    cohort,
    known_muscle_sets,
    midplane_muscles,
    muscle_set,
    two_sides,
)
from jawenv.ladder import KNOWN_WITHIN_SDS, MODELS, env_id_of, model_of_env, title_of_env

SETS = known_muscle_sets()


def test_every_model_has_its_thesis_parameters() -> None:
    counts = {name: len(model.muscles.parameter_names) for name, model in MODELS.items()}
    assert counts == {"hinge": 2, "sagittal": 6, "sides": 4, "jaw": 12, "portions": 24}


@pytest.mark.parametrize("name", MODELS)
def test_an_environment_is_known_by_id_title_and_model(name: str) -> None:
    model = MODELS[name]
    assert [model_of_env(env) for env in (model.env_id, model.title, name)] == [model] * 3
    assert {env_id_of(env) for env in (model.env_id, model.title, name)} == {model.env_id}
    assert title_of_env(model.env_id) == model.title


def test_the_jaw_known_within_sds_is_an_environment_of_the_whole_jaw() -> None:
    assert KNOWN_WITHIN_SDS in gym.registry
    for env in (KNOWN_WITHIN_SDS, "JawImaged"):
        assert (model_of_env(env), env_id_of(env)) == (MODELS["jaw"], KNOWN_WITHIN_SDS)


def test_midplane_lines_are_what_a_pair_does_together() -> None:
    pairs, whole = midplane_muscles(), muscle_set()
    for i, name in enumerate(pairs.names):
        ends = [whole.names.index(f"{name}_{side}") for side in ("left", "right")]
        np.testing.assert_allclose(pairs.origin_m[i], whole.origin_m[ends].mean(axis=0), atol=1e-15)
        np.testing.assert_allclose(pairs.insertion_m[i], whole.insertion_m[ends].mean(axis=0), atol=1e-15)
    assert midplane_muscles({"closers": tuple(PORTIONS)}).muscle == (0,)
    assert tuple(WHOLE_MUSCLES) == pairs.names


def test_two_sides_share_the_lines_of_six() -> None:
    sides, whole = two_sides(), muscle_set()
    assert sides.names == ("left", "right") and sides.muscle == (0, 0, 0, 1, 1, 1)
    np.testing.assert_array_equal(sides.origin_m, whole.origin_m)
    np.testing.assert_array_equal(sides.l_o_m, whole.l_o_m)


@pytest.mark.parametrize("name", COHORTS)
def test_all_models_of_a_cohort_pull_equally_hard(name: str) -> None:
    """The sum of the median forces over all lines does not depend on how muscles are divided."""
    total = {}
    for key, muscles in SETS.items():
        population = cohort(name, muscles)
        per_line = np.exp(population.mean[:, 0::2])[:, list(muscles.muscle)]
        total[key] = per_line.sum(axis=1).mean()
    assert total == pytest.approx(dict.fromkeys(SETS, total["whole"]), rel=1e-12)


@pytest.mark.parametrize("key", SETS)
def test_patients_of_every_set_are_written_and_read(key: str, tmp_path) -> None:
    population = cohort("one_sided", SETS[key])
    patient = population.draw(np.random.default_rng(3))
    assert patient.muscles == SETS[key].names
    patient.save(tmp_path / "patient.json")
    assert Patient.load(tmp_path / "patient.json") == patient
    again = Patient.from_log_parameters(patient.log_parameters(), name=patient.name, muscles=patient.muscles)
    np.testing.assert_allclose(again.log_parameters(), patient.log_parameters(), rtol=1e-14)
