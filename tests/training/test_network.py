"""The layers that act are taken out of a policy as they are, and what is more than layers is refused."""

import gymnasium as gym
import numpy as np
import pytest
import torch
from gymnasium import spaces
from sb3_contrib import TQC, RecurrentPPO
from stable_baselines3 import PPO, SAC, TD3
from stable_baselines3.common.base_class import BaseAlgorithm
from torch import nn

from jawenv.errors import InputError
from training.run.network import network_of


class Blank(gym.Env):
    """Has the spaces that a policy is built for; nobody steps it."""

    observation_space = spaces.Box(-np.inf, np.inf, (9,), np.float32)
    action_space = spaces.Box(-1.0, 1.0, (4,), np.float32)


def model(algorithm: type[BaseAlgorithm], policy: str = "MlpPolicy", **kwargs: object) -> BaseAlgorithm:
    net = {"net_arch": [8, 6]} | kwargs.pop("policy_kwargs", {})
    return algorithm(policy, Blank(), seed=1, device="cpu", policy_kwargs=net, **kwargs)


@pytest.mark.parametrize(
    ("algorithm", "activation", "name", "squash"),
    [
        (PPO, nn.Tanh, "tanh", "clip"),
        (PPO, nn.ELU, "elu", "clip"),
        (SAC, nn.ReLU, "relu", "tanh"),
        (TQC, nn.ReLU, "relu", "tanh"),
    ],
)
def test_layers_are_those_that_act(
    algorithm: type[BaseAlgorithm], activation: type[nn.Module], name: str, squash: str
) -> None:
    policy = model(algorithm, policy_kwargs={"activation_fn": activation}).policy
    network = network_of(policy, "here")
    assert (network.layers, network.activation, network.squash) == ((9, 8, 6, 4), name, squash)
    values = observation = torch.linspace(-1.0, 1.0, 9)
    for i in range(3):
        weight, bias = (torch.tensor(network.weights[f"layers.{i}.{part}"]) for part in ("weight", "bias"))
        values = weight @ values + bias
        values = activation()(values) if i < 2 else values
    values = torch.tanh(values) if squash == "tanh" else values.clamp(-1.0, 1.0)
    wanted = policy.predict(observation.numpy(), deterministic=True)[0]
    np.testing.assert_allclose(values.numpy(), wanted, rtol=0.0, atol=1e-6)


def test_a_network_without_hidden_layers_is_one_layer() -> None:
    network = network_of(model(PPO, policy_kwargs={"net_arch": []}).policy, "here")
    assert network.layers == (9, 4) and set(network.weights) == {"layers.0.weight", "layers.0.bias"}


@pytest.mark.parametrize(
    ("algorithm", "kwargs", "message"),
    [
        (RecurrentPPO, {"policy": "MlpLstmPolicy"}, "a recurrent policy cannot be exported"),
        (TD3, {}, "a TD3Policy cannot be exported; allowed: those of PPO, SAC and TQC"),
        (SAC, {"use_sde": True}, "its layers are Linear, ReLU, Linear, ReLU, Sequential"),
        (PPO, {"policy_kwargs": {"activation_fn": nn.GELU}}, "one kind of Tanh, ReLU, ELU"),
    ],
)
def test_what_is_more_than_layers_is_refused(algorithm: type[BaseAlgorithm], kwargs: dict, message: str) -> None:
    with pytest.raises(InputError) as caught:
        network_of(model(algorithm, **kwargs).policy, "here")
    assert str(caught.value).startswith("here: ") and message in str(caught.value) and "\n" not in str(caught.value)
