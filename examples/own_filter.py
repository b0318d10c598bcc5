"""A filter of your own in the place of the environment's: a plain extended Kalman filter of a hinge with one muscle.

    python examples/own_filter.py --patients 8

The jaw is opened and closed in force control. For each patient it prints what the filter claims (sd of F_o and b, in
percent), NEES/2 (about 1 on average if the sds are true) and the reward; then the same of the environment's own filter.
"""

import argparse
import sys

import gymnasium as gym
import numpy as np

import jawenv

STEPS = 4  # of the motion in a tick: a jaw that rests on its teeth is stiff
STEP = np.array([1e-6, 1e-6, 1e-4, 1e-4, 1e-4])  # of the derivatives by the state


class HingeFilter:
    """The textbook filter, linearised at its mean: angle, rate, log F_o, log b, and the load cell's gain error."""

    def reset(self, start):
        """Take over what is known before the first reading."""
        self.start = start
        self.mean = np.concatenate([start.start_mean[[2, 8]], start.prior.mean, [0.0]])
        self.cov = np.diag(np.concatenate([start.start_sd[[2, 8]], start.prior.sd, [start.gain_sd]]) ** 2)

    def update(self, measured, samples):
        """Predict under the force that the load cell read, then correct by pitch and its rate."""
        if samples is not None:
            self.predict(np.mean(samples, axis=0))
        rows, noise = np.eye(5)[:2], np.diag(self.start.measurement_sd[[3, 10]] ** 2)
        gain = self.cov @ rows.T @ np.linalg.inv(rows @ self.cov @ rows.T + noise)
        self.mean = self.mean + gain @ (measured[[3, 10]] - self.mean[:2])
        kept = np.eye(5) - gain @ rows
        self.cov = kept @ self.cov @ kept.T + gain @ noise @ gain.T  # the form that stays symmetric

    def predict(self, wrench):
        """One tick, with derivatives by differences; the wrench's noise is the process noise."""
        after = self.moved(self.mean, wrench)
        by_state = np.array([(self.moved(self.mean + d, wrench) - after) / d.sum() for d in np.diag(STEP)]).T
        by_wrench = np.array([(self.moved(self.mean, wrench + d) - after) / d.sum() for d in np.diag([1e-3] * 6)]).T
        self.cov = by_state @ self.cov @ by_state.T + by_wrench * self.start.wrench_sd**2 @ by_wrench.T
        self.mean = after

    def moved(self, state, wrench):
        """The state a tick later."""
        angle, rate, *logs, gain = state
        dt = self.start.tick_s / STEPS
        for _ in range(STEPS):
            q, u = np.array([0.0, 0.0, angle, 0.0, 0.0]), np.array([0.0, 0.0, 0.0, rate, 0.0])
            rate += dt * jawenv.acceleration(self.start.jaw, q, u, logs, (1.0 + gain) * wrench)[3]
            angle += dt * rate
        return np.array([angle, rate, *logs, gain])

    @property
    def belief(self):
        """Mean and covariance of the log-parameters."""
        return self.mean[2:4], self.cov[2:4, 2:4]


def play(patients: int, seconds: int, seed: int, estimator: object = None) -> tuple[np.ndarray, ...]:
    """Sds (%), NEES/2 and rewards of ``patients`` whose jaws open and close, with the estimator in the environment."""
    env = gym.make_vec("jawenv/JawHinge-v3", num_envs=patients, control="force", estimator=estimator)
    env.reset(seed=seed)
    total = np.zeros(patients)
    for time in np.arange(1, 20 * seconds + 1) / 20:
        opened = 0.5 * np.sin(0.5 * np.pi * time) ** 2 * np.array([1.0, 1.0, 0.0, 0.0])
        _, reward, _, _, info = env.step(np.tile(opened.astype(np.float32), (patients, 1)))
        total += reward
    return 100.0 * info["belief_sd"], info["nees"] / 2.0, total


def main() -> None:
    """Read the command line, play and print."""
    parser = argparse.ArgumentParser(description="Play with a filter of one's own.")
    parser.add_argument("--patients", type=int, default=4)
    parser.add_argument("--seconds", type=int, default=4)
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    for name in ("patients", "seconds"):
        if getattr(given, name) < 1:
            raise jawenv.InputError(f"{name} is {getattr(given, name)}; allowed: 1 or more")
    for title, estimator in (("own", HingeFilter()), ("environment's", None)):
        rows = list(zip(*play(given.patients, given.seconds, given.seed, estimator), strict=True))
        for sd, nees, reward in rows:
            print(f"{title:13}  F_o ± {sd[0]:5.2f} %  b ± {sd[1]:5.2f} %  NEES/2 {nees:6.2f}  {reward:5.2f} nats")
        print(f"{title:13}  mean NEES/2 {np.mean([nees for _, nees, _ in rows]):.2f}\n", flush=True)


if __name__ == "__main__":
    try:
        main()
    except jawenv.InputError as error:
        print(f"error: {error}", file=sys.stderr)
        sys.exit(2)
