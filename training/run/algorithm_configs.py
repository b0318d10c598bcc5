"""The settings of each algorithm, one section of a configuration per algorithm."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from jawenv.base.files import InputModel, Number

Fraction = Annotated[Number, Field(ge=0.0, le=1.0)]
PositiveInt = Annotated[int, Field(gt=0, strict=True)]
PositiveNumber = Annotated[Number, Field(gt=0.0)]
NotNegative = Annotated[Number, Field(ge=0.0)]
BatchSize = Annotated[int, Field(gt=1, strict=True)]
Activation = Literal["tanh", "relu", "elu"]


class LearningRate(InputModel):
    """Adam's step size, falling linearly from ``initial`` to ``final`` over the whole run."""

    initial: PositiveNumber = 3e-4
    final: NotNegative = 0.0


class NetworkConfig(InputModel):
    """Two separate perceptrons: the policy and its value function."""

    policy: tuple[PositiveInt, ...] = (64, 64)  # units of each hidden layer
    value: tuple[PositiveInt, ...] = (64, 64)  # units of each hidden layer
    activation: Activation = "tanh"  # between layers
    initial_log_std: Number = -0.5  # natural log of the sd of the actions at the start
    final_log_std: Number | None = None  # where it falls to, linearly over the run; null leaves it to the learning
    initial_action_scale: PositiveNumber = 1.0
    """Factor of the last layer's initial weights; below 1 the first actions are near to 0."""


class LSTMNetworkConfig(NetworkConfig):
    """The same behind one layer of LSTM units each."""

    lstm_units: PositiveInt = 64


class PPOConfig(InputModel):
    """Proximal policy optimisation (Schulman et al. 2017, arXiv:1707.06347), as in stable-baselines3."""

    n_steps: PositiveInt = 64
    batch_size: BatchSize = 2048
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


class APGConfig(InputModel):
    """Analytic policy gradient through a differentiable twin (``training.run.pathwise``)."""

    n_steps: PositiveInt = 50  # decisions of an episode in the twin
    learning_rate: LearningRate = LearningRate(initial=2e-3, final=1e-4)  # of the policy
    max_grad_norm: PositiveNumber = 1.0  # largest norm of the gradient
    priors: tuple[str, ...] = ()
    """Cohorts with whose priors every other patient begins, each with that under which it is likeliest."""
    time_weight: NotNegative = 0.0  # nats for the share of the time in which an error bar is above 5 %
    network: NetworkConfig = NetworkConfig(value=(), initial_action_scale=0.1)
    """Sizes; the value function is not learned."""


class RecurrentPPOConfig(PPOConfig):
    """PPO with a memory of its own, as in sb3-contrib; its batches are cut out of whole sequences."""

    network: LSTMNetworkConfig = LSTMNetworkConfig()


class ActorCriticConfig(InputModel):
    """The policy and its critics, perceptrons of equal size."""

    units: tuple[PositiveInt, ...] = (128, 128)  # of each hidden layer
    activation: Activation = "relu"  # between layers
    initial_action_scale: PositiveNumber = 1.0
    """Factor of the last layer's initial weights; below 1 the first actions are near to 0."""


class SACConfig(InputModel):
    """Soft actor-critic (Haarnoja et al. 2018, arXiv:1801.01290), as in stable-baselines3."""

    learning_rate: LearningRate = LearningRate(initial=6e-4, final=6e-4)  # of all networks
    buffer_size: PositiveInt = 300_000  # transitions kept, over all worlds
    learning_starts: PositiveInt = 2560  # transitions by random actions before the first update
    batch_size: BatchSize = 512  # transitions per gradient step
    gradient_steps: PositiveInt = 10  # after each step of all worlds
    gamma: Fraction = 0.97  # discount
    tau: Annotated[Number, Field(gt=0.0, le=1.0)] = 0.005
    """Share of the critics that their targets take over per gradient step."""
    ent_coef: Annotated[str, Field(pattern=r"^auto(_\d*\.?\d+)?$")] | NotNegative = "auto_0.05"
    """Weight of the entropy; ``auto_0.05`` adapts it, beginning at 0.05."""
    network: ActorCriticConfig = ActorCriticConfig()  # sizes


class TQCConfig(SACConfig):
    """Truncated quantile critics (Kuznetsov et al. 2020, arXiv:2005.04269), as in sb3-contrib."""

    n_critics: PositiveInt = 2  # networks, each with ``n_quantiles``
    n_quantiles: PositiveInt = 25  # of the return's distribution
    dropped_quantiles: Annotated[int, Field(ge=0, strict=True)] = 2
    """The largest of each network, left out against overestimation."""
