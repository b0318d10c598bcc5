"""Trained policies as agents: a card and plain weights, played in NumPy; or a checkpoint of stable-baselines3.

Weights and card can run no code. A checkpoint is a pickle, which can: it is read only where the caller trusts it.
"""

from __future__ import annotations

import hashlib
import zipfile
from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np
from scipy.special import expit

from agents.card import CARD, WEIGHTS, Architecture, ModelCard, card_of, policy_folder, read_card
from agents.following import decision_hz
from agents.residual import N_FEATURES, BaseTargets, ResidualPolicy
from jawenv.controls import Control
from jawenv.envs.observation import observation_size
from jawenv.errors import InputError
from jawenv.extras import needs
from jawenv.files import atomic_write, write_json
from jawenv.ladder import DEFAULT_ENV, model_of_env
from jawenv.playing.agents import BatchAgent, Memory, Remembering, check_size
from jawenv.playing.protocol import Action, Agent, Array, Mask, Observation, State
from jawenv.reading import open_file, read_bytes

if TYPE_CHECKING:
    from stable_baselines3.common.policies import BasePolicy

LARGEST_WEIGHTS = 256 * 2**20
"""Bytes."""
ENTRIES = ("data", "policy.pth")
"""Members of every checkpoint."""


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

    def _answer(
        self, rows: Observation, state: State, starts: Mask | None, deterministic: bool
    ) -> tuple[Action, State]:
        check_size(rows, self.card.observation_size, self.name)
        return self._act(rows.astype(np.float64)), None

    def _act(self, values: Array) -> Action:
        """Actions (N, 4) for inputs of the first layer (N, inputs)."""
        last = len(self.card.architecture.layers) - 2
        for i in range(last + 1):
            values = values @ self.weights[f"layers.{i}.weight"].T + self.weights[f"layers.{i}.bias"]
            values = self._activation(values) if i < last else values
        squashed = np.tanh(values) if self.card.architecture.squash == "tanh" else np.clip(values, -1.0, 1.0)
        return squashed.astype(np.float32)


class RecurrentPlainPolicy(Remembering, PlainPolicy):
    """The same behind an LSTM (Hochreiter & Schmidhuber 1997, Neural Computation 9:1735)."""

    def __init__(self, name: str, card: ModelCard, weights: Mapping[str, np.ndarray]) -> None:
        super().__init__(name, card, weights)
        units = card.architecture.lstm_units
        self._remembered = (np.dtype((np.float64, (units,))),) * 2  # outputs and cells of the LSTM

    def _decide(
        self, rows: Observation, memory: Memory, starts: Mask | None, deterministic: bool
    ) -> tuple[Action, Memory]:
        check_size(rows, self.card.observation_size, self.name)
        (hidden, cell), weights = memory.of_worlds, self.weights
        gates = rows.astype(np.float64) @ weights["lstm.input"].T + hidden @ weights["lstm.hidden"].T
        enter, forget, new, leave = np.split(gates + weights["lstm.bias"], 4, axis=1)
        cell = expit(forget) * cell + expit(enter) * np.tanh(new)
        hidden = expit(leave) * np.tanh(cell)
        return self._act(hidden), Memory((hidden, cell))


class TrainedPolicy(BatchAgent):
    """A policy out of a stable-baselines3 checkpoint, whichever of its algorithms trained it.

    Attributes:
        name: the checkpoint and its folder.
        control: control mode of its actions; None where no run's card says it.
        path: the checkpoint.
        observation_size: how many values the policy wants to see.
        policy: stable-baselines3's own.
    """

    def __init__(self, path: Path, policy: BasePolicy, control: Control | None = None) -> None:
        self.name = f"{path.resolve().parent.name}/{path.stem}"
        self.control = control
        self.path = path
        self.observation_size = int(np.prod(policy.observation_space.shape or (0,)))
        self.policy = policy
        self._state: State = None

    def reset(self, num_envs: int, seed: int | None = None) -> None:
        """Forget the memory, if the policy is recurrent; seed the draws of a stochastic policy."""
        self._state = None
        if seed is not None:
            from stable_baselines3.common.utils import set_random_seed

            set_random_seed(seed)

    def _answer(
        self, rows: Observation, state: State, starts: Mask | None, deterministic: bool
    ) -> tuple[Action, State]:
        check_size(rows, self.observation_size, self.path)
        memory = self._state if state is None else state
        action, self._state = self.policy.predict(rows, memory, starts, deterministic)
        return action, self._state


def load_policy(path: str | Path, *, env_id: str | None = None, trust: bool = False) -> Agent:
    """Load a policy by its folder (a run's, or an exported policy's), its card, or a checkpoint (.zip).

    A checkpoint in a run's folder comes with the maneuver that the run corrects.

    Args:
        path: folder, card or checkpoint.
        env_id: of the environment that it shall play, as `jawenv.ladder.model_of_env` takes it, to be checked.
        trust: whether a stable-baselines3 checkpoint may be unpickled.

    Raises:
        InputError: a card or weights that are missing, damaged or do not fit each other, no checkpoint, one that is
            not trusted, or a policy of another environment.
    """
    path = Path(path)
    folder = policy_folder(path)
    return _of_checkpoint(path, env_id or DEFAULT_ENV, trust) if folder is None else _of_card(folder, env_id)


def write_policy(folder: Path, weights: bytes, card: ModelCard) -> None:
    """Write weights and card, in place of older ones.

    The older card goes first and the new one comes last: without its card a folder is no policy.

    Raises:
        InputError: the folder cannot be written.
    """
    (folder / CARD).unlink(missing_ok=True)
    with atomic_write(folder / WEIGHTS) as unfinished:
        unfinished.write_bytes(weights)
    write_json(folder / CARD, card)


def read_weights(folder: Path, card: ModelCard) -> bytes:
    """The file of weights that a card belongs to.

    Raises:
        InputError: no such file, or weights of another card.
    """
    path = folder / WEIGHTS
    if not path.exists():
        raise InputError(f"{path}: no such file, but a card without its weights is no policy")
    content = read_bytes(path, LARGEST_WEIGHTS)
    digest = hashlib.sha256(content).hexdigest()
    if digest != card.weights_sha256:
        raise InputError(f"{path}: sha256 is {digest}, the card's weights_sha256 is {card.weights_sha256}")
    return content


def _of_card(folder: Path, env_id: str | None) -> Agent:
    card = read_card(folder)
    trained_in = model_of_env(card.environment.id)
    if env_id is not None and model_of_env(env_id) != trained_in:
        played_in = model_of_env(env_id).env_id
        raise InputError(f"{folder}: the policy was trained in {trained_in.env_id}, not in {played_in}")
    _check_size(folder, card.observation_size, card, trained_in.env_id)
    weights = _checked(folder / WEIGHTS, card.architecture, read_weights(folder, card))
    kind = PlainPolicy if card.architecture.lstm_units is None else RecurrentPlainPolicy
    return _on_maneuver(kind(folder.resolve().name, card, weights), folder, card)


def _of_checkpoint(path: Path, env_id: str, trust: bool) -> Agent:
    _check_checkpoint(path)
    if not trust:
        raise InputError(
            f"{path}: a checkpoint is unpickled, which can run code; allowed if you trust its origin: --trust (in "
            "Python trust=True)"
        )
    policy = _unpickled(path)
    shape = policy.action_space.shape
    if shape != (4,):
        raise InputError(f"{path}: the policy's actions have shape {shape}, jawenv's environments take (4,)")
    run = card_of(path)
    card = None if run is None else run[1]
    trained = TrainedPolicy(path, policy, None if card is None else card.environment.control)
    _check_size(path, trained.observation_size, card, env_id)
    return trained if card is None else _on_maneuver(trained, path, card)


def _check_size(path: Path, size: int, card: ModelCard | None, env_id: str) -> None:
    """Make sure that an environment gives the inputs of a policy, with the targets of the maneuver that it corrects."""
    seen = observation_size(len(model_of_env(env_id).muscles.parameter_names))
    seen += 0 if card is None or card.residual is None else N_FEATURES
    if size != seen:
        raise InputError(f"{path}: the policy was trained on observations of {size} values, {env_id} gives {seen}")


def _on_maneuver(policy: Agent, path: Path, card: ModelCard) -> Agent:
    """The policy itself, or with the maneuver that it corrects."""
    if card.residual is None:
        return policy
    base = BaseTargets(card.residual.maneuver, card.residual.scale, decision_hz(card.environment.kwargs()))
    return ResidualPolicy(policy, base, path, card.observation_size - N_FEATURES)


def _checked(path: Path, architecture: Architecture, content: bytes) -> dict[str, np.ndarray]:
    """The weights in a file, of the shapes of an architecture."""
    with needs("a policy", "safetensors", group="train"):
        from safetensors import SafetensorError
        from safetensors.numpy import load
    try:
        weights = load(content)
    except (SafetensorError, KeyError, ValueError, TypeError, AttributeError) as error:
        raise InputError(f"{path}: damaged safetensors: {' '.join(str(error).split())[:120]}") from None
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
    return weights


def _check_checkpoint(path: Path) -> None:
    """Make sure that a file is a checkpoint of a policy on unscaled observations.

    A policy trained behind stable-baselines3's `VecNormalize` would be played on inputs of another scale.
    """
    if path.is_dir():
        raise InputError(
            f"{path}: holds no policy; allowed: a folder with {CARD}, which a run has once it was evaluated"
        )
    with open_file(path) as file:
        try:
            with zipfile.ZipFile(file) as archive:
                whole = set(ENTRIES) <= set(archive.namelist())
        except (OSError, ValueError, NotImplementedError, zipfile.BadZipFile):
            whole = False
    if not whole:
        raise InputError(f"{path}: not a stable-baselines3 checkpoint (a .zip that holds {', '.join(ENTRIES)})")
    patterns = ("*normalize*.pkl", "*/*normalize*.pkl")
    statistics = [file for pattern in patterns for file in path.parent.glob(pattern)]
    if statistics:
        raise InputError(
            f"{path}: its observations were normalised (by {statistics[0].relative_to(path.parent)}), which is not "
            "applied; allowed: a policy without VecNormalize, or an agent of your own that normalises first"
        )


def _unpickled(path: Path) -> BasePolicy:
    """Rebuild a policy from the pickles of a checkpoint: this can run code."""
    from stable_baselines3.common.policies import BasePolicy
    from stable_baselines3.common.save_util import load_from_zip_file

    try:
        data, parameters, _ = load_from_zip_file(path, device="cpu")
        assert data is not None
        kwargs = dict(data["policy_kwargs"])
        if data.get("use_sde"):
            kwargs["use_sde"] = True
        # A learning rate is asked for by every policy's constructor; a policy that only acts never uses it.
        policy = data["policy_class"](data["observation_space"], data["action_space"], lambda _: 0.0, **kwargs)
        policy.load_state_dict(parameters["policy"])
    except Exception as error:  # a damaged pickle or state can raise anything
        reason = " ".join(str(error).split())[:120] or type(error).__name__
        raise InputError(f"{path}: damaged stable-baselines3 checkpoint: {reason}") from error
    assert isinstance(policy, BasePolicy)
    policy.set_training_mode(False)
    return policy
