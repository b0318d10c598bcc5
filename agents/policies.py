"""Policies by their path: a folder of plain weights and a card, or a checkpoint of stable-baselines3.

A checkpoint is a pickle, which can run code: it is read only where the caller trusts it.
"""

from __future__ import annotations

import zipfile
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from agents.without_card import card_in
from jawenv.base.errors import InputError
from jawenv.base.reading import open_file
from jawenv.envs.configuration import Configuration
from jawenv.envs.observation import Parts
from jawenv.ladder import DEFAULT_ENV, model_of_env
from jawenv.playing.agents import Action, Agent, BatchAgent, Mask, Observation, State
from jawenv.playing.policies.card import CARD, ModelCard, card_of, policy_folder
from jawenv.playing.policies.inputs import OwnParts
from jawenv.playing.policies.plain import check_inputs, load_plain, on_maneuver

if TYPE_CHECKING:
    from stable_baselines3.common.policies import BasePolicy

ENTRIES = ("data", "policy.pth")
"""Members of every checkpoint."""


class _TrainedPolicy(BatchAgent):
    """A policy out of a stable-baselines3 checkpoint, whichever of its algorithms trained it.

    Attributes:
        name: the checkpoint and its folder.
        control: control mode of its actions; None where no run's card says it.
        path: the checkpoint.
        policy: stable-baselines3's own.
    """

    is_trained = True

    def __init__(self, path: Path, policy: BasePolicy, card: ModelCard | None, parts: Parts) -> None:
        self.name = f"{path.resolve().parent.name}/{path.stem}"
        self.control = None if card is None else card.environment.control
        self.path = path
        # On a maneuver `ResidualPolicy` picks the parts.
        self._own_parts = OwnParts(parts, path) if card is None or card.residual is None else None
        self.policy = policy
        self._state: State = None

    def take_world(self, world: Configuration) -> None:
        """Get to know the parts of the observations of the worlds that are to be played."""
        if self._own_parts is not None:
            self._own_parts.take(world.parts)

    def reset(self, num_envs: int, seed: int | None = None) -> None:
        """Forget the memory, if the policy is recurrent; seed the draws of a stochastic policy."""
        self._state = None
        if seed is not None:
            from stable_baselines3.common.utils import set_random_seed

            set_random_seed(seed)

    def _answer(
        self, rows: Observation, state: State, starts: Mask | None, deterministic: bool
    ) -> tuple[Action, State]:
        memory = self._state if state is None else state
        seen = rows if self._own_parts is None else self._own_parts(rows)
        action, self._state = self.policy.predict(seen, memory, starts, deterministic)
        return action, self._state


def load_policy(path: str | Path, *, env_id: str | None = None, trust: bool = False) -> Agent:
    """Load a policy by its folder (a run's, or an exported policy's), its card, or a checkpoint (.zip).

    A checkpoint in a run's folder comes with the maneuver that the run corrects.

    Args:
        path: folder, card or checkpoint.
        env_id: of the environment that it shall play, as `jawenv.ladder.model_of_env` takes it, to be checked.
        trust: whether a stable-baselines3 checkpoint may be unpickled.
    """
    folder = policy_folder(path)
    return _of_checkpoint(Path(path), env_id or DEFAULT_ENV, trust) if folder is None else load_plain(folder, env_id)


def _of_checkpoint(path: Path, env_id: str, trust: bool) -> Agent:
    _check_checkpoint(path)
    if not trust:
        raise InputError(
            f"{path}: a checkpoint is unpickled, which can run code; allowed if you trust its origin: --trust (in "
            "Python trust=True)"
        )
    policy, plays = _unpickled(path)
    shape = policy.action_space.shape
    if shape != (4,):
        raise InputError(f"{path}: the policy's actions have shape {shape}, jawenv's environments take (4,)")
    run = card_of(path)
    card = card_in(path, policy.observation_space.shape, plays) if run is None else run[1]
    number = len(model_of_env(env_id).muscles.parameter_names)
    parts = (Parts() if card is None else card.environment.world().parts)._replace(n_parameters=number)
    check_inputs(path, int(np.prod(policy.observation_space.shape or (0,))), card, parts, env_id)
    trained = _TrainedPolicy(path, policy, card, parts)
    return trained if card is None else on_maneuver(trained, path, card)


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


def _unpickled(path: Path) -> tuple[BasePolicy, Any]:
    """Rebuild a policy from the pickles of a checkpoint, with what it says of where it plays: this can run code."""
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
    except InputError:
        raise
    except Exception as error:  # a damaged pickle or state can raise anything
        reason = " ".join(str(error).split())[:120] or type(error).__name__
        raise InputError(f"{path}: damaged stable-baselines3 checkpoint: {reason}") from error
    assert isinstance(policy, BasePolicy)
    policy.set_training_mode(False)
    return policy, data.get("plays")
