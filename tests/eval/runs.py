"""Folders of runs whose policy has learned nothing, and checkpoints that run code when they are unpickled."""

import base64
import json
import pickle
import zipfile
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np

from jawenv.envs.observation import Parts
from jawenv.playing.maneuvers import Maneuver
from jawenv.playing.policies.residual import N_FEATURES
from tests.plain_policies import write_corrector


class Blank(gym.Env):
    """Has the spaces of a policy that corrects a maneuver; nobody steps it."""

    observation_space = gym.spaces.Box(-np.inf, np.inf, (Parts().size + N_FEATURES,), np.float32)
    action_space = gym.spaces.Box(-1.0, 1.0, (4,), np.float32)


def save_checkpoint(path: Path, seed: int = 1) -> Path:
    from stable_baselines3 import PPO

    PPO("MlpPolicy", Blank(), seed=seed, device="cpu", policy_kwargs={"net_arch": [4]}).save(path)
    return path


def save_run(folder: Path, maneuver: str | Maneuver = "slow_opening", **world: object) -> Path:
    """The folder of a run in targets control that corrects a maneuver."""
    write_corrector(folder, maneuver, **world)
    (folder / "checkpoints").mkdir()
    save_checkpoint(folder / "checkpoints" / "step_1.zip")
    return folder


class MakesFile:
    """Makes a file when it is unpickled."""

    def __init__(self, file: Path) -> None:
        self.file = file

    def __reduce__(self) -> tuple[Any, ...]:
        return open, (str(self.file), "a")


def make_it_run_code(checkpoint: Path, file: Path) -> None:
    """Let a checkpoint make a file when its objects are unpickled."""
    with zipfile.ZipFile(checkpoint) as archive:
        content = {name: archive.read(name) for name in archive.namelist()}
    data = json.loads(content["data"])
    data["policy_class"][":serialized:"] = base64.b64encode(pickle.dumps(MakesFile(file))).decode()
    with zipfile.ZipFile(checkpoint, "w") as archive:
        for name, held in (content | {"data": json.dumps(data).encode()}).items():
            archive.writestr(name, held)
