"""Muscles coloured by their believed stiffness."""

from __future__ import annotations

import math

from jawenv.metrics import STIFF_F_O_N, whole_muscles_per_line
from jawenv.rendering import palette
from jawenv.rendering.scene import Scene


def stiff_from_N(scene: Scene) -> float:
    """F_o above which a muscle of the scene's model is called stiff, N."""
    return STIFF_F_O_N * whole_muscles_per_line(scene.parameter_names)


def stiffness_colours(scene: Scene) -> list[palette.Colour]:
    """Colour of every line by the believed F_o of its muscle."""
    index, limit = {name: i for i, name in enumerate(scene.parameter_names)}, stiff_from_N(scene)
    forces = (math.exp(float(scene.belief_mean[index[f"log_F_o/{name}"]])) for name in scene.muscle_names)
    return [palette.stiffness(force / limit) for force in forces]
