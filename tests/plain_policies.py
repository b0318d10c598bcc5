"""A policy of random weights and its card, as a training run or an export leaves them."""

import hashlib
from pathlib import Path

import numpy as np
from safetensors.numpy import save

from jawenv.base.files import validate, write_json
from jawenv.envs.configuration import configure
from jawenv.envs.observation import Parts
from jawenv.playing.maneuvers import Maneuver
from jawenv.playing.policies.card import CARD, WEIGHTS, Environment, ModelCard
from jawenv.playing.policies.residual import N_FEATURES

LAYERS = (Parts().size, 5, 4)


def random_weights(layers: tuple[int, ...] = LAYERS) -> dict[str, np.ndarray]:
    stream = np.random.default_rng(3)
    weights = {}
    for i, (inputs, outputs) in enumerate(zip(layers, layers[1:], strict=False)):
        weights[f"layers.{i}.weight"] = stream.normal(size=(outputs, inputs)).astype(np.float32)
        weights[f"layers.{i}.bias"] = stream.normal(size=outputs).astype(np.float32)
    return weights


def fields(content: bytes = b"", **changed: object) -> dict:
    """The fields of a card for these weights."""
    environment = {
        "id": "jawenv/Jaw-v3",
        "control": "trajectory",
        "control_hz": 10.0,
        "sensors": "pose",
        "reward": "bound",
        "cohort": "trismus",
        "episode_s": 12.0,
    }
    return {
        "format_version": 1,
        "environment": environment,
        "observation_size": Parts().size,
        "action_size": 4,
        "architecture": {"layers": LAYERS, "activation": "tanh", "squash": "clip"},
        "algorithm": "ppo",
        "seed": 3,
        "steps": 1000,
        "jawenv_version": "0.1.0",
        "config_sha256": "0" * 64,
        "weights_sha256": hashlib.sha256(content).hexdigest(),
        "licence": "MIT",
        "date": "2030-01-02",
        "commands": ["python -m training train ppo"],
    } | changed


def write_policy(folder: Path, weights: dict[str, np.ndarray] | None = None, **changed: object) -> Path:
    """Write card and weights that belong together."""
    content = save(random_weights() if weights is None else weights)
    folder.mkdir(parents=True, exist_ok=True)
    (folder / WEIGHTS).write_bytes(content)
    write_json(folder / CARD, validate(ModelCard, fields(content, **changed), "card"))
    return folder


def write_corrector(
    folder: Path, maneuver: str | Maneuver, scale: float = 0.3, gain: float = 1.0, **world: object
) -> Path:
    """Write a policy that corrects a maneuver, in targets control; with a gain of 0 it plays the maneuver."""
    layers = (Parts().size + N_FEATURES, *LAYERS[1:])
    base = Maneuver.named(maneuver) if isinstance(maneuver, str) else maneuver
    where = Environment.of(configure({"control": "targets", **world}))
    return write_policy(
        folder,
        {name: (gain * values).astype(np.float32) for name, values in random_weights(layers).items()},
        observation_size=layers[0],
        architecture={"layers": layers, "activation": "tanh", "squash": "clip"},
        residual={"maneuver": base, "scale": scale},
        environment=where.model_dump(mode="json"),
    )
