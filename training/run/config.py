"""Everything that decides a training run, as one validated tree that is read from and written to YAML."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal, Self

import yaml
from pydantic import Field, JsonValue, model_validator

from jawenv.base.errors import InputError, meant, shown
from jawenv.base.files import InputModel, Number, read_mapping, read_model, validate, write_text
from jawenv.base.seeds import VALIDATION
from jawenv.ladder import DEFAULT_ENV, env_id_of, title_of_env
from jawenv.playing.maneuvers import Maneuver

CONFIGS = Path(__file__).parents[1] / "configs"
DEFAULT_CONFIG = CONFIGS / "plain_ppo.yaml"
SUFFIXES = (".yaml", ".yml", ".json", ".toml")
BASE_FILE = "base_maneuver.json"
"""Copy of the maneuver in a run's folder, as the policy was trained on it."""

PositiveInt = Annotated[int, Field(gt=0, strict=True)]
PositiveNumber = Annotated[Number, Field(gt=0.0)]
Activation = Literal["tanh", "relu", "elu"]


class EnvConfig(InputModel):
    """Environment that is trained on; ``kwargs`` go to `gymnasium.make_vec` as they are."""

    id: str = DEFAULT_ENV
    kwargs: dict[str, JsonValue] = {}

    @model_validator(mode="after")
    def _not_ours(self) -> Self:
        for key in ("num_envs", "autoreset_mode", "render_mode"):
            if key in self.kwargs:
                raise ValueError(f"{key!r} is set by the training itself and cannot stand here")
        if "model" in self.kwargs:
            raise ValueError("'model' follows from env.id and cannot stand here")
        return self


class Residual(InputModel):
    """The maneuver that a policy corrects, and how far."""

    maneuver: Annotated[str, Field(min_length=1)]  # name of one that comes with jawenv, or a maneuver file
    scale: Annotated[Number, Field(gt=0.0, le=2.0)] = 0.5
    """Size of an action of 1 beside the maneuver's target, as a fraction of the patient's comfort."""

    def load_maneuver(self, folder: Path | None = None) -> Maneuver:
        """The maneuver; where a run's folder holds a copy of it, that one."""
        if folder is not None and (folder / BASE_FILE).exists():
            return Maneuver.load(folder / BASE_FILE)
        return Maneuver.of(self.maneuver)


class Schedule(InputModel):
    """An argument that falls linearly over the whole run, as the step size of Adam."""

    initial: PositiveNumber
    final: Annotated[Number, Field(ge=0.0)] = 0.0


class NetworkConfig(InputModel):
    """Separate perceptrons: the policy, and its value function or critics."""

    policy: tuple[PositiveInt, ...] = (64, 64)  # units of each hidden layer
    value: tuple[PositiveInt, ...] = (64, 64)  # units of each hidden layer
    activation: Activation = "tanh"  # between layers
    features: str | None = None  # my_module:function of rows (N, size), which the networks see in their place
    initial_log_std: Number = -0.5  # natural log of the sd of the actions at the start, on-policy
    final_log_std: Number | None = None  # where it falls to, linearly over the run; null leaves it to the learning
    initial_action_scale: PositiveNumber = 1.0
    """Factor of the last layer's initial weights; below 1 the first actions are near to 0."""


class ComfortConfig(InputModel):
    """A limit on discomfort in place of its price: the price (Lagrange's multiplier) is learned.

    After every so many episodes its logarithm grows by ``rate`` x (discomfort / target - 1).
    """

    target_discomfort_s: PositiveNumber = 0.05  # integral of ``info["cost"]`` over 30 s that is allowed on average, s
    initial_multiplier: PositiveNumber = 10.0  # nats per s of cost 1, as ``comfort_weight``
    largest_multiplier: PositiveNumber = 1e4  # where the growth ends
    rate: PositiveNumber = 0.1  # step of the logarithm
    episodes: PositiveInt = 64  # finished between two updates


class EvaluationConfig(InputModel):
    """The deterministic policy is tried on one fixed cohort: the patients of seed, seed + 1, ...

    All of them lie in `jawenv.base.seeds.VALIDATION`, as the best policy is chosen on them.
    """

    every_steps: PositiveInt = 100_000
    patients: PositiveInt = 64
    seed: Annotated[int, Field(ge=VALIDATION.start, lt=VALIDATION.stop, strict=True)] = VALIDATION.start

    @model_validator(mode="after")
    def _validation_alone(self) -> Self:
        last = self.seed + self.patients - 1
        if last not in VALIDATION:
            raise ValueError(
                f"seed is {self.seed} for {self.patients} patients; allowed: up to {VALIDATION[-1]}, not {last}"
            )
        return self


class _CheckpointConfig(InputModel):
    """Saving of the model: how often, and how many of the latest checkpoints are kept."""

    every_steps: PositiveInt = 200_000
    keep: PositiveInt = 5


class TrainingConfig(InputModel):
    """One training run. Its defaults equal ``configs/plain_ppo.yaml``, which gives the reasons for them."""

    algorithm: str = "PPO"  # class of stable-baselines3 or sb3-contrib, APG, or my_module:Name
    seed: Annotated[int, Field(ge=0, lt=2**31, strict=True)] = 0
    steps: PositiveInt = 3_000_000
    n_envs: PositiveInt = 128
    device: str = "cpu"
    torch_threads: PositiveInt = 1
    env: EnvConfig = EnvConfig()
    residual: Residual | None = None
    comfort: ComfortConfig | None = None
    arguments: dict[str, JsonValue] = {}  # of that class; those left out are as the class has them
    network: NetworkConfig = NetworkConfig()
    evaluation: EvaluationConfig = EvaluationConfig()
    checkpoints: _CheckpointConfig = _CheckpointConfig()

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        weight = self.env.kwargs.get("comfort_weight", 0.0)
        if self.comfort is not None and weight != 0.0:
            raise ValueError(f"env.kwargs.comfort_weight is {shown(weight)}; allowed: 0 where comfort learns its price")
        return self

    def as_mapping(self) -> dict[str, Any]:
        """All values, defaults included, as plain types."""
        return self.model_dump(mode="json")

    def changed(self, **values: Any) -> TrainingConfig:
        """The same run with some values replaced, in mappings the named ones; None leaves a value as it is."""
        return validate(TrainingConfig, _replaced(self.as_mapping(), values), "changed configuration")

    def save(self, path: Path) -> None:
        """Write all values, defaults included, as YAML."""
        write_text(path, yaml.safe_dump(self.as_mapping(), sort_keys=False))

    @classmethod
    def load(cls, path: Path) -> TrainingConfig:
        """Read a YAML file; keys it leaves out keep their defaults."""
        return read_model(path, cls)


def asked_for(
    name: str | None,
    world: Mapping[str, Any],
    *,
    residual_on: str | None = None,
    target_discomfort: float | None = None,
    **values: Any,
) -> tuple[TrainingConfig, str]:
    """The configuration that a command line asks for, and the stem of its runs' names.

    Args:
        name: of a shipped configuration or a file, with the values of all settings not named here.
        world: ``env`` and arguments of the environment.
        residual_on: maneuver to be corrected.
        target_discomfort: s in 30 s that are allowed; its price is then learned.
        **values: other values of the configuration. What is None is not asked for.
    """
    if name is None:
        raise InputError("CONFIG is missing: name a shipped configuration such as apg or ppo, or a YAML file")
    source = config_file(name)
    env = world.get("env")
    env_id = None if env is None else env_id_of(env)
    arguments = {name: value for name, value in world.items() if name != "env" and value is not None}
    if target_discomfort is not None:
        arguments["comfort_weight"] = 0.0
    values |= {
        "env": {"id": env_id, "kwargs": arguments},
        "residual": {"maneuver": residual_on},
        "comfort": {"target_discomfort_s": target_discomfort},
    }
    config = validate(TrainingConfig, _replaced(read_mapping(source), values), f"{source} and command line")
    return config, source.stem if env_id is None else f"{source.stem}-{title_of_env(env_id)}"


def config_file(name: str) -> Path:
    """The file of a configuration that comes with the project, or the file that a path names."""
    if Path(name).suffix in SUFFIXES:
        return Path(name)
    names = sorted(path.stem for path in CONFIGS.glob("*.yaml"))
    if name not in names:
        raise InputError(
            f"configuration {name!r}: unknown; {meant(name, names)}allowed: {', '.join(names)}, a file "
            f"({', '.join(SUFFIXES)})"
        )
    return CONFIGS / f"{name}.yaml"


def _replaced(data: Mapping[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    """A mapping with other values: mappings in it are changed within, arguments of the environment as a whole each."""
    replaced = dict(data)
    for key, value in changes.items():
        inner = data.get(key)
        if isinstance(value, Mapping):
            value = {name: held for name, held in value.items() if held is not None}
            if isinstance(inner, Mapping):
                value = {**inner, **value} if key == "kwargs" else _replaced(inner, value)
        if value not in (None, {}):
            replaced[key] = value
    return replaced
