"""Trained stable-baselines3 policies as agents."""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from agents.checkpoints import check_checkpoint, names_policy, policy_of_weights, unpickled_policy
from agents.following import decision_hz
from agents.residual import N_FEATURES, BaseTargets, Residual, ResidualPolicy
from jawenv.controls import Control
from jawenv.errors import InputError
from jawenv.files import read_mapping, validate
from jawenv.playing.agents import BatchAgent, check_size
from jawenv.playing.protocol import Action, Mask, Observation, State

if TYPE_CHECKING:
    from stable_baselines3.common.policies import BasePolicy

MODELS_OF_A_RUN = ("best_model.zip", "final_model.zip")


class TrainedPolicy(BatchAgent):
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

    def _answer(
        self, rows: Observation, state: State, starts: Mask | None, deterministic: bool
    ) -> tuple[Action, State]:
        check_size(rows, self.observation_size, self.path)
        memory = self._state if state is None else state
        action, self._state = self.policy.predict(rows, memory, starts, deterministic)
        return action, self._state


def load_policy(
    path: str | Path, *, observation_size: int | None = None, trust: bool = False
) -> TrainedPolicy | ResidualPolicy:
    """Load a run folder (its best model, else its final one) or a checkpoint file.

    A checkpoint in a run's folder is rebuilt from its weights and the run's config.yaml, and comes with the maneuver
    that it corrects, if it does. One without that file is a pickle that can run code.

    Args:
        path: run folder or .zip.
        observation_size: of the environment it shall play, to be checked.
        trust: whether a checkpoint without a configuration may be unpickled.

    Raises:
        InputError: no such file, not a stable-baselines3 checkpoint, one that needs trust, or a policy for another
            observation or action.
    """
    checkpoint = _checkpoint(Path(path))
    config_file = config_of_run(checkpoint)
    config = {} if config_file is None else read_mapping(config_file)
    if names_policy(config):
        policy = policy_of_weights(checkpoint, config, str(config_file))
    elif trust:
        policy = unpickled_policy(checkpoint)
    else:
        raise InputError(
            f"{checkpoint}: no config.yaml beside it names its algorithm, so it would be unpickled: that can run code; "
            "allowed if you trust its origin: --trust (in Python trust=True)"
        )
    shape = policy.action_space.shape
    if shape != (4,):
        raise InputError(f"{checkpoint}: the policy's actions have shape {shape}, jawenv's environments take (4,)")
    trained = TrainedPolicy(checkpoint, policy, _env_kwargs(config).get("control"))
    base = None if config_file is None else _base_targets(config, config_file)
    agent = trained if base is None else _on_base(trained, base)
    if observation_size is not None and agent.observation_size != observation_size:
        raise InputError(
            f"{checkpoint}: the policy was trained on observations of {agent.observation_size} values, "
            f"the environment gives {observation_size}"
        )
    return agent


def config_of_run(path: Path) -> Path | None:
    """The configuration of a run, given by its folder or a checkpoint in it; None if there is none."""
    if path.is_dir():
        folders = [path]
    elif path.exists():
        folder = path.resolve().parent
        folders = [folder, folder.parent] if folder.name == "checkpoints" else [folder]
    else:
        folders = []
    return next((folder / "config.yaml" for folder in folders if (folder / "config.yaml").exists()), None)


def files_of_run(path: Path) -> tuple[Path, ...]:
    """The files that decide what `load_policy` makes of a path: checkpoint, configuration, and the maneuver corrected.

    Raises:
        InputError: no run or checkpoint, or a damaged configuration.
    """
    checkpoint = _checkpoint(path)
    config_file = config_of_run(checkpoint)
    if config_file is None:
        return (checkpoint,)
    residual = _residual(read_mapping(config_file), config_file)
    maneuver = None if residual is None else residual.maneuver_file(config_file.parent)
    return (checkpoint, config_file, *(() if maneuver is None else (maneuver,)))


def _on_base(trained: TrainedPolicy, base: BaseTargets) -> ResidualPolicy:
    return ResidualPolicy(trained, base, trained.path, trained.observation_size - N_FEATURES)


def _env_kwargs(config: Mapping[str, Any]) -> dict[str, Any]:
    """Arguments of the environment that a run's configuration names."""
    env = config.get("env")
    kwargs = env.get("kwargs") if isinstance(env, dict) else None
    return kwargs if isinstance(kwargs, dict) else {}


def _residual(config: Mapping[str, Any], config_file: Path) -> Residual | None:
    """What the policies of a run correct; None if they correct nothing."""
    if config.get("residual") is None:
        return None
    return validate(Residual, config["residual"], f"{config_file}: residual")


def _base_targets(config: Mapping[str, Any], config_file: Path) -> BaseTargets | None:
    """The maneuver that the policies of a run correct, None if they correct none."""
    residual = _residual(config, config_file)
    if residual is None:
        return None
    hz = decision_hz(_env_kwargs(config))
    return BaseTargets(residual.load_maneuver(config_file.parent), residual.scale, hz)


def _checkpoint(path: Path) -> Path:
    """The checkpoint file that a path stands for, known to be a zip with a checkpoint's entries."""
    if path.is_dir():
        models = [path / name for name in MODELS_OF_A_RUN if (path / name).exists()]
        if not models:
            raise InputError(f"{path}: not a training run, it holds neither {' nor '.join(MODELS_OF_A_RUN)}")
        path = models[0]
    elif not path.exists():
        raise InputError(f"{path}: no such file or folder")
    check_checkpoint(path)
    _refuse_normalised(path)
    return path


def _refuse_normalised(checkpoint: Path) -> None:
    """A policy that was trained behind stable-baselines3's `VecNormalize` would be played on what it has never seen.

    Raises:
        InputError: its statistics lie beside the checkpoint, or in a folder there.
    """
    folder = checkpoint.parent
    statistics = [file for pattern in ("*normalize*.pkl", "*/*normalize*.pkl") for file in folder.glob(pattern)]
    if statistics:
        raise InputError(
            f"{checkpoint}: its observations were normalised (by {statistics[0].relative_to(folder)}), which is not "
            "applied; allowed: a policy without VecNormalize, or an agent of your own that normalises first"
        )
