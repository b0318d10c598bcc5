"""The layers of a stable-baselines3 policy that lead from an observation to the action without chance."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from stable_baselines3.common.policies import BasePolicy
from stable_baselines3.common.torch_layers import FlattenExtractor
from torch import nn

from jawenv.errors import InputError

Activation = Literal["tanh", "relu", "elu"]
ACTIVATIONS: dict[type[nn.Module], Activation] = {nn.Tanh: "tanh", nn.ReLU: "relu", nn.ELU: "elu"}


@dataclass(frozen=True)
class Network:
    """A multilayer perceptron.

    Attributes:
        layers: sizes from the observation to the action.
        activation: after every layer but the last.
        squash: how the last layer's output gets into [-1, 1].
        weights: ``layers.i.weight`` (outputs, inputs) and ``layers.i.bias`` (outputs), float32.
    """

    layers: tuple[int, ...]
    activation: Activation
    squash: Literal["tanh", "clip"]
    weights: dict[str, np.ndarray]


def network_of(policy: BasePolicy, source: str) -> Network:
    """The network of PPO's, SAC's and TQC's policies on flat observations.

    Args:
        policy: on actions in [-1, 1].
        source: what the message begins with.

    Raises:
        InputError: a recurrent policy, or one that is more than a multilayer perceptron.
    """
    modules = _modules(policy, source)
    linear = [module for module in modules[::2] if isinstance(module, nn.Linear) and module.bias is not None]
    kinds = {type(module) for module in modules[1::2]} or {_activation_of(policy)}
    if len(linear) != len(modules[::2]) or len(kinds) != 1 or not kinds <= set(ACTIVATIONS):
        names = ", ".join(type(module).__name__ for module in modules)
        allowed = ", ".join(kind.__name__ for kind in ACTIVATIONS)
        raise InputError(f"{source}: its layers are {names}; allowed: Linear, and between them one kind of {allowed}")
    weights = {}
    for i, layer in enumerate(linear):
        for name, values in (("weight", layer.weight), ("bias", layer.bias)):
            weights[f"layers.{i}.{name}"] = np.array(values.detach().cpu().numpy(), np.float32, order="C")
    return Network(
        layers=(linear[0].in_features, *(layer.out_features for layer in linear)),
        activation=ACTIVATIONS[kinds.pop()],
        squash="tanh" if policy.squash_output else "clip",
        weights=weights,
    )


def _activation_of(policy: BasePolicy) -> type[nn.Module]:
    """What a policy would put between its layers."""
    kind: type[nn.Module] = getattr(policy, "activation_fn", nn.Tanh)
    return kind


def _modules(policy: BasePolicy, source: str) -> list[nn.Module]:
    """The modules in the order in which an observation passes them."""
    if hasattr(policy, "lstm_actor"):
        raise InputError(f"{source}: a recurrent policy cannot be exported; allowed: those of PPO, SAC and TQC")
    actor: Any = getattr(policy, "actor", None)
    both: Any = policy
    if hasattr(actor, "latent_pi"):  # SAC and those that derive from it
        first, hidden, last = actor.features_extractor, actor.latent_pi, actor.mu
    elif hasattr(policy, "mlp_extractor"):  # PPO, A2C
        first, hidden, last = both.pi_features_extractor, both.mlp_extractor.policy_net, both.action_net
    else:
        raise InputError(f"{source}: a {type(policy).__name__} cannot be exported; allowed: those of PPO, SAC and TQC")
    if not isinstance(first, FlattenExtractor):
        raise InputError(f"{source}: its observation passes a {type(first).__name__} first; allowed: none")
    return [*hidden, last]
