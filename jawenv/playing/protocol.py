"""The protocol of agents: an action for each observation."""

from typing import TYPE_CHECKING, Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from jawenv.errors import InputError, shown

if TYPE_CHECKING:
    from gymnasium.vector import VectorEnv

Array = NDArray[np.float64]
Observation = NDArray[np.float32]
Action = NDArray[np.float32]
Mask = NDArray[np.bool_]
State = tuple[Any, ...] | None


@runtime_checkable
class Agent(Protocol):
    """A hand-made maneuver, a trained policy or anything else that plays jawenv's environments.

    `predict` has the signature of stable-baselines3's `predict`, so a trained model and a hand-made maneuver are
    interchangeable, also inside `stable_baselines3.common.evaluation.evaluate_policy`.

    An agent whose actions belong to one control mode says so by an attribute ``control``, from which ``jawenv.play``
    takes it.

    Attributes:
        name: short name for tables and figures.
    """

    name: str

    def reset(self, num_envs: int, seed: int | None = None) -> None:
        """Forget everything and get ready for `num_envs` worlds that start new episodes."""
        ...

    def predict(
        self,
        observation: Observation,
        state: State = None,
        episode_start: Mask | None = None,
        deterministic: bool = True,
    ) -> tuple[Action, State]:
        """Choose the next action.

        Args:
            observation: (N, observation size), or (observation size,) for one world.
            state: what the last call returned. An agent with a memory also keeps it itself, so a caller may leave
                it out.
            episode_start: (N,) true where a new episode begins with this observation.
            deterministic: false lets a stochastic policy draw its action.

        Returns:
            action: (N, 4) or (4,), in [-1, 1].
            state: to be handed to the next call; None for an agent without memory.
        """
        ...


def checked_decision(answer: Any, agent: Any) -> tuple[Any, Any]:
    """The answer of an agent's ``predict``, checked: actions and a state.

    Args:
        answer: what it returned.
        agent: whose name, or class, the message has.

    Raises:
        InputError: no pair, or no array of actions in it.
    """
    if not isinstance(answer, tuple | list) or len(answer) != 2 or not hasattr(answer[0], "__len__"):
        name = getattr(agent, "name", type(agent).__name__)
        raise InputError(f"agent '{name}': predict() gives {shown(answer)}; allowed: an array of actions, and a state")
    return answer[0], answer[1]


@runtime_checkable
class Planning(Protocol):
    """The protocol, beside ``Agent``, of an agent that needs more than observations, such as a planner.

    ``jawenv.play`` calls ``attach`` where an agent has it, after ``Agent.reset`` and before the first ``predict``.
    """

    def attach(self, env: "VectorEnv[Any, Any, Any]") -> None:
        """Get to know the worlds that are to be played.

        Args:
            env: a vector environment of jawenv after its ``reset``. The agent reads its simulation, and changes nothing
                of it.

        Raises:
            InputError: an environment that the agent cannot play.
        """
        ...
