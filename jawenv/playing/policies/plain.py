"""Trained policies of plain weights, played in NumPy; neither weights nor card can run code."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType

import numpy as np
from safetensors import SafetensorError
from safetensors.numpy import load

from jawenv.base.errors import InputError
from jawenv.base.files import atomic_write
from jawenv.base.reading import read_bytes
from jawenv.controls import Control
from jawenv.envs.configuration import Configuration
from jawenv.envs.observation import Parts
from jawenv.ladder import env_id_of, model_of_env
from jawenv.playing.agents import Action, Agent, Array, BatchAgent, Mask, Observation, State
from jawenv.playing.policies.card import CARD, WEIGHTS, ModelCard, read_card
from jawenv.playing.policies.following import decision_hz
from jawenv.playing.policies.inputs import OwnParts, OwnPrior
from jawenv.playing.policies.residual import N_FEATURES, BaseTargets, ResidualPolicy

LARGEST_WEIGHTS = 256 * 2**20
"""Bytes."""


def elu(x: Array) -> Array:
    """Exponential linear unit."""
    return np.where(x > 0.0, x, np.expm1(np.minimum(x, 0.0)))


ACTIVATIONS: Mapping[str, Callable[[Array], Array]] = MappingProxyType(
    {"tanh": np.tanh, "relu": lambda x: np.maximum(x, 0.0), "elu": elu}
)


class PlainPolicy(BatchAgent):
    """A multilayer perceptron that acts as its policy does without chance.

    Args:
        name: label in tables.
        card: its model card.
        weights: its parameters, by the names and with the shapes of `Architecture.shapes`.

    Attributes:
        name: label in tables.
        card: its model card, with its environment.
        control: of its actions; "targets" if they correct a maneuver.
        weights: its parameters, in double precision.
    """

    def __init__(self, name: str, card: ModelCard, weights: Mapping[str, np.ndarray]) -> None:
        self.name, self.card = name, card
        self.control: Control = card.environment.control if card.residual is None else "targets"
        # Twice the precision of the weights: an action then hardly depends on how many worlds are computed at once.
        self.weights = {key: np.asarray(values, dtype=np.float64) for key, values in weights.items()}
        self._activation = ACTIVATIONS[card.architecture.activation]
        world = card.environment.world()
        self._own_prior = OwnPrior(world.build_cohort().prior)
        # On a maneuver `ResidualPolicy` picks the parts.
        self._own_parts = OwnParts(world.parts, name) if card.residual is None else None

    def take_world(self, world: Configuration) -> None:
        """Get to know the parts of the observations, and the prior, of the worlds that are to be played."""
        if self._own_parts is not None:
            self._own_parts.take(world.parts)
        self._own_prior.take(world.build_cohort().prior)

    def _seen(self, rows: Observation) -> Observation:
        return self._own_prior(rows if self._own_parts is None else self._own_parts(rows))

    def _answer(
        self, rows: Observation, state: State, starts: Mask | None, deterministic: bool
    ) -> tuple[Action, State]:
        return self._act(self._seen(rows).astype(np.float64)), None

    def _act(self, values: Array) -> Action:
        """Actions (N, 4) for inputs of the first layer (N, inputs)."""
        last = len(self.card.architecture.layers) - 2
        for i in range(last + 1):
            values = values @ self.weights[f"layers.{i}.weight"].T + self.weights[f"layers.{i}.bias"]
            values = self._activation(values) if i < last else values
        squashed = np.tanh(values) if self.card.architecture.squash == "tanh" else np.clip(values, -1.0, 1.0)
        return squashed.astype(np.float32)


def write_policy(folder: Path, weights: bytes, card: ModelCard) -> None:
    """Write weights and card, in place of older ones, which stay until both new files lie beside them."""
    with atomic_write(folder / CARD) as new_card, atomic_write(folder / WEIGHTS) as new_weights:
        new_weights.write_bytes(weights)
        new_card.write_text(card.model_dump_json(indent=2) + "\n", encoding="utf-8")


def read_weights(folder: Path, card: ModelCard) -> bytes:
    """The file of weights that a card belongs to."""
    path = folder / WEIGHTS
    if not path.exists():
        raise InputError(f"{path}: no such file, but a card without its weights is no policy")
    content = read_bytes(path, LARGEST_WEIGHTS)
    digest = hashlib.sha256(content).hexdigest()
    if digest != card.weights_sha256:
        raise InputError(f"{path}: sha256 is {digest}, the card's weights_sha256 is {card.weights_sha256}")
    return content


def load_plain(folder: Path, env_id: str | None = None) -> Agent:
    """Load a policy by its folder, with the maneuver that it corrects.

    Args:
        folder: of card and weights.
        env_id: of the environment that it shall play, as `jawenv.ladder.model_of_env` takes it, to be checked.
    """
    card = read_card(folder)
    world = card.environment.world()
    if env_id is not None and model_of_env(env_id).name != world.model:
        raise InputError(f"{folder}: the policy was trained in {world.env_id}, not in {env_id_of(env_id)}")
    check_inputs(folder, card.observation_size, card, world.parts, world.env_id)
    return on_maneuver(PlainPolicy(folder.resolve().name, card, _read_arrays(folder, card)), folder, card)


def check_inputs(path: Path, size: int, card: ModelCard | None, parts: Parts, env_id: str) -> None:
    """Make sure that parts of an observation give a policy's inputs, with the maneuver that it corrects."""
    seen = parts.size + (0 if card is None or card.residual is None else N_FEATURES)
    if size != seen:
        raise InputError(f"{path}: the policy was trained on observations of {size} values, {env_id} gives {seen}")


def on_maneuver(policy: Agent, path: Path, card: ModelCard) -> Agent:
    """The policy itself, or with the maneuver that it corrects."""
    if card.residual is None:
        return policy
    base = BaseTargets(card.residual.maneuver, card.residual.scale, decision_hz(card.environment.kwargs()))
    return ResidualPolicy(policy, base, path, card.environment.world().parts)


def arrays_in(path: Path, content: bytes) -> dict[str, np.ndarray]:
    """The arrays that a file of safetensors holds, by their names."""
    try:
        return load(content)
    except (SafetensorError, KeyError, ValueError, TypeError, AttributeError) as error:
        raise InputError(f"{path}: damaged safetensors: {' '.join(str(error).split())[:120]}") from None


def _read_arrays(folder: Path, card: ModelCard) -> dict[str, np.ndarray]:
    """The weights that a card belongs to, of the shapes of its architecture."""
    path, shapes = folder / WEIGHTS, card.architecture.shapes()
    weights = arrays_in(path, read_weights(folder, card))
    if set(weights) != set(shapes):
        odd = sorted(set(weights) ^ set(shapes))
        raise InputError(f"{path}: {odd[0]} is in the weights or in the card's architecture, but not in both")
    for name, shape in shapes.items():
        values = weights[name]
        if values.shape != shape or values.dtype != np.float32:
            raise InputError(
                f"{path}: {name} has shape {values.shape} and type {values.dtype}, "
                f"the card's architecture asks for {shape} and float32"
            )
        if not np.isfinite(values).all():
            raise InputError(f"{path}: {name} holds a value that is not finite")
    return weights
