"""A run's best policy as it is kept in the run's folder: plain weights and a card."""

from __future__ import annotations

import hashlib
import json
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
from safetensors.numpy import save

import jawenv
from jawenv.base.files import read_mapping
from jawenv.playing.policies.card import Architecture, CorrectedManeuver, Environment, ModelCard
from jawenv.playing.policies.plain import write_policy
from training.run.config import TrainingConfig
from training.run.folder import RunFolder

NO_LICENCE = "none yet"
"""Licence of a policy that was not exported."""


def write_run_policy(
    run: RunFolder,
    config: TrainingConfig,
    environment: Environment,
    architecture: Architecture,
    residual: CorrectedManeuver | None,
    weights: dict[str, np.ndarray],
    steps: int,
) -> None:
    """Write a run's best policy into its folder.

    Args:
        run: the run.
        config: of the run.
        environment: where it is trained.
        architecture: of the network.
        residual: the maneuver that the policy corrects.
        weights: of the network.
        steps: that it has learned from.
    """
    content = save(weights)
    card = ModelCard(
        environment=environment,
        observation_size=architecture.layers[0],
        architecture=architecture,
        algorithm=config.algorithm,
        seed=config.seed,
        steps=steps,
        residual=residual,
        jawenv_version=jawenv.__version__,
        config_sha256=config_sha256(run.config_file),
        weights_sha256=hashlib.sha256(content).hexdigest(),
        licence=NO_LICENCE,
        date=datetime.now(UTC).date(),
        commands=run.commands(),
    )
    write_policy(run.path, content, card)


def config_sha256(path: Path) -> str:
    """The hash of a configuration file's content, however it is laid out."""
    canonical = json.dumps(read_mapping(path), sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(canonical.encode()).hexdigest()
