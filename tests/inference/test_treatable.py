"""Who can be treated is whom a reset takes, and the law of the treatable is that of the patients that a reset draws."""

import gymnasium as gym
import numpy as np
import pytest
from scipy.stats import ks_2samp

import jawenv
from jawenv.anatomy import Cohort, Stiffness
from jawenv.ladder import MODELS, model_named

PATIENTS = 400
_SO_SOFT = Stiffness(F_o_N=0.25, F_o_sd=0.5, b=7.0, b_sd=0.3)
SOFT = Cohort("soft", "too soft to hold the jaw up, in more than half of all patients", "made up", ((_SO_SOFT,) * 2,))


def theta_of(model, n=24):
    return jawenv.cohort(SOFT, model_named(model).muscles).sample(n, 7)


def taken(env, row, muscles):
    try:
        env.reset(seed=0, options={"patient": jawenv.Patient.from_log_parameters(row, muscles=muscles)})
    except jawenv.InputError as error:
        assert "no rest pose" in str(error)
        return False
    return True


@pytest.mark.parametrize("model", MODELS)
def test_they_are_those_whom_a_reset_takes(model):
    rung = model_named(model)
    theta = theta_of(model)
    mask = jawenv.treatable(theta, env_id=rung.env_id)
    assert mask.dtype == np.bool_ and mask.shape == (24,)
    env = gym.make(rung.env_id, control="trajectory")
    assert mask.tolist() == [taken(env, row, rung.muscles.names) for row in theta]


def test_the_treatable_of_a_sample_are_as_those_whom_a_reset_draws():
    sample = SOFT.sample(PATIENTS, 0, accept=jawenv.treatable)
    assert sample.shape == (PATIENTS, 12) and jawenv.treatable(sample).all()
    vec = gym.make_vec("jawenv/Jaw-v3", num_envs=PATIENTS, cohort=SOFT)
    drawn = vec.reset(seed=0)[1]["truth"]
    whole = SOFT.sample(PATIENTS, 1)
    # Kolmogorov's test of each parameter, and of the ratio of two that the condition binds.
    p = [ks_2samp(drawn[:, i], sample[:, i]).pvalue for i in range(12)]
    p.append(ks_2samp(drawn[:, 2] - drawn[:, 8], sample[:, 2] - sample[:, 8]).pvalue)
    assert min(p) > 1e-3
    assert min(ks_2samp(whole[:, i], drawn[:, i]).pvalue for i in range(12)) < 1e-6


def test_nobody_whom_a_patient_cannot_describe_is_treatable():
    theta = np.tile(np.log([1.2, 7.0] * 6), (3, 1))
    theta[1, 0], theta[2, 1] = np.log(201.0), 1000.0
    assert jawenv.treatable(theta).tolist() == [True, False, False]
    assert jawenv.treatable(np.empty((0, 12))).shape == (0,)


@pytest.mark.parametrize(
    ("theta", "env_id"),
    [
        (np.zeros(12), "jawenv/Jaw-v3"),
        (np.zeros((2, 4)), "jawenv/Jaw-v3"),
        ([["a"] * 12], "jawenv/Jaw-v3"),
        (np.full((1, 2), np.nan), "jawenv/JawHinge-v3"),
        (np.zeros((1, 12)), "CartPole-v1"),
        (np.zeros((1, 12)), "jawenv/Jaw-v99"),
    ],
)
def test_what_is_refused(theta, env_id):
    with pytest.raises(jawenv.InputError):
        jawenv.treatable(theta, env_id=env_id)
