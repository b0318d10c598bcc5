"""The ladder of models, from a hinge with one muscle to their portions, as the thesis of Young (2016) climbs it.

All models share device, sensors, filter, rewards and rendering. They differ in which muscles have a stiffness of their
own, which coordinates can move, and in the *plant*: the mechanics of the true jaw, which the filter may know only
approximately.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Literal

from jawenv.anatomy.muscles import MuscleSet, known_muscle_sets
from jawenv.base.errors import InputError, meant, not_among, shown
from jawenv.mechanics.building import ALL_FREE

Plant = Literal["midline", "contact"]


@dataclass(frozen=True)
class Model:
    """One rung of the ladder."""

    name: str  # as the environment's argument ``model`` takes it
    title: str  # the environment's name without namespace and version
    muscle_set: str  # key of ``known_muscle_sets``
    free: tuple[bool, bool, bool, bool, bool]
    """Freedom of x, y, theta, psi, alpha in the filter's model and in the midline plant."""
    plant: Plant
    """Mechanics of the truth: ``midline`` (one point on the fossa, compiled, the filter's own), ``contact`` (planar
    rigid body with contact and friction, pymunk).
    """
    shows: str  # what the model can show
    hides: str  # what it cannot

    @property
    def env_id(self) -> str:
        """Gymnasium's id."""
        return f"jawenv/{self.title}-v3"

    @property
    def muscles(self) -> MuscleSet:
        """The muscles with their lines of action."""
        return known_muscle_sets()[self.muscle_set]


MODELS: Mapping[str, Model] = MappingProxyType(
    {
        model.name: model
        for model in (
            Model(
                "hinge",
                "JawHinge",
                "closers",
                (False, False, True, False, False),
                "midline",
                "the muscle law itself: F_o and b separate only when the jaw is opened far",
                "the condyle's slide, sides, the muscles' different lines of action",
            ),
            Model(
                "sagittal",
                "JawSagittal",
                "pairs",
                (True, False, True, False, False),
                "contact",
                "the slide over the eminence, the fore-aft force, and a plant with contact and friction that the "
                "filter does not know",
                "sides",
            ),
            Model(
                "sides",
                "JawSides",
                "sides",
                ALL_FREE,
                "midline",
                "left against right: which side is stiff",
                "which muscle is stiff",
            ),
            Model(
                "jaw",
                "Jaw",
                "whole",
                ALL_FREE,
                "midline",
                "each closing muscle of each side: the reference",
                "portions of a muscle; the midline point resists no roll",
            ),
            Model(
                "portions",
                "JawPortions",
                "portions",
                ALL_FREE,
                "midline",
                "how far the portions of one muscle can be told apart",
                "the midline point resists no roll",
            ),
        )
    }
)
"""Every model by its name, simplest first."""


def model_named(name: str) -> Model:
    """The model of that name."""
    if not isinstance(name, str) or name not in MODELS:
        raise not_among("model", name, MODELS)
    return MODELS[name]


DEFAULT_ENV = "jawenv/Jaw-v3"
KNOWN_WITHIN_SDS = "jawenv/JawImaged-v3"
"""The whole jaw with other arguments: known within sds, and disturbed by what lasts."""


def model_of_env(env: str) -> Model:
    """The model that an environment runs, by its id, its id without namespace and version, or the model's own name."""
    if env in (KNOWN_WITHIN_SDS, title_of_env(KNOWN_WITHIN_SDS)):
        return MODELS["jaw"]
    for model in MODELS.values():
        if env in (model.env_id, model.title, model.name):
            return model
    ids = (*(model.env_id for model in MODELS.values()), KNOWN_WITHIN_SDS)
    near = meant(str(env), (*map(title_of_env, ids), *MODELS))
    raise InputError(f"env is {shown(env)}; {near}allowed: {', '.join(ids)}, also as JawSides or sides")


def env_id_of(env: str) -> str:
    """The id of an environment that is named as `model_of_env` takes it; the present version."""
    model = model_of_env(env)
    return KNOWN_WITHIN_SDS if env in (KNOWN_WITHIN_SDS, title_of_env(KNOWN_WITHIN_SDS)) else model.env_id


def title_of_env(env_id: str) -> str:
    """An id without namespace and version."""
    return env_id.removeprefix("jawenv/").rpartition("-v")[0]
