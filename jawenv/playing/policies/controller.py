"""Policies that decide, and the controllers that turn their decisions into actions of an environment.

`ControlledAgent` uses a controller in play, where an environment is moved step by step; `ControlledWorlds` in training,
where a policy gets worlds in which an action is a decision. `residual` and `following` beside this module have
controllers.
"""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np
import numpy.typing as npt
from gymnasium import spaces
from gymnasium.vector import AutoresetMode, VectorEnv, VectorWrapper
from gymnasium.vector.utils import batch_space

from jawenv.base.errors import InputError
from jawenv.controls import Control
from jawenv.envs.configuration import Configuration
from jawenv.playing.agents import Action, Agent, Mask, Memory, Observation, Remembering, introduce

Batch = tuple[Observation, dict[str, Any]]
StepBatch = tuple[Observation, npt.NDArray[np.float64], Mask, Mask, dict[str, Any]]


class _Controller(Protocol):
    """The step from decisions to actions, with a memory of each world: zeros where an episode begins."""

    control: Control  # control mode of the environment
    decision_hz: float  # decisions per second
    steps_per_decision: int  # control steps from one decision to the next
    n_features: int  # how many values the policy sees beside the environment's observation
    memory: np.dtype[Any]  # dtype of the memory of a world

    def seen(self, rows: Observation, memory: npt.NDArray[Any]) -> Observation:
        """Inputs of the policy (N, size + n_features) from observations (N, size)."""
        ...

    def act(self, rows: Observation, memory: npt.NDArray[Any], decision: Action | None) -> Action:
        """Actions (N, 4) of this control step.

        Args:
            rows: (N, size) observations.
            memory: (N,) moves on by a control step.
            decision: (N, 4) where one is due.
        """
        ...


class ControlledAgent(Remembering):
    """An agent whose decisions a controller turns into actions; it is asked only when a decision is due.

    A world that begins an episode between two decisions has none until the next one.

    Args:
        agent: policy from inputs to decisions.
        controller: makes actions of them.

    Attributes:
        name: the agent's.
        control: the controller's.
        agent: as given.
        controller: as given.
        decision: the last one (N, 4), of a whole batch; None before the first.
    """

    decision: Action | None = None

    def __init__(self, agent: Agent, controller: _Controller) -> None:
        self.name = agent.name
        self.control = controller.control
        self.agent = agent
        self.controller = controller
        # And whether the world's episode began before the last decision.
        self._remembered = (controller.memory, np.bool_)

    def reset(self, num_envs: int, seed: int | None = None) -> None:
        """Forget all worlds; seed the draws of a stochastic agent."""
        super().reset(num_envs, seed)
        self.agent.reset(num_envs, seed)

    def take_world(self, world: Configuration) -> None:
        """Tell controller and agent of the worlds that are to be played, if they want to know."""
        for part in (self.controller, self.agent):
            if hasattr(part, "take_world"):
                part.take_world(world)

    def _decide(
        self, rows: Observation, memory: Memory, starts: Mask | None, deterministic: bool
    ) -> tuple[Action, Memory]:
        of_worlds, decided = memory.of_worlds
        if memory.shared is None:
            self.agent.reset(len(rows))
        step, inner = memory.shared or (0, None)  # control steps since the last decision, the agent's own memory
        decision = None
        if step == 0:
            seen = self.controller.seen(rows, of_worlds)
            decision, inner = self.agent.predict(seen, inner, ~decided, deterministic)
            decided = np.ones(len(rows), dtype=bool)
            self.decision = np.asarray(decision)
        action = self.controller.act(rows, of_worlds, decision)
        return action, Memory((of_worlds, decided), ((step + 1) % self.controller.steps_per_decision, inner))


class ControlledWorlds(VectorWrapper[Observation, Action, Observation, Action, Any]):
    """N worlds in which an action is a decision, and a step lasts until the next one.

    The reward is the sum over the control steps, and ``info["cost"]`` their mean. A world whose episode ends between
    two decisions is done, and its next episode has no decision until the next step.

    Args:
        env: N worlds in the controller's control mode, with the autoreset mode ``same_step``.
        controller: makes actions of decisions.

    Attributes:
        controller: as given.
    """

    def __init__(self, env: VectorEnv[Observation, Action, Any], controller: _Controller) -> None:
        super().__init__(env)
        mode, inner = env.metadata.get("autoreset_mode"), env.single_observation_space
        if mode != AutoresetMode.SAME_STEP:
            raise InputError(f"autoreset_mode is {mode}; allowed: same_step")
        if not isinstance(inner, spaces.Box) or len(inner.shape) != 1:
            raise InputError(f"observation space is {inner}, but decisions need a flat Box")
        beside = np.ones(controller.n_features, dtype=np.float32)
        low, high = np.append(inner.low, -beside), np.append(inner.high, beside)
        self.single_observation_space = spaces.Box(low, high, dtype=np.float32)
        self.observation_space = batch_space(self.single_observation_space, env.num_envs)
        self.controller = controller
        introduce(controller, env)

    def reset(self, *, seed: Any = None, options: dict[str, Any] | None = None) -> Batch:
        """Start new episodes in all worlds."""
        self._rows, info = self.env.reset(seed=seed, options=options)
        self._memory = np.zeros(self.num_envs, self.controller.memory)
        return self.controller.seen(self._rows, self._memory), info

    def step(self, actions: Action) -> StepBatch:
        """Let the decisions ``actions`` (N, 4) be acted on until the next ones are due."""
        decision: Action | None = actions
        reward, cost, steps = np.zeros((3, self.num_envs))
        terminated, truncated = np.zeros((2, self.num_envs), dtype=bool)
        finals: dict[str, Any] = {}
        for _ in range(self.controller.steps_per_decision):
            action = self.controller.act(self._rows, self._memory, decision)
            self._rows, gained, failed, ended, info = self.env.step(action)
            decision, going, over = None, ~(terminated | truncated), failed | ended
            self._keep_finals(finals, info, going & over)
            if "cost" in info:
                last = finals["final_info"]["cost"] if (going & over).any() else 0.0
                cost += going * np.where(over, last, info["cost"])
            reward += going * gained
            steps += going
            terminated |= going & failed
            truncated |= going & ended
            self._memory[over] = np.zeros(1, self._memory.dtype)
        if "cost" in info:
            info["cost"] = np.where(terminated | truncated, info["cost"], cost / steps)
            if finals:
                finals["final_info"]["cost"] = cost / steps
        step_info = {key: value for key, value in info.items() if "final_" not in key}
        return self.controller.seen(self._rows, self._memory), reward, terminated, truncated, step_info | finals

    def _keep_finals(self, finals: dict[str, Any], info: dict[str, Any], worlds: Mask) -> None:
        """Keep the last observation and info of worlds (N,) whose episodes have just ended."""
        if not worlds.any():
            return
        if not finals:
            nothing = {key: np.zeros_like(value) for key, value in info["final_info"].items()}
            finals |= {"final_obs": np.full(self.num_envs, None, dtype=object), "final_info": nothing}
            finals |= {"_final_obs": np.zeros_like(worlds), "_final_info": np.zeros_like(worlds)}
        rows = np.stack(list(info["final_obs"][worlds]))
        for i, row in zip(np.flatnonzero(worlds), self.controller.seen(rows, self._memory[worlds]), strict=True):
            finals["final_obs"][i] = row
        for key, value in info["final_info"].items():
            finals["final_info"][key][worlds] = value[worlds]
        finals["_final_obs"] |= worlds
        finals["_final_info"] |= worlds
