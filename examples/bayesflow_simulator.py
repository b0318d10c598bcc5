"""A simulator in the form of BayesFlow: ``sample(batch_shape)`` gives a dictionary of arrays, one row a patient.

    python examples/bayesflow_simulator.py

``bayesflow.workflows.BasicWorkflow(simulator=..., inference_variables="theta", summary_variables="readings")`` takes
such an object. Any design environment is one in this way; here it is the hinge, opened and closed once in two seconds.
"""

from collections.abc import Sequence

import gymnasium as gym
import numpy as np

import jawenv  # noqa: F401  registers its environments
from jawenv.design import DesignEnv, JawDesign

EVERY = 10  # ticks between readings that are kept


class Simulator:
    """Draws parameters and simulates what their patients' devices read.

    Args:
        env: a design environment.
        actions: (K, ...) of every experiment.
        seed: of the first patient.
    """

    def __init__(self, env: DesignEnv, actions: np.ndarray, seed: int = 0) -> None:
        self._env, self._actions, self._seed = env, actions, seed

    def sample(self, batch_shape: int | Sequence[int]) -> dict[str, np.ndarray]:
        """Rows ``theta`` (..., p) and ``readings`` (..., T, m), other ones at each call."""
        shape = (batch_shape,) if isinstance(batch_shape, int) else tuple(batch_shape)
        number = int(np.prod(shape))
        theta = self._env.prior.sample(number, self._seed)
        rows = [self._env.simulate(one, self._actions, self._seed + i)["measured"] for i, one in enumerate(theta)]
        self._seed += number
        readings = np.stack(rows)[:, ::EVERY]
        return {"theta": theta.reshape(*shape, -1), "readings": readings.reshape(*shape, *readings.shape[1:])}


def main() -> None:
    """Print the shapes of a batch."""
    time = np.arange(1, 41) / 20
    opening = np.outer(0.5 * np.sin(0.5 * np.pi * time) ** 2, [1.0, 1.0, 0.0, 0.0]).astype(np.float32)
    env = JawDesign(gym.make("jawenv/JawHinge-v3", control="force"))
    for name, values in Simulator(env, opening).sample(8).items():
        print(f"{name:10}{values.shape}")


if __name__ == "__main__":
    main()
