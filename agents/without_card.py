"""Policies whose network no card describes: their checkpoint itself says where they play."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from jawenv.base.files import validate
from jawenv.envs.configuration import Configuration
from jawenv.playing.policies.card import CorrectedManeuver, Environment, ModelCard


def plays_in(world: Configuration, residual: CorrectedManeuver | None) -> dict[str, Any]:
    """Environment and corrected maneuver, as a checkpoint keeps them in its attribute ``plays``."""
    corrected = None if residual is None else residual.model_dump(mode="json")
    return {"environment": Environment.of(world).model_dump(mode="json"), "residual": corrected}


def card_in(path: Path, shape: tuple[int, ...] | None, plays: Any) -> ModelCard | None:
    """The part of a card that a checkpoint holds; None if it holds none.

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
