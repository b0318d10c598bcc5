"""A design environment that is no jaw: a line whose two coefficients are learnt from readings at chosen places.

    python examples/linear_design_env.py

The action is where to read next. The belief is the conjugate normal one, so that all of the interface is exact.
"""

import gymnasium as gym
import numpy as np
from scipy.stats import multivariate_normal, norm

SD, STEPS = 0.1, 10


class LinearDesign(gym.Env):
    """y = a + b x + noise, with a standard normal prior of a and b; x is chosen in [-1, 1]."""

    parameter_names = ("a", "b")
    observation_space = gym.spaces.Box(-np.inf, np.inf, (6,), np.float64)
    action_space = gym.spaces.Box(-1.0, 1.0, (1,), np.float64)

    class prior:  # noqa: N801  an attribute of the interface
        """Standard normal."""

        sample = staticmethod(lambda n, seed: np.random.default_rng(seed).normal(size=(n, 2)))
        log_density = staticmethod(lambda theta: np.atleast_1d(multivariate_normal(np.zeros(2)).logpdf(theta)))

    def reset(self, *, seed=None, options=None):
        """Draw a line."""
        super().reset(seed=seed)
        self.truth, self.xs, self.ys = self.np_random.normal(size=2), [], []
        return self._seen()

    def step(self, action):
        """Read at a place; the reward is the fall of the belief's log determinant."""
        before = np.linalg.slogdet(self._belief()[1])[1]
        self.xs.append(float(action[0]))
        self.ys.append(self.truth @ (1.0, self.xs[-1]) + SD * self.np_random.normal())
        observation, info = self._seen()
        return observation, before - np.linalg.slogdet(info["belief_cov"])[1], False, len(self.xs) == STEPS, info

    def simulate(self, theta, actions, seed):
        """Readings at chosen places."""
        xs = np.asarray(actions, dtype=np.float64)[:, 0]
        return {"x": xs, "y": theta[0] + theta[1] * xs + SD * np.random.default_rng(seed).normal(size=len(xs))}

    def log_likelihood(self, readings, theta):
        """Log-likelihood of parameters (m, 2)."""
        theta = np.asarray(theta)
        return norm.logpdf(readings["y"], theta[:, :1] + theta[:, 1:] * readings["x"], SD).sum(axis=1)

    def _belief(self):
        rows = np.stack([np.ones(len(self.xs)), self.xs], axis=1) / SD
        cov = np.linalg.inv(np.eye(2) + rows.T @ rows)
        return cov @ rows.T @ (np.array(self.ys) / SD), cov

    def _seen(self):
        mean, cov = self._belief()
        info = {"belief_mean": mean, "belief_cov": cov, "truth": self.truth.copy(), "cost": 0.0}
        return np.concatenate([mean, cov.ravel()]), info


if __name__ == "__main__":
    env = LinearDesign()
    theta = env.prior.sample(2, seed=0)
    print(env.log_likelihood(env.simulate(theta[0], np.ones((5, 1)), seed=0), theta))  # the first made the readings
