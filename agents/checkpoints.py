"""The policy in a checkpoint of stable-baselines3, rebuilt from its weights and its run's configuration.

::

    CHECKPOINT.zip/policy.pth   the weights, read as tensors alone
                   data         settings in JSON; some of them are pickled objects, which can run code

The configuration says which algorithm trained the policy and what lies between its layers; the weights say how large
each layer is. The pickled objects are read only where the caller trusts the file.
"""

from __future__ import annotations

import io
import json
import zipfile
from collections.abc import Mapping
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from jawenv.errors import InputError, shown
from jawenv.reading import LARGEST_TEXT, open_file, read_member

if TYPE_CHECKING:
    from stable_baselines3.common.policies import BasePolicy
    from torch import Tensor, nn

    Weights = Mapping[str, Tensor]

ALGORITHMS = ("ppo", "recurrent_ppo", "sac", "tqc")
LARGEST_WEIGHTS = 256 * 2**20
"""Bytes."""
ENTRIES = ("data", "policy.pth")
"""What a checkpoint holds at least."""


def check_checkpoint(path: Path) -> None:
    """Make sure that a file is a checkpoint.

    Raises:
        InputError: no such file, or no zip file with a checkpoint's entries.
    """
    with open_file(path) as file:
        try:
            with zipfile.ZipFile(file) as archive:
                whole = set(ENTRIES) <= set(archive.namelist())
        except (OSError, ValueError, NotImplementedError, zipfile.BadZipFile):
            whole = False
    if not whole:
        raise InputError(f"{path}: not a stable-baselines3 checkpoint (a .zip that holds {', '.join(ENTRIES)})")


def read_data(path: Path) -> dict[str, Any]:
    """What a checkpoint says in plain text, such as its steps; what is pickled there stays text.

    Raises:
        InputError: no such file, or a damaged one.
    """
    with open_file(path) as file:
        try:
            with zipfile.ZipFile(file) as archive:
                data = json.loads(read_member(archive, "data", LARGEST_TEXT))
            if not isinstance(data, dict):
                raise ValueError(f"its data is {shown(data)}; allowed: a mapping")
        except Exception as error:  # a damaged archive or text can raise anything
            raise _damaged(path, _reason(error)) from None
    return data


def names_policy(config: Mapping[str, Any]) -> bool:
    """Whether a run's configuration says of which algorithm the policy is."""
    return config.get("algorithm") in ALGORITHMS


def policy_of_weights(path: Path, config: Mapping[str, Any], source: str) -> BasePolicy:
    """Rebuild a policy; nothing is unpickled.

    Args:
        path: of the checkpoint.
        config: of the run, which `names_policy`.
        source: what messages about the configuration begin with.

    Raises:
        InputError: the configuration does not say what lies between the layers, or weights that are damaged or not
            those of its algorithm.
    """
    algorithm = config["algorithm"]
    activation = _activation(config, source)
    try:
        weights = _read_weights(path)
        policy = _untrained(algorithm, activation, weights)
        policy.load_state_dict(weights)
    except InputError:
        raise
    except Exception as error:  # damaged weights, or those of another policy, can raise anything
        raise _damaged(path, f"no weights of {algorithm}: {_reason(error)}") from error
    policy.set_training_mode(False)
    return policy


def unpickled_policy(path: Path) -> BasePolicy:
    """Rebuild a policy from what the checkpoint pickles about it: this can run code.

    Raises:
        InputError: it is damaged.
    """
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
        raise _damaged(path, _reason(error)) from error
    assert isinstance(policy, BasePolicy)
    policy.set_training_mode(False)
    return policy


def _activation(config: Mapping[str, Any], source: str) -> type[nn.Module]:
    """What the configuration puts between the layers."""
    from torch import nn

    value: Any = config
    for key in (config["algorithm"], "network", "activation"):
        value = value.get(key) if isinstance(value, Mapping) else None
    kinds: dict[str, type[nn.Module]] = {"tanh": nn.Tanh, "relu": nn.ReLU, "elu": nn.ELU}
    if not isinstance(value, str) or value not in kinds:
        place = f"{config['algorithm']}.network.activation"
        raise InputError(f"{source}: {place} is {shown(value)}; allowed: {', '.join(kinds)}")
    return kinds[value]


def _read_weights(path: Path) -> Weights:
    """The tensors of a checkpoint.

    Raises:
        ValueError: it holds something else, or tensors that are larger than their file.
    """
    import torch

    with open_file(path) as file, zipfile.ZipFile(file) as archive:
        content = read_member(archive, "policy.pth", LARGEST_WEIGHTS)
    with zipfile.ZipFile(io.BytesIO(content)) as stored:
        unpacked = sum(member.file_size for member in stored.infolist())
    if unpacked > LARGEST_WEIGHTS:
        raise ValueError(f"policy.pth has {unpacked:,} bytes; allowed: {LARGEST_WEIGHTS:,} at most")
    weights = torch.load(io.BytesIO(content), map_location="cpu", weights_only=True)
    if not isinstance(weights, dict) or not all(isinstance(value, torch.Tensor) for value in weights.values()):
        raise ValueError("policy.pth holds something other than tensors")
    # A tensor can repeat what is stored; layers of its shape would not.
    if sum(value.numel() * value.element_size() for value in weights.values()) > unpacked:
        raise ValueError("policy.pth states more numbers than it holds")
    return weights


def _untrained(algorithm: str, activation: type[nn.Module], weights: Weights) -> BasePolicy:
    """A policy of the size of the weights."""
    from gymnasium import spaces

    first, last, kwargs = _sizes(algorithm, weights)
    seen = spaces.Box(-np.inf, np.inf, (first,), np.float32)
    acts = spaces.Box(-1.0, 1.0, (last,), np.float32)
    # A learning rate is asked for by every policy's constructor; a policy that only acts never uses it.
    policy: BasePolicy = _class_of(algorithm)(seen, acts, lambda _: 0.0, activation_fn=activation, **kwargs)
    return policy


def _class_of(algorithm: str) -> Any:
    """The class of an algorithm's policies."""
    if algorithm in ("ppo", "sac"):
        from stable_baselines3 import PPO, SAC

        return (PPO if algorithm == "ppo" else SAC).policy_aliases["MlpPolicy"]
    from sb3_contrib import TQC, RecurrentPPO

    if algorithm == "recurrent_ppo":
        return RecurrentPPO.policy_aliases["MlpLstmPolicy"]
    return TQC.policy_aliases["MlpPolicy"]


def _sizes(algorithm: str, weights: Weights) -> tuple[int, int, dict[str, Any]]:
    """Sizes of observation and action, and what the policy's constructor takes."""
    if algorithm in ("ppo", "recurrent_ppo"):
        policy, value = (_units(weights, f"mlp_extractor.{part}_net") for part in ("policy", "value"))
        kwargs: dict[str, Any] = {"net_arch": {"pi": policy, "vf": value}, "use_sde": weights["log_std"].ndim == 2}
        last = weights["action_net.weight"]
        first = weights.get("mlp_extractor.policy_net.0.weight", last)
        if algorithm == "recurrent_ppo":
            kwargs["lstm_hidden_size"] = weights["lstm_actor.weight_hh_l0"].shape[1]
            first = weights["lstm_actor.weight_ih_l0"]
        return first.shape[1], last.shape[0], kwargs
    critics = next(i for i in count() if f"critic.qf{i}.0.weight" not in weights)
    *units, outputs = _units(weights, "critic.qf0")
    kwargs = {"net_arch": {"pi": _units(weights, "actor.latent_pi"), "qf": units}, "n_critics": critics}
    if algorithm == "tqc":
        kwargs["n_quantiles"] = outputs
    last = weights["actor.mu.weight"]
    return weights.get("actor.latent_pi.0.weight", last).shape[1], last.shape[0], kwargs


def _units(weights: Weights, prefix: str) -> list[int]:
    """Outputs of each linear layer of a sequence of layers and activations."""
    units: list[int] = []
    while (layer := weights.get(f"{prefix}.{2 * len(units)}.weight")) is not None:
        units.append(layer.shape[0])
    return units


def _damaged(path: Path, reason: str) -> InputError:
    return InputError(f"{path}: damaged stable-baselines3 checkpoint: {reason}")


def _reason(error: Exception) -> str:
    return " ".join(str(error).split())[:120] or type(error).__name__
