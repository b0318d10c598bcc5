"""At the bounds of every numeric field of device, reality, comfort and patient an episode stays finite."""

import gymnasium as gym
import numpy as np
import pytest

import jawenv
from jawenv.anatomy.patient import LARGEST_B, LARGEST_F_O_N, LARGEST_SEED
from jawenv.reality import Reality

SMALLEST = np.nextafter(0.0, 1.0)
NEEDS = {  # what a field that shapes an effect needs to act
    "reflex_latency_ms": {"reflex_gain": 0.5},
    "reflex_lag_ms": {"reflex_gain": 0.5},
    "guarding_onset": {"guarding_gain": 1.0},
    "creep_time_s": {"creep_share": 0.3},
    "creep_slow_time_s": {"creep_slow_share": 0.3},
    "swallow_every_s": {"swallow_N": 1.0},
    "articular_onset": {"articular_stiffness_N_m": 3000.0},
}
BOUNDS = [
    (kind.__name__.lower(), name, value)
    for kind in (jawenv.Device, Reality)
    for name, numeric in kind.numeric_fields().items()
    for value in (0.0 if numeric.zero else SMALLEST, numeric.high)
]
STIFFNESS = {"F_o_N": 1.2, "b": 7.0, "head_tilt_deg": 0.0, "anatomy_seed": None}


def play_two_seconds(patient=None, **arguments):
    """Random actions until the end; all that a step gives must be finite."""
    env = gym.make("jawenv/Jaw-v3", episode_s=2.0, **arguments)
    env.action_space.seed(0)
    observation, info = env.reset(seed=0, options=None if patient is None else {"patient": patient})
    reward, ended = 0.0, False
    while True:
        assert np.isfinite(observation).all() and np.isfinite(reward) and np.isfinite(info["cost"])
        if ended:
            return
        observation, reward, terminated, truncated, info = env.step(env.action_space.sample())
        ended = terminated or truncated


@pytest.mark.parametrize("control", ["targets", "force", "trajectory"])
@pytest.mark.parametrize(("what", "name", "value"), BOUNDS)
def test_an_episode_at_a_bound_is_finite(what, name, value, control):
    play_two_seconds(control=control, **{what: {**NEEDS.get(name, {}), name: value}})


def test_motors_switched_against_the_strongest_brake_move_a_jaw_finitely():
    """A brake that stops the jaw within a step of the simulation throws it back faster each time."""
    device = {"slew_N_s": 1e5, "brake_N_s_m": jawenv.Device.numeric_fields()["brake_N_s_m"].high}
    env = gym.make_vec(
        "jawenv/Jaw-v3", 32, cohort="wide", control="force", device=device, episode_s=3.0, autoreset_mode="disabled"
    )
    env.reset(seed=41000)
    rng = np.random.default_rng(0)
    for step in range(60):
        if step % 4 == 0:
            actions = rng.choice([-1.0, 1.0], (32, 4)).astype(np.float32)
        observation, reward, _, _, info = env.step(actions)
        assert np.isfinite(observation).all() and np.isfinite(reward).all() and np.isfinite(info["jaw_state"]).all()
        assert info["cost"].max() < 10.0, "and no jaw is thrown about"


@pytest.mark.parametrize("name", jawenv.Comfort.numeric_fields())
@pytest.mark.parametrize("end", ["low", "high"])
def test_a_comfort_at_a_bound_is_finite_or_refused_in_one_line(name, end):
    low = 1.05 if name.endswith("_hard") else 5.0 if name in ("painless_range_mm", "largest_opening_mm") else 1e-6
    value = jawenv.Comfort.numeric_fields()[name].high if end == "high" else low
    try:
        play_two_seconds(comfort={name: value})
    except jawenv.InputError as error:
        assert "patients in a row cannot be treated" in str(error)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("F_o_N", 1e-6),
        ("F_o_N", LARGEST_F_O_N),
        ("b", 1e-6),
        ("b", LARGEST_B),
        ("head_tilt_deg", -90.0),
        ("head_tilt_deg", 90.0),
        ("anatomy_seed", 0),
        ("anatomy_seed", LARGEST_SEED),
    ],
)
def test_a_patient_at_a_bound_is_finite_or_refused_in_one_line(name, value):
    """A jaw that no comfort fits is refused when the episode begins."""
    given = STIFFNESS | {name: value}
    muscles = {key: dict.fromkeys(jawenv.MUSCLE_NAMES, given[key]) for key in ("F_o_N", "b")}
    patient = jawenv.Patient(**muscles, **{key: given[key] for key in ("head_tilt_deg", "anatomy_seed")})
    knowledge = "imaged" if name == "anatomy_seed" else "exact"
    try:
        play_two_seconds(patient, knowledge=knowledge)
    except jawenv.InputError as error:
        assert "patient" in str(error) and "\n" not in str(error)
