"""Recorded episodes for the tests of estimators."""

from dataclasses import replace
from functools import cache

import newton_euler as twin
import numpy as np

from agents import load_agent
from jawenv.playing.rollout import play

SWINGS = "opening_with_swings_and_fore_aft"
NO_NOISE = {
    "unmodelled_force_N": 1e-9,
    "unmodelled_moment_N_m": 1e-11,
    "cell_force_N": 0.0,
    "cell_moment_N_m": 0.0,
    "cell_gain": 0.0,
}


@cache
def records(model, agent=SWINGS, patients=4):
    """Episodes of 30 s as the device sees them."""
    env_id = f"jawenv/{model}-v3"
    return play(
        load_agent(agent, control="force"), patients=patients, seed=5000, env_id=env_id, env_kwargs={"record": True}
    ).records


@cache
def quiet_records(model, patients=2):
    """Episodes in which nothing unmodelled acts, read without noise; the noise that the readings claim is as ever."""
    env_id, kwargs = f"jawenv/{model}-v3", {"record": True, "device": NO_NOISE}
    played = play(load_agent(SWINGS, control="force"), patients=patients, seed=5000, env_id=env_id, env_kwargs=kwargs)
    return tuple(
        replace(
            record,
            measured=np.array([twin.measurement(record.jaw, state) for state in record.states]),
            samples=record.wrenches,
            wrench_sd=np.repeat([0.1, 3e-3], 3),
        )
        for record in played.records
    )
