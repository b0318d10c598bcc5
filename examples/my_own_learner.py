"""A learner of your own on the native vector form: the cross-entropy method, which needs NumPy alone.

python examples/my_own_learner.py --generations 20

It searches a linear law that corrects a maneuver by what is known of the patient so far. In every generation all
candidates play the same new patients at once, a world for each pair, and the best ones say where to look next.
Take `learn` out and put your own method there: an environment, an agent, and a score is all that it is given.
"""

import argparse
import sys

import gymnasium as gym
import numpy as np

import jawenv  # registers the environments
from jawenv.base.seeds import TRAINING
from jawenv.envs.observation import OBSERVATION_LAYOUT
from jawenv.playing.maneuvers.maneuver import action_of

MANEUVER, COHORT, HZ = "refined_one_sided", "one_sided", 5
CANDIDATES, BEST, PATIENTS = 24, 6, 8  # of a generation
SCALE, FIRST_SD, LEAST_SD = 0.3, 0.3, 0.02  # of the correction; of the weights at first, and at least


def world(episode_s):
    """Arguments of the environment; its reward gains by the least known parameter and pays for discomfort."""
    return {"cohort": COHORT, "reward": "worst", "comfort_weight": 60.0, "episode_s": episode_s}


class Law:
    """Corrects the maneuver's targets by a linear function of time and belief: an agent, also of many worlds at once.

    Args:
        weights: (F, 4), or (N, F, 4) with a law for each of N worlds.
        episode_s: length of an episode, s.
    """

    name = "my_own_learner"
    control = "targets"

    def __init__(self, weights, episode_s):
        self.weights = np.asarray(weights)
        self.steps = round(episode_s * HZ)
        self.targets = jawenv.Maneuver.named(MANEUVER).targets(np.arange(1, self.steps + 1) / HZ).value

    def reset(self, num_envs, seed=None):
        """Nothing to forget: the observation says how much time is left."""

    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        """Action (N, 4) for observations (N, size): opening, side, fore-aft force and roll."""
        rows = np.atleast_2d(observation)
        gone = 1.0 - rows[:, OBSERVATION_LAYOUT["time_left"]]
        step = np.clip(np.rint(gone[:, 0] * self.steps).astype(int), 0, self.steps - 1)
        correction = np.tanh((features(rows)[:, None, :] @ self.weights)[:, 0])
        action = action_of(self.targets[step] + SCALE * correction).astype(np.float32)
        return action.reshape(*observation.shape[:-1], 4), state


def features(rows):
    """(N, F) of observations (N, size): one, the phase of the episode, and by how much the left side is stiffer."""
    mean, left = rows[:, OBSERVATION_LAYOUT["belief_mean"]], OBSERVATION_LAYOUT["time_left"]
    half = mean.shape[1] // 2
    sides = mean[:, :half] - mean[:, half:]
    phase = 2.0 * np.pi * rows[:, left]
    stiffer = [sides[:, which::2].mean(axis=1) for which in (0, 1)]  # F_o, b
    return np.column_stack([np.ones(len(rows)), np.sin(phase), np.cos(phase), *stiffer])


def returns(env, law, seeds):
    """(N,) rewards of an episode in each world."""
    seen, _ = env.reset(seed=seeds)
    total = np.zeros(env.num_envs)
    for _ in range(law.steps):
        seen, reward, _, _, _ = env.step(law.predict(seen)[0])
        total += reward
    return total


def learn(generations, episode_s):
    """Weights (F, 4) of the law that the method ends with."""
    env = gym.make_vec("jawenv/Jaw-v3", num_envs=CANDIDATES * PATIENTS, autoreset_mode="disabled", **world(episode_s))
    shape = (features(env.reset(seed=TRAINING.start)[0]).shape[1], 4)
    mean, sd, draw = np.zeros(shape), np.full(shape, FIRST_SD), np.random.default_rng(0)
    for generation in range(generations):
        candidates = mean + sd * draw.standard_normal((CANDIDATES, *shape))
        candidates[0] = mean
        first = TRAINING.start + generation * PATIENTS
        law = Law(np.repeat(candidates, PATIENTS, axis=0), episode_s)
        reached = returns(env, law, [first + i % PATIENTS for i in range(env.num_envs)])
        reached = reached.reshape(CANDIDATES, PATIENTS).mean(axis=1)
        best = candidates[np.argsort(reached)[-BEST:]]
        mean, sd = best.mean(axis=0), np.maximum(best.std(axis=0), LEAST_SD)
        print(f"generation {generation + 1}: {reached[0]:.2f} at the mean, {reached.max():.2f} at best", flush=True)
    env.close()
    return mean


def judged(agent, patients, episode_s):
    """Print what an agent finds out about patients that nobody has learned on, and at which discomfort."""
    score = jawenv.score(jawenv.play(agent, patients=patients, seed=0, env_kwargs=world(episode_s)))
    worst = np.median(score.sd.max(axis=1))
    print(f"{agent.name:18s} worst error bar {worst:6.1%}, discomfort {score.discomfort_s.mean():.3f} s", flush=True)


def main():
    """Read the command line, learn and compare."""
    parser = argparse.ArgumentParser(description="Learn by the cross-entropy method.")
    parser.add_argument("--generations", type=int, default=20)
    parser.add_argument("--patients", type=int, default=64)
    parser.add_argument("--episode-s", type=float, default=10.0)
    given = parser.parse_args()
    for name in ("generations", "patients"):
        if getattr(given, name) < 1:
            raise jawenv.InputError(f"{name} is {getattr(given, name)}; allowed: 1 or more")
    judged(jawenv.Player(MANEUVER, control="targets"), given.patients, given.episode_s)
    judged(Law(learn(given.generations, given.episode_s), given.episode_s), given.patients, given.episode_s)


if __name__ == "__main__":
    try:
        main()
    except jawenv.InputError as error:
        print(f"error: {error}", file=sys.stderr)
        sys.exit(2)
