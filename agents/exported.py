"""Exported policies as agents: a card and plain weights, played in NumPy; nothing in them can run code."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType

import numpy as np

from agents.card import WEIGHTS, Architecture, ModelCard, read_card
from agents.checkpoints import LARGEST_WEIGHTS
from agents.following import decision_hz
from agents.residual import N_FEATURES, BaseTargets, ResidualPolicy
from jawenv.controls import Control
from jawenv.envs.observation import observation_size
from jawenv.errors import InputError
from jawenv.extras import needs
from jawenv.ladder import model_of_env
from jawenv.playing.agents import BatchAgent, check_size
from jawenv.playing.protocol import Action, Agent, Array, Mask, Observation, State
from jawenv.reading import read_bytes


def elu(x: Array) -> Array:
    """Exponential linear unit."""
    return np.where(x > 0.0, x, np.expm1(np.minimum(x, 0.0)))


ACTIVATIONS: Mapping[str, Callable[[Array], Array]] = MappingProxyType(
    {"tanh": np.tanh, "relu": lambda x: np.maximum(x, 0.0), "elu": elu}
)


class ExportedPolicy(BatchAgent):
    """A multilayer perceptron that acts as its policy does without chance.

    Args:
        name: what tables call it.
        card: what it is.
        weights: its parameters, by the names and with the shapes of `Architecture.shapes`.

    Attributes:
        name: what tables call it.
        card: what it is; ``card.environment`` says where it plays.
        control: of its actions; "targets" if they correct a maneuver.
    """

    def __init__(self, name: str, card: ModelCard, weights: Mapping[str, np.ndarray]) -> None:
        self.name, self.card = name, card
        self.control: Control = card.environment.control if card.residual is None else "targets"
        # Twice the precision of the weights: an action then hardly depends on how many worlds are computed at once.
        exact = {key: np.asarray(values, dtype=np.float64) for key, values in weights.items()}
        last = len(card.architecture.layers) - 1
        self._layers = [(exact[f"layers.{i}.weight"].T, exact[f"layers.{i}.bias"]) for i in range(last)]
        self._activation = ACTIVATIONS[card.architecture.activation]

    def _answer(
        self, rows: Observation, state: State, starts: Mask | None, deterministic: bool
    ) -> tuple[Action, State]:
        check_size(rows, self.card.observation_size, self.name)
        values: Array = rows.astype(np.float64)
        for weight, bias in self._layers[:-1]:
            values = self._activation(values @ weight + bias)
        weight, bias = self._layers[-1]
        values = values @ weight + bias
        squashed = np.tanh(values) if self.card.architecture.squash == "tanh" else np.clip(values, -1.0, 1.0)
        return squashed.astype(np.float32), None


def load_exported(path: str | Path, *, env_id: str | None = None) -> Agent:
    """Load an exported policy; nothing is unpickled, and PyTorch is not needed.

    Args:
        path: its folder, or the card.json in it.
        env_id: of the environment that it shall play, as `jawenv.ladder.model_of_env` takes it, to be checked.

    Raises:
        InputError: a card or weights that are missing, damaged or do not fit each other, or a policy of another
            environment.
    """
    path = Path(path)
    card = read_card(path)
    folder = path if path.is_dir() else path.parent
    trained_in = model_of_env(card.environment.id)
    if env_id is not None and model_of_env(env_id) != trained_in:
        raise InputError(f"{path}: the policy was trained in {trained_in.env_id}, not in {model_of_env(env_id).env_id}")
    seen = observation_size(len(trained_in.muscles.parameter_names)) + (N_FEATURES if card.residual else 0)
    if card.observation_size != seen:
        raise InputError(
            f"{path}: the policy was trained on observations of {card.observation_size} values, "
            f"{trained_in.env_id} gives {seen}"
        )
    weights = _read_weights(folder / WEIGHTS, card)
    return _on_maneuver(ExportedPolicy(folder.resolve().name, card, weights), folder)


def _on_maneuver(policy: ExportedPolicy, folder: Path) -> Agent:
    """The policy itself, or with the maneuver that it corrects."""
    card = policy.card
    if card.residual is None:
        return policy
    base = BaseTargets(card.residual.maneuver, card.residual.scale, decision_hz(card.environment.kwargs()))
    return ResidualPolicy(policy, base, folder, card.observation_size - N_FEATURES)


def _read_weights(path: Path, card: ModelCard) -> dict[str, np.ndarray]:
    """The weights that belong to a card, checked."""
    with needs("an exported policy", "safetensors", "train"):
        from safetensors import SafetensorError
        from safetensors.numpy import load
    if not path.exists():
        raise InputError(f"{path}: no such file, but a card without its weights is no policy")
    content = read_bytes(path, LARGEST_WEIGHTS)
    found = hashlib.sha256(content).hexdigest()
    if found != card.weights_sha256:
        raise InputError(f"{path}: sha256 is {found}, the card's weights_sha256 is {card.weights_sha256}")
    try:
        weights = load(content)
    except (SafetensorError, KeyError, ValueError, TypeError, AttributeError) as error:
        raise InputError(f"{path}: damaged safetensors: {' '.join(str(error).split())[:120]}") from None
    _check_weights(path, card.architecture, weights)
    return weights


def _check_weights(path: Path, architecture: Architecture, weights: Mapping[str, np.ndarray]) -> None:
    shapes = architecture.shapes()
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
