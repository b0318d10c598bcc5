"""Features of one's own: a function that makes of observations the rows that the networks see.

It stands in the policy, so that the policy sees them wherever it acts, and in its checkpoint by name.
"""

from __future__ import annotations

from typing import Any

import torch
from gymnasium import spaces
from stable_baselines3.common.torch_layers import BaseFeaturesExtractor
from torch import Tensor

from jawenv.base.errors import InputError
from jawenv.base.named_objects import import_named, reason


class OwnFeatures(BaseFeaturesExtractor):
    """Rows (N, k) of observations (N, size), as tensors.

    Args:
        observation_space: of the worlds.
        function: its name, ``my_module:function``.
    """

    def __init__(self, observation_space: spaces.Box, function: str) -> None:
        compute: Any = import_named(function, "network.features")
        try:
            rows: Any = compute(torch.zeros(2, *observation_space.shape))
        except Exception as error:  # code of the user's can raise anything
            raise InputError(f"network.features '{function}': {reason(error)}") from error
        if not isinstance(rows, Tensor) or rows.ndim != 2 or len(rows) != 2:
            shape = tuple(rows.shape) if isinstance(rows, Tensor) else type(rows).__name__
            raise InputError(f"network.features '{function}' makes {shape} of 2 rows; allowed: a tensor (2, k)")
        super().__init__(observation_space, rows.shape[1])
        self._compute = compute

    def forward(self, rows: Tensor) -> Tensor:
        """The features of observations."""
        features: Tensor = self._compute(rows)
        return features
