"""The question of stiff muscles: the answer of a player beside truth and estimates."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from jawenv.metrics import FIBROSED_F_O_N, whole_muscles_per_line
from jawenv.metrics.diagnosis import MEASURED
from jawenv.metrics.verdicts import NOT_MEASURED
from jawenv.rendering import palette
from jawenv.rendering.scene import Scene


def stiff_from_N(scene: Scene) -> float:
    """F_o above which a muscle of the scene's model is called stiff, N."""
    return FIBROSED_F_O_N * whole_muscles_per_line(scene.parameter_names)


def stiffness_colours(scene: Scene) -> list[palette.Colour]:
    """Colour of every line by the believed F_o of its muscle."""
    index, limit = {name: i for i, name in enumerate(scene.parameter_names)}, stiff_from_N(scene)
    forces = (math.exp(float(scene.belief_mean[index[f"log_F_o/{name}"]])) for name in scene.muscle_names)
    return [palette.stiffness(force / limit) for force in forces]


@dataclass(frozen=True)
class AnsweredMuscle:
    """A muscle of the answer."""

    muscle: str  # its name
    said: bool  # whether the player called it stiff
    true_F_o_N: float  # the truth
    F_o_N: float  # the filter's estimate
    sd: float  # standard deviation of the estimate's natural log
    prior_sd: float  # that of the filter's prior
    limit_N: float  # F_o above which it is stiff

    @property
    def stiff(self) -> bool:
        """Whether it truly is stiff."""
        return self.true_F_o_N > self.limit_N

    @property
    def estimate(self) -> str:
        """The filter's estimate in words; none where the prior speaks in place of the data."""
        return f"{self.F_o_N:.2f} ± {100 * self.sd:.1f} %" if self.sd <= MEASURED * self.prior_sd else NOT_MEASURED

    @property
    def right(self) -> bool:
        """Whether the player was right."""
        return self.said == self.stiff


def answered(scene: Scene, said: Sequence[bool]) -> list[AnsweredMuscle]:
    """The answer (M,), whether each muscle is stiff, beside the truth; empty where the scene has no truth."""
    if scene.truth is None:
        return []
    rows = []
    for muscle, stiff in zip(scene.muscles, said, strict=True):
        i = scene.parameter_names.index(f"log_F_o/{muscle}")
        truth, mean = (math.exp(float(values[i])) for values in (scene.truth, scene.belief_mean))
        sds = float(scene.belief_sd[i]), float(scene.prior_sd[i])
        rows.append(AnsweredMuscle(muscle, stiff, truth, mean, *sds, stiff_from_N(scene)))
    return rows
