"""The model card of a policy: its architecture, environment, training and results.

::

    FOLDER/card.json            this card
           policy.safetensors   the weights: layers.0.weight (outputs, inputs), layers.0.bias (outputs), layers.1...
           README.md            of an exported policy: the card for readers

A training run's folder has the first two from its first evaluation on: its best policy.
"""

from __future__ import annotations

from datetime import date
from pathlib import Path
from typing import Annotated, Any, Final, Literal, Self

from pydantic import Field, JsonValue, model_validator

from jawenv.base.errors import InputError, shown
from jawenv.base.files import InputModel, Number, read_mapping, validate
from jawenv.controls import Control
from jawenv.envs.configuration import Configuration, Sensors
from jawenv.playing.maneuvers import Maneuver

FORMAT_VERSION: Final = 1
CARD, WEIGHTS = "card.json", "policy.safetensors"
OF_TRAINING = ("control", "sensors", "control_hz")
"""Arguments of the environment that a policy keeps from its training, wherever it is played."""

Text = Annotated[str, Field(min_length=1)]
Sha256 = Annotated[str, Field(pattern=r"^[0-9a-f]{64}$")]
PositiveInt = Annotated[int, Field(gt=0, strict=True)]
PositiveNumber = Annotated[Number, Field(gt=0.0)]


class Environment(InputModel):
    """Environment in which the policy was trained."""

    id: Text  # Gymnasium's id
    control: Control  # control mode, the meaning of an action
    control_hz: PositiveNumber  # actions per second
    sensors: Sensors  # the measured quantities
    reward: Text  # name of the reward
    cohort: Text | dict[str, JsonValue]  # the patients, by their name or as a mapping
    episode_s: PositiveNumber  # length of an episode, s
    others: dict[str, JsonValue] = {}  # further arguments of the environment

    @classmethod
    def of(cls, world: Configuration) -> Self:
        """Environment in which a policy was trained, with the content of the files that the world was given."""
        stated = ("control", "control_hz", "sensors", "reward", "episode_s")
        others = world.arguments
        others.pop("plant", None)  # a policy plays any jaw, and a card names no code
        cohort = others.pop("cohort")
        others = {name: value for name, value in others.items() if name not in stated}
        fields: dict[str, Any] = {name: getattr(world, name) for name in stated}
        return cls(id=world.env_id, cohort=cohort, others=others, **fields)

    def world(self) -> Configuration:
        """The same as a description of a world to be played."""
        if "plant" in self.others:
            raise InputError(
                f"plant is {shown(self.others['plant'])}; allowed in a card: none, as its module would run"
            )
        return Configuration.from_mapping({"env": self.id, **self.kwargs()})

    def kwargs(self) -> dict[str, Any]:
        """Arguments for `gymnasium.make`."""
        return self.model_dump(exclude={"id", "others"}) | self.others


class Architecture(InputModel):
    """The network that acts, a multilayer perceptron."""

    layers: Annotated[tuple[PositiveInt, ...], Field(min_length=2)]
    """Sizes from the observation to the action; the hidden ones lie between."""
    activation: Literal["tanh", "relu", "elu"]  # after every layer but the last
    squash: Literal["tanh", "clip"]  # how the last layer's output gets into [-1, 1]

    def shapes(self) -> dict[str, tuple[int, ...]]:
        """Shapes of the weights by their names."""
        shapes: dict[str, tuple[int, ...]] = {}
        for i, (inputs, outputs) in enumerate(zip(self.layers, self.layers[1:], strict=False)):
            shapes |= {f"layers.{i}.weight": (outputs, inputs), f"layers.{i}.bias": (outputs,)}
        return shapes


class CorrectedManeuver(InputModel):
    """The policy corrects a maneuver."""

    maneuver: Maneuver  # the corrected maneuver, in full
    scale: PositiveNumber  # of the policy's action, which is added to the maneuver's


class Result(InputModel):
    """One figure that the policy reached, with its interval."""

    cohort: Text  # whom it was tried on
    patients: PositiveInt  # how many
    seeds: tuple[int, int]  # of the first and the last patient
    metric: Text  # the measured quantity with its unit
    mean: Number | None = None  # over the patients; or
    median: Number | None = None  # over the patients
    low: Number  # lower end of the interval
    high: Number  # upper end of the interval
    level: Annotated[Number, Field(gt=0.0, lt=1.0)] = 0.95  # of confidence of the interval

    @model_validator(mode="after")
    def _one_figure(self) -> Self:
        if (self.mean is None) == (self.median is None):
            raise ValueError(f"{self.metric}: give either mean or median")
        if self.low > self.high:
            raise ValueError(f"{self.metric}: low is {self.low:g}; allowed: at most high, {self.high:g}")
        return self


class ModelCard(InputModel):
    """All that is known of a policy."""

    format_version: Literal[1] = FORMAT_VERSION  # of card and weights
    environment: Environment  # where it was trained, its cohort with it
    observation_size: PositiveInt  # values that the network sees
    action_size: Literal[4] = 4  # values that it gives
    architecture: Architecture  # of the network
    algorithm: Text  # that trained it
    seed: Annotated[int, Field(ge=0, strict=True)]  # of the training
    steps: Annotated[int, Field(ge=0, strict=True)]  # of the environment that the policy had learned from
    residual: CorrectedManeuver | None = None  # the maneuver that it corrects, if it does
    results: tuple[Result, ...] = ()  # figures of the policy
    jawenv_version: Text  # that wrote it
    config_sha256: Sha256  # of the run's config.yaml, as JSON without spaces and with sorted keys
    weights_sha256: Sha256  # of the file of weights
    licence: Text  # under which the weights are given
    date: date  # when it was written
    commands: tuple[str, ...]  # that made it, from the training on

    @model_validator(mode="after")
    def _layers_fit(self) -> Self:
        ends, layers = (self.observation_size, self.action_size), self.architecture.layers
        if ends != (layers[0], layers[-1]):
            raise ValueError(
                f"architecture.layers run from {layers[0]} to {layers[-1]}, "
                f"allowed: from observation_size {ends[0]} to action_size {ends[1]}"
            )
        return self


SHIPPED = Path(__file__).parent / "shipped"
"""Folder of the policies that come with the project."""


def policy_names() -> tuple[str, ...]:
    """The policies that come with the project, in alphabetical order."""
    return tuple(sorted(path.parent.name for path in SHIPPED.glob(f"*/{CARD}")))


def policy_folder(spec: str | Path) -> Path | None:
    """Folder of the policy that a name, a folder or a card stands for; None if it stands for none.

    A folder with card or weights is a policy's, whole or not.
    """
    if str(spec) in policy_names():
        return SHIPPED / str(spec)
    path = Path(spec)
    if path.name == CARD:
        return path.parent
    return path if (path / CARD).exists() or (path / WEIGHTS).exists() else None


def card_of(spec: str | Path) -> tuple[Path, ModelCard] | None:
    """Folder and card of a policy, or of the run that a checkpoint lies in; None if there is no card.

    Args:
        spec: as of `policy_folder`, or a checkpoint in a run's folder or its ``checkpoints``.
    """
    folder = policy_folder(spec)
    if folder is None and Path(spec).is_file():
        lies_in = Path(spec).resolve().parent
        runs = (lies_in.parent,) if lies_in.name == "checkpoints" else (lies_in,)
        folder = next((run for run in runs if (run / CARD).exists()), None)
    return None if folder is None else (folder, read_card(folder))


def read_card(path: Path) -> ModelCard:
    """Read the card of a policy.

    Args:
        path: its folder, or the card itself.
    """
    file = path if path.name == CARD else path / CARD
    data = read_mapping(file)
    version = data.get("format_version")
    if version != FORMAT_VERSION:
        raise InputError(f"{file}: format_version is {shown(version)}; this jawenv reads {FORMAT_VERSION}")
    return validate(ModelCard, data, str(file))
