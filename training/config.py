"""Everything that decides a training run, as one validated tree that is read from and written to YAML."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal, Self

import yaml
from pydantic import Field, JsonValue, model_validator

from jawenv.files import InputModel, Number, atomic_write, read_model, validate
from jawenv.seeds import VALIDATION

DEFAULT_CONFIG = Path(__file__).parent / "configs" / "ppo.yaml"

Fraction = Annotated[Number, Field(ge=0.0, le=1.0)]
PositiveInt = Annotated[int, Field(gt=0, strict=True)]
PositiveNumber = Annotated[Number, Field(gt=0.0)]
NotNegative = Annotated[Number, Field(ge=0.0)]


class EnvConfig(InputModel):
    """Which environment is trained on; ``kwargs`` go to `gymnasium.make_vec` as they are."""

    id: str = "jawenv/Jaw-v1"
    kwargs: dict[str, JsonValue] = {}

    @model_validator(mode="after")
    def _not_ours(self) -> Self:
        for key in ("num_envs", "autoreset_mode", "render_mode"):
            if key in self.kwargs:
                raise ValueError(f"{key!r} is set by the training itself and cannot stand here")
        if "model" in self.kwargs:
            raise ValueError("'model' follows from env.id and cannot stand here")
        return self


class LearningRate(InputModel):
    """Adam's step size, falling linearly from ``initial`` to ``final`` over the whole run."""

    initial: PositiveNumber = 3e-4
    final: NotNegative = 0.0


class NetworkConfig(InputModel):
    """Two separate perceptrons: the policy and its value function."""

    policy: tuple[PositiveInt, ...] = (64, 64)
    value: tuple[PositiveInt, ...] = (64, 64)
    activation: Literal["tanh", "relu", "elu"] = "tanh"
    initial_log_std: Number = -0.5


class PPOConfig(InputModel):
    """Proximal policy optimisation (Schulman et al. 2017, arXiv:1707.06347), as in stable-baselines3."""

    n_steps: PositiveInt = 64
    batch_size: Annotated[int, Field(gt=1, strict=True)] = 2048
    n_epochs: PositiveInt = 4
    learning_rate: LearningRate = LearningRate()
    gamma: Fraction = 0.995
    gae_lambda: Fraction = 0.95
    clip_range: PositiveNumber = 0.2
    ent_coef: NotNegative = 0.0
    vf_coef: NotNegative = 0.5
    max_grad_norm: PositiveNumber = 0.5
    target_kl: PositiveNumber | None = None
    network: NetworkConfig = NetworkConfig()


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


class TrainingConfig(InputModel):
    """One training run. The defaults are those of ``configs/ppo.yaml``, which gives the reasons for them."""

    algorithm: Literal["ppo"] = "ppo"
    seed: Annotated[int, Field(ge=0, lt=2**31, strict=True)] = 0
    steps: PositiveInt = 3_000_000
    n_envs: PositiveInt = 128
    device: str = "cpu"
    torch_threads: PositiveInt = 1
    env: EnvConfig = EnvConfig()
    ppo: PPOConfig = PPOConfig()
    evaluation: EvaluationConfig = EvaluationConfig()
    checkpoints: CheckpointConfig = CheckpointConfig()

    @model_validator(mode="after")
    def _whole_batches(self) -> Self:
        rollout = self.n_envs * self.ppo.n_steps
        if rollout % self.ppo.batch_size:
            raise ValueError(
                f"n_envs {self.n_envs} x ppo.n_steps {self.ppo.n_steps} = {rollout} steps per update "
                f"must be a multiple of ppo.batch_size {self.ppo.batch_size}"
            )
        return self

    def changed(self, **values: Any) -> TrainingConfig:
        """The same run with some top-level values replaced; values that are None are left as they are.

        Raises:
            InputError: a value is not allowed.
        """
        given = {key: value for key, value in values.items() if value is not None}
        return validate(TrainingConfig, self.model_dump(mode="json") | given, "command line")

    def in_env(self, env_id: str) -> TrainingConfig:
        """The same run in another environment, with the same arguments."""
        return self.changed(env={"id": env_id, "kwargs": self.env.kwargs})

    def save(self, path: Path) -> None:
        """Write all values, defaults included, as YAML."""
        with atomic_write(path) as unfinished:
            unfinished.write_text(yaml.safe_dump(self.model_dump(mode="json"), sort_keys=False), encoding="utf-8")

    @classmethod
    def load(cls, path: Path) -> TrainingConfig:
        """Read a YAML file; keys it leaves out keep their defaults.

        Raises:
            InputError: no such file, damaged, an unknown key or a value that is not allowed.
        """
        return read_model(path, cls)
