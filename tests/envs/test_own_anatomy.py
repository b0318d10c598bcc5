"""A patient who comes again has the same anatomy, and the device sits anew."""

import gymnasium as gym
import numpy as np

import jawenv

ANATOMY = ("origin", "insertion", "l_o", "fossa_drop", "fossa_frequency", "mass", "centre_of_mass", "damping_sliding")
SESSION = ("gravity", "mouthpiece", "zero")


def truths(patients, seeds):
    """The truth of each of some episodes."""
    env = gym.make("jawenv/Jaw-v3", knowledge="imaged").unwrapped
    found = []
    for patient, seed in zip(patients, seeds, strict=True):
        env.reset(seed=seed, options={"patient": patient})
        found.append(env.simulation.worlds["truth"].copy()[0])
    return found


def test_the_seed_of_an_anatomy_decides_it_and_nothing_else():
    patient = jawenv.cohort("trismus").draw(np.random.default_rng(0))
    own, other = (patient.model_copy(update={"anatomy_seed": seed}) for seed in (1, 2))
    first, again, another, drawn = truths([own, own, other, patient], [5, 6, 5, 5])
    for name in ANATOMY:
        np.testing.assert_array_equal(first["jaw"][name], again["jaw"][name], err_msg=name)
        assert not np.array_equal(first["jaw"][name], another["jaw"][name]), name
    for name in SESSION:
        assert not np.array_equal(first["jaw"][name], again["jaw"][name]), name
        np.testing.assert_array_equal(first["jaw"][name], another["jaw"][name], err_msg=name)
        np.testing.assert_array_equal(first["jaw"][name], drawn["jaw"][name], err_msg=name)
    for name in ("cell_offset", "turn"):
        assert not np.array_equal(first[name], again[name])
        np.testing.assert_array_equal(first[name], drawn[name])


def test_an_anatomy_that_is_known_exactly_has_no_use_for_it():
    patient = jawenv.cohort("trismus").draw(np.random.default_rng(0))
    jaws = []
    for seed in (None, 1):
        env = gym.make("jawenv/Jaw-v3").unwrapped
        env.reset(seed=5, options={"patient": patient.model_copy(update={"anatomy_seed": seed})})
        jaws.append(env.simulation.worlds["truth"]["jaw"][0].tobytes())
    assert jaws[0] == jaws[1]
