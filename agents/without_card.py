"""Policies whose network no card describes: their checkpoint itself says where they play."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from jawenv.base.files import validate
from jawenv.envs.configuration import Configuration
from jawenv.playing.policies.card import CorrectedManeuver, Environment, ModelCard


def plays_in(world: Configuration, residual: CorrectedManeuver | None) -> dict[str, Any]:
    """What a checkpoint keeps, as its attribute ``plays``: the environment, and the maneuver that is corrected."""
    corrected = None if residual is None else residual.model_dump(mode="json")
    return {"environment": Environment.of(world).model_dump(mode="json"), "residual": corrected}


def card_in(path: Path, shape: tuple[int, ...] | None, plays: Any) -> ModelCard | None:
    """What a checkpoint says as far as a card would; None if it says nothing.

    Args:
        path: of the checkpoint.
        shape: of the policy's observations.
        plays: as `plays_in` made it.
    """
    if not isinstance(plays, dict):
        return None
    residual = plays.get("residual")
    part: dict[str, Any] = {
        "environment": validate(Environment, plays.get("environment"), str(path)),
        "observation_size": int(np.prod(shape or (0,))),
        "residual": None if residual is None else validate(CorrectedManeuver, residual, str(path)),
    }
    return ModelCard.model_construct(**part)
