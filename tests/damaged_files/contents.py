"""A small whole file of each kind that is not there already."""

import json
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pandas as pd
from gymnasium import spaces

import jawenv
from agents.replay import Replay
from eval.kept.tables import write_table
from jawenv.anatomy import cohort
from jawenv.envs.configuration import Configuration
from jawenv.ladder import model_named
from jawenv.recordings import defaults
from jawenv.recordings.files import save_record
from jawenv.recordings.record import Record

ANATOMY = """[mandible]
mass_kg = 0.25
mouthpiece_m = [0.08, 0.0, -0.045]

[fossa]
drop_m = 0.003

[attachments.superficial_masseter]
origin_m = [0.031, -0.058, -0.009]
"""
COHORT = """name = "stiff left"

[[groups]]
left = {F_o_N = 2.0, F_o_sd = 0.5, b = 7.0, b_sd = 0.3}
right = {F_o_N = 0.3, F_o_sd = 0.5, b = 7.0, b_sd = 0.3}
"""
EVALUATIONS = "steps,return,worst_sd\n" + "".join(f"{1000 * k},{0.5 * k},{0.2 / (k + 1):.6g}\n" for k in range(30))


def patient() -> str:
    """A patient, as JSON."""
    names = jawenv.MUSCLE_NAMES
    fields = {"name": "stiff", "F_o_N": dict.fromkeys(names, 2.0), "b": dict.fromkeys(names, 7.0)}
    return json.dumps(fields | {"head_tilt_deg": 3.0}, indent=1)


def numbers(kind: Any) -> str:
    """All fields of a class of numbers, as TOML."""
    made = kind()
    return "".join(f"{name} = {float(getattr(made, name))}\n" for name in kind.numeric_fields())


def recording(folder: Path) -> None:
    """A short record, as CSV and as Parquet."""
    rng = np.random.default_rng(0)
    rung, jaw = model_named("jaw"), defaults.geometry_of(Configuration())
    names, ticks = rung.muscles.parameter_names, 20
    measured = rng.normal(size=(ticks + 1, 12))
    measured[3, 4] = np.nan
    record = Record(
        time=np.arange(ticks + 1) * 0.01,
        measured=measured,
        samples=rng.normal(size=(ticks, 3, 6)),
        start_mean=rng.normal(size=10),
        start_sd=np.ones(10),
        measurement_sd=np.ones(12),
        wrench_sd=np.ones(6),
        cell_sd=np.ones(6) * 0.1,
        gain_sd=0.02,
        jaw=jaw,
        prior=cohort("wide", rung.muscles).prior,
        parameter_names=names,
        control="force",
        truth=rng.normal(size=len(names)),
    )
    for ending in ("csv", "parquet"):
        save_record(record, folder / f"a.{ending}")


def table(folder: Path) -> None:
    """Results of 60 patients."""
    sd = np.random.default_rng(0).random(60)
    frame = pd.DataFrame({"entry": ["refined"] * 60, "seed": np.arange(60), "worst_sd": sd, "ranked": sd < 0.5})
    write_table(frame, folder / "a.parquet", {"command": "eval compare", "seeds": [500, 559]})


def replay(folder: Path) -> None:
    """Recorded actions."""
    Replay("replay", np.random.default_rng(0).uniform(-1, 1, (2, 10, 4)), 5.0).save(folder / "a.safetensors")


class _Blank(gym.Env):
    """Has the spaces that a policy is built for; nobody steps it."""

    observation_space = spaces.Box(-1.0, 1.0, (9,), np.float32)
    action_space = spaces.Box(-1.0, 1.0, (4,), np.float32)


def checkpoint(folder: Path) -> None:
    """A checkpoint that a run goes on from."""
    from stable_baselines3 import PPO

    kwargs = {"net_arch": [8, 8]}
    PPO("MlpPolicy", _Blank(), seed=1, device="cpu", policy_kwargs=kwargs).save(folder / "step_1.zip")


def actions_of(agent: Any, size: int = jawenv.envs.observation.Parts().size) -> bytes:
    """What an agent does at three observations."""
    seen = np.random.default_rng(0).uniform(-1, 1, (3, size)).astype(np.float32)
    agent.reset(3, seed=0)
    return np.asarray(agent.predict(seen)[0]).tobytes()
