"""The models of each algorithm: untrained, as a configuration describes them, and as plain weights."""

from __future__ import annotations

import inspect
import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import sb3_contrib
import stable_baselines3
import torch
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.off_policy_algorithm import OffPolicyAlgorithm
from stable_baselines3.common.on_policy_algorithm import OnPolicyAlgorithm
from stable_baselines3.common.torch_layers import FlattenExtractor
from stable_baselines3.common.utils import LinearSchedule
from stable_baselines3.common.vec_env.base_vec_env import VecEnv

from jawenv.base.errors import InputError, not_among, shown
from jawenv.base.files import validate
from jawenv.base.named_objects import import_named, is_named, reason
from jawenv.playing.policies.card import Architecture
from training.run.config import NetworkConfig, Schedule, TrainingConfig
from training.run.features import OwnFeatures
from training.run.pathwise import APG

_KINDS = (OnPolicyAlgorithm, OffPolicyAlgorithm)
ALGORITHMS: dict[str, type[BaseAlgorithm]] = {"APG": APG} | {
    name: value
    for library in (stable_baselines3, sb3_contrib)
    for name, value in vars(library).items()
    if isinstance(value, type) and issubclass(value, _KINDS)
}
_OURS = ("policy", "env", "seed", "device", "verbose", "stats_window_size", "tensorboard_log", "_init_setup_model")
"""Arguments that the training itself sets."""
ACTIVATIONS = {"tanh": torch.nn.Tanh, "relu": torch.nn.ReLU, "elu": torch.nn.ELU}


def algorithm_class(name: str) -> type[BaseAlgorithm]:
    """The class that a configuration names; one of the user's is imported, which runs its module."""
    if not is_named(name):
        if name not in ALGORITHMS:
            raise not_among("algorithm", name, sorted(ALGORITHMS), ", my_module:Name")
        return ALGORITHMS[name]
    kind = import_named(name, "algorithm")
    if not isinstance(kind, type) or not issubclass(kind, _KINDS):
        raise InputError(f"algorithm is {name!r}; allowed: a subclass of {' or '.join(one.__name__ for one in _KINDS)}")
    return kind


def parameters_of(kind: type[BaseAlgorithm]) -> dict[str, inspect.Parameter]:
    """Arguments that a configuration may give; some of them a class only passes on to its bases."""
    found: dict[str, inspect.Parameter] = {}
    for one in (one for one in kind.__mro__ if "__init__" in vars(one)):
        parameters = list(inspect.signature(vars(one)["__init__"]).parameters.values())[1:]
        for parameter in (p for p in parameters if p.kind in (p.POSITIONAL_OR_KEYWORD, p.KEYWORD_ONLY)):
            found.setdefault(parameter.name, parameter)
        if not any(parameter.kind is parameter.VAR_KEYWORD for parameter in parameters):
            break
    return {name: parameter for name, parameter in found.items() if name not in _OURS}


def arguments_of(config: TrainingConfig, kind: type[BaseAlgorithm]) -> dict[str, Any]:
    """The keyword arguments of a configuration as a class takes them."""
    allowed = parameters_of(kind)
    given: dict[str, Any] = {}
    for name, value in config.arguments.items():
        if name not in allowed:
            raise not_among(f"key of arguments, of {config.algorithm},", name, allowed)
        given[name] = _argument(f"arguments.{name}", value, allowed[name].default)
    _check_batches(config, allowed, kind)
    return given


def _argument(name: str, value: Any, default: Any) -> Any:
    """An argument: a mapping is a schedule where the default is a number, and a number stays one."""
    if type(default) not in (bool, int, float):
        return value
    if isinstance(value, Mapping):
        schedule = validate(Schedule, value, name)
        return LinearSchedule(schedule.initial, schedule.final, 1.0)
    allowed = {bool: (bool,), int: (int,), float: (int, float)}[type(default)]
    if type(value) not in allowed or not math.isfinite(value):
        kind = {bool: "true or false", int: "an integer", float: "a number"}[type(default)]
        raise InputError(f"{name} is {shown(value)}; allowed: {kind}")
    return value


def _check_batches(config: TrainingConfig, allowed: Mapping[str, inspect.Parameter], kind: type[BaseAlgorithm]) -> None:
    """Make sure that an on-policy algorithm's rollout is cut into whole batches."""
    defaults = {name: parameter.default for name, parameter in allowed.items()}
    steps, batch = (config.arguments.get(name, defaults.get(name)) for name in ("n_steps", "batch_size"))
    if not issubclass(kind, OnPolicyAlgorithm) or not (isinstance(steps, int) and isinstance(batch, int)):
        return
    if steps < 1 or batch < 2 or config.n_envs * steps % batch:
        raise InputError(
            f"n_envs x arguments.n_steps is {config.n_envs} x {steps} = {config.n_envs * steps}; "
            f"allowed: a multiple of arguments.batch_size, {batch}"
        )


def make_model(config: TrainingConfig, worlds: VecEnv) -> BaseAlgorithm:
    """The untrained model that the configuration describes."""
    kind: Any = algorithm_class(config.algorithm)
    arguments, device = arguments_of(config, kind), _device(config.device)
    policy = arguments.pop("policy_kwargs", None) or {}
    try:
        model: BaseAlgorithm = kind(
            next(iter(kind.policy_aliases)),  # the perceptron, with a memory if the class has one
            worlds,
            stats_window_size=worlds.num_envs,
            device=device,
            seed=config.seed,
            policy_kwargs=_network(config.network, kind) | policy,
            **arguments,
        )
    except (InputError, MemoryError):
        raise
    except Exception as error:  # a class refuses what it cannot use with any error
        raise InputError(f"algorithm {config.algorithm}: cannot be made: {reason(error)}") from error
    _scale_last_layer(model, config.network.initial_action_scale)
    return model


def _network(network: NetworkConfig, kind: type[BaseAlgorithm]) -> dict[str, Any]:
    """The policy's own arguments."""
    on_policy = issubclass(kind, OnPolicyAlgorithm)
    if network.final_log_std is not None and not on_policy:
        raise InputError(
            f"network.final_log_std is {network.final_log_std}; allowed: null, as {kind.__name__} has none"
        )
    arguments: dict[str, Any] = {
        "net_arch": {"pi": list(network.policy), "vf" if on_policy else "qf": list(network.value)},
        "activation_fn": ACTIVATIONS[network.activation],
    }
    if on_policy:
        arguments["log_std_init"] = network.initial_log_std
    if network.features is not None:
        arguments |= {
            "features_extractor_class": OwnFeatures,
            "features_extractor_kwargs": {"function": network.features},
        }
    return arguments


def _scale_last_layer(model: BaseAlgorithm, scale: float) -> None:
    """Make the first actions smaller, so that a residual begins as its maneuver."""
    if scale == 1.0:
        return
    layer: Any = [layer for layer in _layers(model) if isinstance(layer, torch.nn.Linear)][-1]
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


def plain_policy(model: BaseAlgorithm, config: TrainingConfig) -> tuple[Architecture, dict[str, np.ndarray]] | None:
    """The network of a model that leads from an observation to the action without chance, and its weights.

    The weights have the names and shapes of `Architecture.shapes`, in single precision. None if a card describes no
    such network: one that sees features of one's own, or has other layers than perceptrons.
    """
    policy: Any = model.policy
    squash = policy.squash_output
    seen = getattr(policy, "features_extractor", None) or getattr(policy.actor, "features_extractor", None)
    layers = _layers(model)
    if squash and isinstance(layers[-1], torch.nn.Tanh):
        layers = layers[:-1]
    known = (torch.nn.Linear, ACTIVATIONS[config.network.activation])
    own_parts = type(seen) is not FlattenExtractor or hasattr(policy, "lstm_actor")
    if own_parts or any(type(layer) not in known for layer in layers):
        return None
    linear = [layer for layer in layers if isinstance(layer, torch.nn.Linear)]
    tensors = {f"layers.{i}.{name}": getattr(layer, name) for i, layer in enumerate(linear) for name in _PARTS}
    architecture = Architecture(
        layers=(linear[0].in_features, *(layer.out_features for layer in linear)),
        activation=config.network.activation,
        squash="tanh" if squash else "clip",
    )
    weights = {name: np.array(values.detach().cpu().numpy(), np.float32, order="C") for name, values in tensors.items()}
    return architecture, weights


_PARTS = ("weight", "bias")


def _layers(model: BaseAlgorithm) -> list[torch.nn.Module]:
    """Layers and activations from what the networks see to action."""
    policy: Any = model.policy
    if isinstance(model, OnPolicyAlgorithm):
        return [*policy.mlp_extractor.policy_net, policy.action_net]
    actor = policy.actor
    last = actor.mu if isinstance(actor.mu, torch.nn.Sequential) else [actor.mu]
    return [*getattr(actor, "latent_pi", ()), *last]
