"""Design environments: every id of jawenv is one, and what is not as described is named."""

import runpy
from pathlib import Path

import gymnasium as gym
import numpy as np
import pytest

import jawenv  # noqa: F401  registers its environments
from jawenv.base.errors import InputError
from jawenv.design import JawDesign, check_design_env

LINEAR = runpy.run_path(str(Path(__file__).parents[2] / "examples" / "linear_design_env.py"))["LinearDesign"]


@pytest.mark.parametrize("env_id", [each for each in gym.registry if each.startswith("jawenv/")])
def test_every_environment_of_jawenv_is_one(env_id):
    env = JawDesign(gym.make(env_id, episode_s=5.0))
    check_design_env(env, steps=4)
    env.close()


def test_one_that_draws_pictures_simulates_as_well():
    env = JawDesign(gym.make("jawenv/JawHinge-v3", control="force", render_mode="rgb_array"))
    readings = env.simulate(env.prior.sample(1, 0)[0], np.zeros((2, 4)), 0)
    assert readings["measured"].shape == (11, 12)
    env.close()


def test_one_that_is_no_jaw_is_one():
    check_design_env(LINEAR())


@pytest.mark.parametrize(
    ("name", "wrong", "message"),
    [
        ("parameter_names", ("a", "a"), "parameter_names"),
        ("simulate", lambda theta, actions, seed: {"y": np.zeros(3)}, "under another seed"),
        ("simulate", lambda theta, actions, seed: {"y": np.random.normal(size=3)}, "under the same seed"),
        ("log_likelihood", lambda readings, theta: np.zeros((len(theta), 1)), "shape of log_likelihood"),
        ("log_likelihood", lambda readings, theta: np.full(len(theta), np.nan), "finite at the truth"),
        ("log_likelihood", lambda readings, theta: np.zeros(len(theta)), "above 0 on average"),
    ],
)
def test_what_is_not_as_described_is_named(name, wrong, message):
    env = LINEAR()
    setattr(env, name, wrong)
    with pytest.raises(InputError, match=message):
        check_design_env(env)


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        ("belief_cov", -np.eye(2), "no covariance"),
        ("belief_mean", np.zeros(3), "shapes"),
        ("cost", -1.0, "cost"),
        ("truth", None, "missing"),
    ],
)
def test_an_info_that_is_not_as_described_is_named(key, value, message):
    class Wrong(LINEAR):
        def _seen(self):
            observation, info = super()._seen()
            return observation, {k: v for k, v in (info | {key: value}).items() if v is not None}

    with pytest.raises(InputError, match=message):
        check_design_env(Wrong())


def test_a_prior_that_is_not_that_of_reset_is_named():
    class Narrow(LINEAR):
        class prior(LINEAR.prior):  # noqa: N801
            log_density = staticmethod(lambda theta: np.where(np.abs(theta).max(1) < 1e-9, 0.0, -np.inf))
            sample = staticmethod(lambda n, seed: np.full((n, 2), 1e-10 * np.random.default_rng(seed).random()))

    with pytest.raises(InputError, match="reset draws from it"):
        check_design_env(Narrow())


def test_another_environment_is_refused():
    with pytest.raises(InputError, match="not of jawenv"):
        JawDesign(gym.make("CartPole-v1"))
