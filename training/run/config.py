"""Everything that decides a training run, as one validated tree that is read from and written to YAML."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal, Self, get_args

import yaml
from pydantic import Field, JsonValue, model_validator

from agents.residual import Residual
from jawenv.errors import InputError, meant
from jawenv.files import InputModel, read_model, validate, write_text
from jawenv.seeds import VALIDATION
from training.run.algorithm_configs import (
    PositiveInt,
    PositiveNumber,
    PPOConfig,
    RecurrentPPOConfig,
    SACConfig,
    TQCConfig,
)

CONFIGS = Path(__file__).parents[1] / "configs"
DEFAULT_CONFIG = CONFIGS / "plain_ppo.yaml"
SUFFIXES = (".yaml", ".yml", ".json", ".toml")

Algorithm = Literal["ppo", "recurrent_ppo", "sac", "tqc"]


def config_file(name: str) -> Path:
    """The file of a configuration that comes with the project, or the file that a path names.

    Raises:
        InputError: neither.
    """
    if Path(name).suffix in SUFFIXES:
        return Path(name)
    names = sorted(path.stem for path in CONFIGS.glob("*.yaml"))
    if name not in names:
        raise InputError(
            f"configuration {name!r}: unknown; {meant(name, names)}allowed: {', '.join(names)}, a file "
            f"({', '.join(SUFFIXES)})"
        )
    return CONFIGS / f"{name}.yaml"


class EnvConfig(InputModel):
    """Which environment is trained on; ``kwargs`` go to `gymnasium.make_vec` as they are."""

    id: str = "jawenv/Jaw-v2"
    kwargs: dict[str, JsonValue] = {}

    @model_validator(mode="after")
    def _not_ours(self) -> Self:
        for key in ("num_envs", "autoreset_mode", "render_mode"):
            if key in self.kwargs:
                raise ValueError(f"{key!r} is set by the training itself and cannot stand here")
        if "model" in self.kwargs:
            raise ValueError("'model' follows from env.id and cannot stand here")
        return self


class EvaluationConfig(InputModel):
    """The deterministic policy is tried on one fixed cohort: the patients of seed, seed + 1, ...

    All of them lie in `jawenv.seeds.VALIDATION`, as the best policy is chosen on them.
    """

    every_steps: PositiveInt = 100_000
    patients: PositiveInt = 64
    seed: Annotated[int, Field(ge=VALIDATION.start, lt=VALIDATION.stop, strict=True)] = VALIDATION.start

    @model_validator(mode="after")
    def _validation_alone(self) -> Self:
        last = self.seed + self.patients - 1
        if last not in VALIDATION:
            raise ValueError(f"seed {self.seed} and {self.patients} patients end at {last}, allowed: {VALIDATION[-1]}")
        return self


class CheckpointConfig(InputModel):
    """How often the model is saved, and how many of the latest checkpoints are kept."""

    every_steps: PositiveInt = 200_000
    keep: PositiveInt = 5


class ComfortConfig(InputModel):
    """A limit on discomfort in place of its price: the price (Lagrange's multiplier) is learned.

    After every so many episodes its logarithm grows by ``rate`` x (discomfort / target - 1).

    Attributes:
        target_discomfort_s: integral of ``info["cost"]`` over 30 s that is allowed on average, s.
        initial_multiplier: nats per s of cost 1, as ``comfort_weight``.
        largest_multiplier: where the growth ends.
        rate: step of the logarithm.
        episodes: finished between two updates.
    """

    target_discomfort_s: PositiveNumber = 0.05
    initial_multiplier: PositiveNumber = 10.0
    largest_multiplier: PositiveNumber = 1e4
    rate: PositiveNumber = 0.1
    episodes: PositiveInt = 64


class TrainingConfig(InputModel):
    """One training run. The defaults are those of ``configs/plain_ppo.yaml``, which gives the reasons for them.

    Only the section of the algorithm that is chosen counts, and only that one may be given.
    """

    algorithm: Algorithm = "ppo"
    seed: Annotated[int, Field(ge=0, lt=2**31, strict=True)] = 0
    steps: PositiveInt = 3_000_000
    n_envs: PositiveInt = 128
    device: str = "cpu"
    torch_threads: PositiveInt = 1
    env: EnvConfig = EnvConfig()
    residual: Residual | None = None
    comfort: ComfortConfig | None = None
    ppo: PPOConfig = PPOConfig()
    recurrent_ppo: RecurrentPPOConfig = RecurrentPPOConfig()
    sac: SACConfig = SACConfig()
    tqc: TQCConfig = TQCConfig()
    evaluation: EvaluationConfig = EvaluationConfig()
    checkpoints: CheckpointConfig = CheckpointConfig()

    @model_validator(mode="after")
    def _one_section(self) -> Self:
        for name in get_args(Algorithm):
            if name != self.algorithm and name in self.model_fields_set:
                raise ValueError(f"section {name!r} does not belong to algorithm {self.algorithm!r}")
        return self

    @model_validator(mode="after")
    def _whole_batches(self) -> Self:
        section = self.section
        if isinstance(section, PPOConfig) and self.n_envs * section.n_steps % section.batch_size:
            name = self.algorithm
            raise ValueError(
                f"n_envs {self.n_envs} x {name}.n_steps {section.n_steps} = {self.n_envs * section.n_steps} steps "
                f"per update must be a multiple of {name}.batch_size {section.batch_size}"
            )
        return self

    @model_validator(mode="after")
    def _one_price(self) -> Self:
        if self.comfort is not None and self.env.kwargs.get("comfort_weight", 0.0) != 0.0:
            raise ValueError("comfort learns the price of discomfort: env.kwargs.comfort_weight must be 0 or left out")
        return self

    @property
    def section(self) -> PPOConfig | SACConfig:
        """The settings of the algorithm."""
        section: PPOConfig | SACConfig = getattr(self, self.algorithm)
        return section

    def as_mapping(self) -> dict[str, Any]:
        """All values, defaults included, as plain types; without the sections of other algorithms."""
        return self.model_dump(mode="json", exclude=set(get_args(Algorithm)) - {self.algorithm})

    def changed(self, **values: Any) -> TrainingConfig:
        """The same run with some top-level values replaced; values that are None are left as they are.

        Raises:
            InputError: a value is not allowed.
        """
        given = {key: value for key, value in values.items() if value is not None}
        return validate(TrainingConfig, self.as_mapping() | given, "command line")

    def on_maneuver(self, maneuver: str) -> TrainingConfig:
        """The same run as a residual on a maneuver.

        Raises:
            InputError: no such maneuver.
        """
        scale = {} if self.residual is None else {"scale": self.residual.scale}
        return self.changed(residual={"maneuver": maneuver, **scale})

    def within_discomfort(self, target_discomfort_s: float) -> TrainingConfig:
        """The same run with a limit on discomfort, s per 30 s, in place of a price.

        Raises:
            InputError: a limit that is not a positive number.
        """
        comfort = {} if self.comfort is None else self.comfort.model_dump()
        kwargs = {name: value for name, value in self.env.kwargs.items() if name != "comfort_weight"}
        changed = {"comfort": {**comfort, "target_discomfort_s": target_discomfort_s}}
        return self.changed(**changed, env={"id": self.env.id, "kwargs": {**kwargs, "comfort_weight": 0.0}})

    def in_env(self, env_id: str) -> TrainingConfig:
        """The same run in another environment, with the same arguments."""
        return self.changed(env={"id": env_id, "kwargs": self.env.kwargs})

    def with_env_kwargs(self, **kwargs: object) -> TrainingConfig:
        """The same run with other arguments of the environment; those that are None stay as they are."""
        changed = {name: value for name, value in kwargs.items() if value is not None}
        return self.changed(env={"id": self.env.id, "kwargs": {**self.env.kwargs, **changed}})

    def save(self, path: Path) -> None:
        """Write all values, defaults included, as YAML."""
        write_text(path, yaml.safe_dump(self.as_mapping(), sort_keys=False))

    @classmethod
    def load(cls, path: Path) -> TrainingConfig:
        """Read a YAML file; keys it leaves out keep their defaults.

        Raises:
            InputError: no such file, damaged, an unknown key or a value that is not allowed.
        """
        return read_model(path, cls)
