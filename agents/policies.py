"""Trained stable-baselines3 policies as agents."""

import zipfile
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from agents.following import decision_hz
from agents.residual import N_FEATURES, BaseTargets, Residual, ResidualPolicy
from jawenv.controls import Control
from jawenv.errors import InputError
from jawenv.files import read_mapping, validate
from jawenv.playing.protocol import Action, Mask, Observation, State

if TYPE_CHECKING:
    from stable_baselines3.common.policies import BasePolicy

CONFIG = "config.yaml"
MODELS_OF_A_RUN = ("best_model.zip", "final_model.zip")
_ENTRIES = {"data", "policy.pth"}


class TrainedPolicy:
    """A policy out of a stable-baselines3 checkpoint, whichever of its algorithms trained it.

    Attributes:
        name: the run's folder, and the checkpoint within it unless it is the best or final model.
        control: control mode of its actions; None where no run's configuration says it.
        path: the checkpoint.
        observation_size: how many values the policy wants to see.
        policy: stable-baselines3's own.
    """

    def __init__(self, path: Path, policy: "BasePolicy", control: Control | None = None) -> None:
        whole_run = path.name in MODELS_OF_A_RUN
        folder = path.resolve().parent.name
        self.name = folder if whole_run else f"{folder}/{path.stem}"
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

    def predict(
        self,
        observation: Observation,
        state: State = None,
        episode_start: Mask | None = None,
        deterministic: bool = True,
    ) -> tuple[Action, State]:
        """See `jawenv.playing.protocol.Agent.predict`.

        Raises:
            InputError: the observation has not the size that the policy was trained on.
        """
        size = np.shape(observation)[-1]
        if size != self.observation_size:
            raise InputError(
                f"{self.path}: the policy was trained on observations of {self.observation_size} values, got {size}"
            )
        memory = self._state if state is None else state
        action, self._state = self.policy.predict(observation, memory, episode_start, deterministic)
        return action, self._state


def load_policy(path: str | Path, *, observation_size: int | None = None) -> TrainedPolicy | ResidualPolicy:
    """Load a run folder (its best model, else its final one) or a checkpoint file.

    A policy of a run that was trained as a residual comes with its maneuver, by the run's config.yaml.
    A checkpoint holds pickled Python objects: load only files whose origin you trust.

    Args:
        path: run folder or .zip.
        observation_size: of the environment it shall play, to be checked.

    Raises:
        InputError: no such file, not a stable-baselines3 checkpoint, or a policy for another observation or action.
    """
    checkpoint = _checkpoint(Path(path))
    policy = _policy(checkpoint)
    shape = policy.action_space.shape
    if shape != (4,):
        raise InputError(f"{checkpoint}: the policy's actions have shape {shape}, jawenv's environments take (4,)")
    config = _run_config(checkpoint)
    trained = TrainedPolicy(checkpoint, policy, _env_kwargs(config).get("control"))
    base = _base_targets(checkpoint, config)
    agent = trained if base is None else _on_base(trained, base)
    if observation_size is not None and agent.observation_size != observation_size:
        raise InputError(
            f"{checkpoint}: the policy was trained on observations of {agent.observation_size} values, "
            f"the environment gives {observation_size}"
        )
    return agent


def _on_base(trained: TrainedPolicy, base: BaseTargets) -> ResidualPolicy:
    return ResidualPolicy(trained, base, trained.path, trained.observation_size - N_FEATURES)


def _run_folder(checkpoint: Path) -> Path | None:
    """The folder of the run that a checkpoint belongs to; None if it belongs to none."""
    folders = checkpoint.resolve().parents[:2]
    return next((folder for folder in folders if (folder / CONFIG).is_file()), None)


def _run_config(checkpoint: Path) -> dict[str, Any]:
    """The configuration of the run that a checkpoint belongs to; empty if it belongs to none."""
    folder = _run_folder(checkpoint)
    return {} if folder is None else read_mapping(folder / CONFIG)


def _env_kwargs(config: dict[str, Any]) -> dict[str, Any]:
    """Arguments of the environment that a run's configuration names."""
    env = config.get("env")
    kwargs = env.get("kwargs") if isinstance(env, dict) else None
    return kwargs if isinstance(kwargs, dict) else {}


def _base_targets(checkpoint: Path, config: dict[str, Any]) -> BaseTargets | None:
    """The maneuver that the run of a checkpoint corrects, None if it corrects none."""
    folder = _run_folder(checkpoint)
    if folder is None or config.get("residual") is None:
        return None
    residual = validate(Residual, config["residual"], f"{folder / CONFIG}: residual")
    return BaseTargets(residual.load_maneuver(folder), residual.scale, decision_hz(_env_kwargs(config)))


def _checkpoint(path: Path) -> Path:
    """The checkpoint file that a path stands for, known to be a zip with a checkpoint's entries."""
    if path.is_dir():
        models = [path / name for name in MODELS_OF_A_RUN if (path / name).is_file()]
        if not models:
            raise InputError(f"{path}: not a training run, it holds neither {' nor '.join(MODELS_OF_A_RUN)}")
        path = models[0]
    elif not path.exists():
        raise InputError(f"{path}: no such file or folder")
    try:
        with zipfile.ZipFile(path) as archive:
            missing = _ENTRIES - set(archive.namelist())
    except (OSError, zipfile.BadZipFile):
        missing = _ENTRIES
    if missing:
        raise InputError(
            f"{path}: not a stable-baselines3 checkpoint (a .zip that holds {', '.join(sorted(_ENTRIES))})"
        )
    return path


def _policy(path: Path) -> "BasePolicy":
    """Rebuild the policy network from what the checkpoint stores about it."""
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
