"""Cohort, device and patient as an object, a mapping and a file: the same environment, and a spec that survives."""

import json
import pickle
from dataclasses import asdict, replace

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.envs.registration import EnvSpec

import jawenv
from jawenv.anatomy import Stiffness
from jawenv.reality import Reality

ID = "jawenv/Jaw-v3"
ONE_SIDE = jawenv.Cohort(
    "stiff left", "left twice as stiff", "made up", ((Stiffness(2.4, 0.5, 7.0, 0.3), Stiffness(1.2, 0.5, 7.0, 0.3)),)
)
WEAK = jawenv.Device(full_scale_N=3.0)
PATIENT = jawenv.Patient(F_o_N=dict.fromkeys(jawenv.MUSCLE_NAMES, 2.0), b=dict.fromkeys(jawenv.MUSCLE_NAMES, 6.0))
TOML = """
[[groups]]
left = {F_o_N = 2.4, F_o_sd = 0.5, b = 7, b_sd = 0.3}
right = {F_o_N = 1.2, F_o_sd = 0.5, b = 7, b_sd = 0.3}
"""
YAML = """
groups:
  - left: {F_o_N: 2.4, F_o_sd: 0.5, b: 7, b_sd: 0.3}
    right: {F_o_N: 1.2, F_o_sd: 0.5, b: 7, b_sd: 0.3}
"""


@pytest.fixture
def files(tmp_path):
    """The same three things as files, by name."""
    texts = {
        "cohort.toml": TOML,
        "cohort.yaml": YAML,
        "cohort.json": json.dumps(ONE_SIDE.to_dict()),
        "device.toml": "full_scale_N = 3",
        "reality.yaml": "creep_share: 0.2",
        "patient.json": PATIENT.model_dump_json(),
    }
    for name, text in texts.items():
        (tmp_path / name).write_text(text)
    return {name: tmp_path / name for name in texts}


def first_steps(patient=None, **arguments):
    """Observations of two steps of an environment, single and as a world of two."""
    action = np.array([0.5, 0.5, 0.1, -0.1], dtype=np.float32)
    single = gym.make(ID, episode_s=1.0, **{"control": "force", **arguments})
    single.reset(seed=4, options=None if patient is None else {"patient": patient})
    together = gym.make_vec(ID, num_envs=2, episode_s=1.0, **{"control": "force", **arguments})
    together.reset(seed=4, options=None if patient is None else {"patients": [patient, None]})
    seen = [single.step(action)[0] for _ in range(2)]
    worlds = [together.step(np.tile(action, (2, 1)))[0][0] for _ in range(2)]
    np.testing.assert_array_equal(seen, worlds)
    return np.array(seen)


def test_forms_of_a_cohort(files):
    wanted = first_steps(cohort=ONE_SIDE)
    forms = [ONE_SIDE.to_dict(), str(files["cohort.toml"]), files["cohort.yaml"], files["cohort.json"]]
    for form in forms:
        np.testing.assert_array_equal(first_steps(cohort=form), wanted)
    assert np.abs(first_steps() - wanted).max() > 0.0


def test_forms_of_device_and_reality(files):
    wanted = first_steps(device=WEAK, reality=Reality(creep_share=0.2))
    for device, reality in (
        ({"full_scale_N": 3}, {"creep_share": 0.2}),
        (files["device.toml"], str(files["reality.yaml"])),
        (asdict(WEAK), asdict(Reality(creep_share=0.2))),
    ):
        np.testing.assert_array_equal(first_steps(device=device, reality=reality), wanted)


def test_forms_of_a_patient(files):
    wanted = first_steps(patient=PATIENT)
    for form in (PATIENT.model_dump(), files["patient.json"], str(files["patient.json"])):
        np.testing.assert_array_equal(first_steps(patient=form), wanted)


def test_a_cohort_serves_every_model():
    env = gym.make("jawenv/JawSides-v3", cohort=ONE_SIDE, control="force")
    _, info = env.reset(seed=0)
    assert info["truth"].shape == (4,)
    np.testing.assert_allclose(env.unwrapped.prior.mean[::2], np.log([2.4, 1.2]))


def test_specs_survive_json_and_pickle(files):
    """Names, mappings and paths as text; a device comes back as the mapping of its fields."""
    path = str(files["cohort.toml"])
    for arguments in (
        {"cohort": "severe"},
        {"cohort": ONE_SIDE.to_dict(), "device": {"full_scale_N": 3.0}},
        {"cohort": path, "device": str(files["device.toml"])},
        {"device": WEAK, "reality": Reality(creep_share=0.2), "comfort": jawenv.Comfort(force_N=9.0)},
        {"anatomy": {"mandible": {"mass_kg": 0.3}}, "comfort": {"side_mm": 8.0}},
    ):
        env = gym.make(ID, **{"control": "force", **arguments})
        for copy in (EnvSpec.from_json(env.spec.to_json()), pickle.loads(pickle.dumps(env.spec))):
            made = gym.make(copy).unwrapped
            np.testing.assert_array_equal(made.prior.mean, env.unwrapped.prior.mean)
            assert made.configuration.device == env.unwrapped.configuration.device
            for name in ("reality", "comfort", "anatomy"):
                assert getattr(made.configuration, name) == getattr(env.unwrapped.configuration, name)
    spec = pickle.loads(pickle.dumps(gym.make(ID, cohort=ONE_SIDE, device=files["device.toml"], control="force").spec))
    assert gym.make(spec).unwrapped.simulation.cohort.name == "stiff left"


@pytest.mark.parametrize("groups", [(), [(1, 2)], ((1, 2),), "left"])
def test_groups_are_pairs_of_stiffness(groups):
    with pytest.raises(jawenv.InputError):
        replace(ONE_SIDE, groups=groups)
