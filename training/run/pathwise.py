"""Analytic policy gradient: a policy learns by the gradient of a differentiable twin (``agents.twin``).

The return of an episode is differentiated by the policy's weights through the whole episode, as brax's APG does, and
Deep Adaptive Design for experiments (Foster et al. 2021, arXiv:2103.02438). In each update all training worlds begin
anew. The policy plays their patients in the twin, with its beliefs and their noise, and then in the worlds themselves:
the twin has less discomfort than they have, so its price follows theirs. The weights are those of stable-baselines3's
policies, so that a run has all that others have.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import torch
from stable_baselines3.common.buffers import RolloutBuffer
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.on_policy_algorithm import OnPolicyAlgorithm
from stable_baselines3.common.policies import ActorCriticPolicy
from stable_baselines3.common.torch_layers import FlattenExtractor
from stable_baselines3.common.type_aliases import Schedule
from stable_baselines3.common.vec_env.base_vec_env import VecEnv
from torch import Tensor

from agents.twin.constants import Patients, Twin
from agents.twin.objective import log_worst, share_unsure, weights
from agents.twin.observation import observation
from agents.twin.worlds import Worlds
from jawenv.anatomy import Cohort, cohort
from jawenv.anatomy.cohorts import TRUNCATION_SD
from jawenv.base.errors import InputError, shown
from jawenv.base.named_objects import import_named, reason
from jawenv.envs.asked import asked_muscles
from jawenv.envs.observation import OBSERVATION_LAYOUT
from jawenv.playing.policies.residual import BaseTargets

UNSEEN = ("rates", "force", "motor_thrust")
"""Parts of the observation that are mostly noise, which the twin has none of: they have no weight."""


class APG(OnPolicyAlgorithm):
    """The algorithm; arguments are those of ``OnPolicyAlgorithm``, of whom no value function is learned.

    Args:
        policy: name of the policy's class.
        priors: cohorts with whose priors every other patient begins, each with that under which it is likeliest.
        time_weight: nats for the share of the time in which an error bar is above 5 %.
        objective: ``my_module:function`` of the twin's worlds -> (P,) that is made small; None for ``log_worst``.
        learning_rate: of the policy.
        n_steps: decisions of an episode.
        max_grad_norm: largest norm of the gradient.
        env: training worlds of a policy that corrects a maneuver, in targets control of the midline model.
        **arguments: others.

    Attributes:
        comfort_multiplier: price of discomfort, nats/s: the reward's, where none is learned.
    """

    priced: VecEnv | None = None
    """Worlds of fewer patients, whose discomfort makes the price; by default those that are trained on."""

    policy_aliases = {"MlpPolicy": ActorCriticPolicy}  # noqa: RUF012  as the base class has it

    def __init__(
        self,
        policy: str,
        env: VecEnv,
        priors: Sequence[str] = (),
        time_weight: float = 0.0,
        objective: str | None = None,
        learning_rate: float | Schedule = 2e-3,
        n_steps: int = 50,
        max_grad_norm: float = 1.0,
        **arguments: Any,
    ) -> None:
        arguments |= {"learning_rate": learning_rate, "n_steps": n_steps, "max_grad_norm": max_grad_norm}
        fixed: dict[str, Any] = {"gamma": 1.0, "gae_lambda": 1.0, "ent_coef": 0.0, "vf_coef": 0.0, "use_sde": False}
        super().__init__(policy, env, **fixed, sde_sample_freq=-1, **arguments)
        self._objective = log_worst if objective is None else _own_objective(objective)
        controlled: Any = env.get_attr("controller")[0]
        self._simulation: Any = env.get_attr("unwrapped")[0].simulation
        if not isinstance(controlled, BaseTargets) or self._simulation.configuration.control != "targets":
            raise InputError("APG corrects a maneuver in targets control; allowed: residual, control: targets")
        if self.n_steps != self._simulation.configuration.steps:
            allowed = f"the {self._simulation.configuration.steps} of an episode"
            raise InputError(f"arguments.n_steps is {self.n_steps}; allowed: {allowed}")
        self._base, self._time_weight = controlled, time_weight
        self._priors = [cohort(name, self._simulation.cohort.muscles) for name in priors]
        configuration, names = self._simulation.configuration, self._simulation.cohort.muscles.names
        asked = asked_muscles(configuration.asked, names, np.zeros(2, dtype=np.uint64))
        # The reward "worst" is as many times the log as there are parameters.
        self.comfort_multiplier: float = configuration.comfort_weight / (2.0 * float(asked.sum()))
        with torch.no_grad():
            first: Any = next(iter(self.policy.mlp_extractor.policy_net), self.policy.action_net)
            self._seen = first.weight.new_ones(first.in_features)
            for name in UNSEEN if isinstance(self.policy.features_extractor, FlattenExtractor) else ():
                self._seen[OBSERVATION_LAYOUT[name]] = 0.0
            first.weight.mul_(self._seen)
            first.weight.register_hook(lambda gradient: gradient * self._seen)

    def _excluded_save_params(self) -> list[str]:
        """Names that a checkpoint is without: worlds, and the graph of the last episode."""
        own = ("_simulation", "_base", "_seen", "_worst", "_discomfort", "priced", "_objective")
        return [*super()._excluded_save_params(), *own]

    def collect_rollouts(
        self, env: VecEnv, callback: BaseCallback, rollout_buffer: RolloutBuffer, n_rollout_steps: int
    ) -> bool:
        """Play new patients in the twin for so many decisions; the graph is kept for ``train``."""
        callback.on_rollout_start()
        seen: Any = env.reset()
        noise = self._n_updates + 2**16 * (self.seed or 0)
        self._worst, self._discomfort = self.play(n_rollout_steps, noise)
        infos: list[dict[str, Any]] = []
        few = self.priced or env
        if few is not env:
            seen = few.reset()
        for _ in range(n_rollout_steps):
            seen, _, _, infos = few.step(self.predict(seen, deterministic=True)[0])
        self.num_timesteps += env.num_envs * n_rollout_steps
        callback.update_locals({**locals(), "infos": infos})
        if not callback.on_step():
            return False
        callback.on_rollout_end()
        return True

    def train(self) -> None:
        """One step of Adam."""
        self.policy.set_training_mode(True)
        self._update_learning_rate(self.policy.optimizer)
        loss = (self._worst + self.comfort_multiplier * self._discomfort).mean()
        self.policy.optimizer.zero_grad()
        loss.backward()  # type: ignore[no-untyped-call]
        torch.nn.utils.clip_grad_norm_(self.policy.parameters(), self.max_grad_norm)
        self.policy.optimizer.step()
        self._n_updates += 1
        self.logger.record("train/loss", float(loss.detach()))
        self.logger.record("train/log_worst", float(self._worst.detach().mean()))
        self.logger.record("train/discomfort_s", float(self._discomfort.detach().mean()))

    def play(self, steps: int, seed: int) -> tuple[Tensor, Tensor]:
        """Weighted ``log_worst`` (P,) and discomfort (P,) above its limit, s, of so many decisions.

        Patients are those of the worlds, and what is asked of them.

        Args:
            steps: decisions.
            seed: of the readings' noise.
        """
        simulation, configuration = self._simulation, self._simulation.configuration
        with self.device:
            patients, asked = Patients.of_worlds(simulation.worlds), torch.tensor(simulation.asked).double()
            twin = Twin(simulation)
            generator, prior = torch.Generator(self.device).manual_seed(seed), self._prior_of(twin, patients)
            worlds = Worlds(twin, patients, generator, asked, prior)
        marks, whole = weights(steps), configuration.steps
        worst = patients.theta.new_zeros(len(patients))
        for step in range(steps):
            now = np.array([step])
            features = torch.tensor(self._base.features(now), device=self.device).expand(len(patients), -1)
            rows = observation(worlds, 1.0 - step / whole, configuration.parts)
            seen = torch.cat([rows.float(), features], -1)
            known: Any = self.policy.extract_features(seen)
            latent = self.policy.mlp_extractor.forward_actor(known)
            action = self.policy.action_net(latent).clamp(-1.0, 1.0).double()
            base = torch.tensor(self._base.targets(now), device=self.device)
            worlds.step(base + self._base.scale * action)
            if step + 1 in marks:
                worst = worst + marks[step + 1] * self._objective(worlds)
            if self._time_weight > 0.0:
                worst = worst + self._time_weight / steps * share_unsure(worlds)
        return worst, (worlds.discomfort - configuration.comfort_limit_s).clamp(min=0.0)

    def _prior_of(self, twin: Twin, patients: Patients) -> tuple[Tensor, Tensor] | None:
        """Means and sds (P, 12) that beliefs begin with; None for those of the worlds."""
        if not self._priors:
            return None
        number = len(patients)
        likely = torch.stack([_log_density(one, patients.theta) for one in self._priors]).argmax(0)
        own = likely.cpu().numpy()
        means, sds = (
            patients.theta.new_tensor(np.stack([getattr(one.prior, name) for one in self._priors]))[own]
            for name in ("mean", "sd")
        )
        half = (torch.arange(number, device=means.device) % 2 == 0)[:, None]
        return torch.where(half, means, twin.prior_mean), torch.where(half, sds, twin.prior_sd)


def _own_objective(spec: str) -> Callable[[Worlds], Tensor]:
    """The function of the user's that a spec names."""
    function = import_named(spec, "arguments.objective")
    if not callable(function):
        raise InputError(f"arguments.objective '{spec}' is a {type(function).__name__}; allowed: a function of worlds")

    def objective(worlds: Worlds) -> Tensor:
        number = len(worlds.patients)
        try:
            value = function(worlds)
        except Exception as error:  # code of the user's can raise anything
            raise InputError(f"arguments.objective '{spec}': {reason(error)}") from error
        if not isinstance(value, Tensor) or value.shape != (number,):
            raise InputError(f"arguments.objective '{spec}' gives {shown(value)}; allowed: a tensor ({number},)")
        return value

    return objective


def _log_density(population: Cohort, theta: Tensor) -> Tensor:
    """(P,) of log parameters (P, 12) in the likeliest group of a cohort."""
    mean, sd = theta.new_tensor(population.mean), theta.new_tensor(population.sd)
    z = (theta[:, None, :] - mean) / sd
    beyond = (z.abs() - TRUNCATION_SD).clamp(min=0.0)  # no patient of the cohort is there
    density: Tensor = (-0.5 * z.square() - sd.log() - 100.0 * beyond).sum(-1).amax(-1)
    return density
