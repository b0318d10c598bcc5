"""The models of each algorithm: untrained, as its section of the configuration describes them, and as plain weights."""

from __future__ import annotations

from typing import Any

import numpy as np
import torch
from sb3_contrib import TQC, RecurrentPPO
from stable_baselines3 import PPO, SAC
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.utils import LinearSchedule
from stable_baselines3.common.vec_env.base_vec_env import VecEnv

from jawenv.base.errors import InputError
from jawenv.playing.policies.card import Architecture
from training.run.algorithm_configs import (
    APGConfig,
    LSTMNetworkConfig,
    NetworkConfig,
    PPOConfig,
    SACConfig,
    TQCConfig,
)
from training.run.config import TrainingConfig
from training.run.pathwise import APG

ALGORITHMS: dict[str, type[BaseAlgorithm]] = {
    "ppo": PPO,
    "recurrent_ppo": RecurrentPPO,
    "sac": SAC,
    "tqc": TQC,
    "apg": APG,
}
_BUILT = {"learning_rate", "network"}
ACTIVATIONS = {"tanh": torch.nn.Tanh, "relu": torch.nn.ReLU, "elu": torch.nn.ELU}


def make_model(config: TrainingConfig, worlds: VecEnv) -> BaseAlgorithm:
    """The untrained model that the configuration describes."""
    section = config.section
    specific = _off_policy(section) if isinstance(section, SACConfig) else _on_policy(section)
    algorithm: Any = ALGORITHMS[config.algorithm]
    model: BaseAlgorithm = algorithm(
        "MlpLstmPolicy" if config.algorithm == "recurrent_ppo" else "MlpPolicy",
        worlds,
        learning_rate=LinearSchedule(section.learning_rate.initial, section.learning_rate.final, 1.0),
        stats_window_size=worlds.num_envs,
        device=_device(config.device),
        seed=config.seed,
        **specific,
    )
    _scale_last_layer(model, section.network.initial_action_scale)
    return model


def _on_policy(section: PPOConfig | APGConfig) -> dict[str, Any]:
    """Arguments that PPO, with or without memory, and APG have of their own."""
    return section.model_dump(exclude=_BUILT) | {"policy_kwargs": _network(section.network)}


def _network(network: NetworkConfig) -> dict[str, Any]:
    arguments: dict[str, Any] = {
        "net_arch": {"pi": list(network.policy), "vf": list(network.value)},
        "activation_fn": ACTIVATIONS[network.activation],
        "log_std_init": network.initial_log_std,
    }
    if isinstance(network, LSTMNetworkConfig):
        arguments["lstm_hidden_size"] = network.lstm_units
    return arguments


def _off_policy(sac: SACConfig) -> dict[str, Any]:
    """Arguments that SAC and TQC have of their own."""
    policy: dict[str, Any] = {
        "net_arch": list(sac.network.units),
        "activation_fn": ACTIVATIONS[sac.network.activation],
    }
    of_critics = {"n_critics", "n_quantiles"}
    arguments = sac.model_dump(exclude=_BUILT | of_critics | {"dropped_quantiles"}) | {"train_freq": 1}
    if isinstance(sac, TQCConfig):
        policy |= sac.model_dump(include=of_critics)
        arguments["top_quantiles_to_drop_per_net"] = sac.dropped_quantiles
    return arguments | {"policy_kwargs": policy}


def _scale_last_layer(model: BaseAlgorithm, scale: float) -> None:
    """Make the first actions smaller, so that a residual begins as its maneuver."""
    if scale == 1.0:
        return
    layer: Any = _layers(model)[-1]
    with torch.no_grad():
        layer.weight.mul_(scale)
        layer.bias.zero_()


def _device(name: str) -> torch.device:
    try:
        device = torch.device(name)
        torch.zeros(1, device=device)
    except (RuntimeError, AssertionError, NotImplementedError) as error:
        reason = str(error).splitlines()[0]
        raise InputError(f"device {name!r} cannot be used: {reason}; 'cpu' always can") from error
    return device


def plain_policy(model: BaseAlgorithm, config: TrainingConfig) -> tuple[Architecture, dict[str, np.ndarray]]:
    """The network of a model that leads from an observation to the action without chance, and its weights.

    The weights have the names and shapes of `Architecture.shapes`, in single precision.
    """
    policy: Any = model.policy
    layers = [layer for layer in _layers(model) if isinstance(layer, torch.nn.Linear)]
    tensors = {f"layers.{i}.{name}": getattr(layer, name) for i, layer in enumerate(layers) for name in _PARTS}
    sizes = [layers[0].in_features, *(layer.out_features for layer in layers)]
    lstm = getattr(policy, "lstm_actor", None)
    if lstm is not None:
        sizes[0] = lstm.input_size
        bias = lstm.bias_ih_l0 + lstm.bias_hh_l0
        tensors |= {"lstm.input": lstm.weight_ih_l0, "lstm.hidden": lstm.weight_hh_l0, "lstm.bias": bias}
    architecture = Architecture(
        layers=tuple(sizes),
        activation=config.section.network.activation,
        squash="tanh" if policy.squash_output else "clip",
        lstm_units=None if lstm is None else lstm.hidden_size,
    )
    weights = {name: np.array(values.detach().cpu().numpy(), np.float32, order="C") for name, values in tensors.items()}
    return architecture, weights


_PARTS = ("weight", "bias")


def _layers(model: BaseAlgorithm) -> list[torch.nn.Module]:
    """Layers and activations from observation, or memory, to action."""
    policy: Any = model.policy
    if isinstance(model, SAC | TQC):
        return [*policy.actor.latent_pi, policy.actor.mu]
    return [*policy.mlp_extractor.policy_net, policy.action_net]
