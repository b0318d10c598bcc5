"""Short records for the tests of estimators, played on the real environment."""

from dataclasses import replace
from functools import cache

import numpy as np
from newton_euler import measurement
from numpy_model import step

import jawenv
from agents import load_agent
from jawenv.mechanics import build_jaw

SWINGS = "opening_with_swings_and_fore_aft"

# A filter is compiled for a number of columns. With the errors of motors or straps these are as many as "imaged" has,
# which is compiled for other tests too; nothing of them is about the mounting.
BODY = {"attachments": 0.1, "fossa": 0.1, "mass": 0.1, "head_tilt_deg": 3.0, "damping": 0.2, "closing_tone_N": 0.05} | {
    f"centre_of_mass_{axis}_mm": sd for axis, sd in zip("xyz", (4.0, 1.0, 6.0), strict=True)
}


class Waves:
    """Each motor pushes in a sine of its own, strongly enough to teach something within seconds."""

    frequencies = np.array([0.9, 0.6, 1.1, 0.7])  # Hz

    def reset(self, num_envs, seed):
        self.time = 0.0

    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        self.time += 0.05
        action = 0.35 * np.sin(2.0 * np.pi * self.frequencies * self.time)
        return np.tile(action, (len(observation), 1)).astype(np.float32), state


@cache
def recording(model="jaw", patients=1, seconds=3.0, cohort="trismus"):
    """Quick to play and rich, but it presses the teeth together."""
    kwargs = {"record": True, "control": "force", "model": model, "episode_s": seconds, "cohort": cohort}
    return jawenv.play(Waves(), patients=patients, seed=5000, env_kwargs=kwargs)


@cache
def opening(cohort="trismus"):
    """Eight patients, 30 s of a maneuver that keeps within comfort."""
    agent = load_agent(SWINGS, control="force")
    return jawenv.play(agent, patients=8, seed=6000, env_kwargs={"record": True, "cohort": cohort})


def held(record):
    """A record of a jaw that only slides and opens in its plane, under the same forces: nothing new to compile.

    Its muscles are alike on both sides, and its motion is that of the independent model.
    """
    planar = np.array([True, False, True, False, False])
    free = np.concatenate([planar, [True, False, False, True, False]])  # u turns about x, y, z; opening about y
    jaw = build_jaw(free=tuple(planar))
    jaw["gravity"] = record.jaw["gravity"]
    truth = record.prior.mean + 0.1
    samples = record.samples * np.array([1.0, 0.0, 1.0, 0.0, 1.0, 0.0])
    states = [np.where(free, record.states[0], 0.0)]
    for reading in samples:
        states.append(step(jaw, np.concatenate([states[-1], truth, [0.0]]), reading, np.zeros(6), record.dt))
    noise = record.measurement_sd * np.random.default_rng(5000).normal(size=(len(states), 12))
    return replace(
        record,
        jaw=jaw,
        truth=truth,
        states=np.array(states),
        samples=samples,
        measured=np.array([measurement(jaw, state) for state in states]) + noise,
        start_mean=np.where(free, record.start_mean, 0.0),
        start_sd=np.where(free, record.start_sd, 0.0),
    )


def share(record, mean, cov):
    """NEES / 12 of a belief about a record's patient."""
    error = mean - record.truth
    return error @ np.linalg.solve(cov, error) / len(error)


class Actions:
    """What an agent did, (N, 4) for each step, as `jawenv.play` tells it (`on_step`)."""

    def __init__(self):
        self.actions = []

    def __call__(self, env, action):
        if action is not None:
            self.actions.append(np.array(action))
