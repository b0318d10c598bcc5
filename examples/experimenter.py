"""A text door for any agent, a language model among them: it moves a jaw, reads, answers, and gets a proper score.

    python examples/experimenter.py --seed 7  # with --marks: what the prior and two movements score

Both sides write JSON, one object a line. The first line tells the task. The agent asks ``{"move": [[seconds, opening,
side, fore_aft, roll], ...]}``, and gets what the device read; ``{"identify": true}``, and gets the filter's estimate,
unless ``--no-filter``; and ends with ``{"answer": {parameter: [mean, sd], ...}}`` of natural logs. Its score is the log
density of that answer at the truth, in nats, less the prior's: too sure costs as much as too vague.
"""

import argparse
import json
import sys
from typing import Any

import gymnasium as gym
import numpy as np

import jawenv
from jawenv.envs.observation import OBSERVATION_LAYOUT
from jawenv.metrics import log_density

HZ = 5  # decisions a second
READ = ("time_s", "discomfort", "opening_mm", "side_mm", "fore_aft_mm", "force_x_N", "force_y_N", "force_z_N")
TASK = (
    "Six muscles close a jaw. Each pulls with F_o exp(b stretch). Move the jaw, find the natural logs of F_o (N) and b."
    " Targets: opening 0 to 1, others -1 to 1, as shares of what is comfortable; the device keeps the budget."
)


class Experiment:
    """One patient, some seconds, and a budget of discomfort that the device keeps."""

    def __init__(self, seed: int, cohort: str, seconds: float, use_filter: bool) -> None:
        self.world = {"cohort": cohort, "episode_s": seconds, "comfort_budget_s": seconds / 300}
        self.env = gym.make("jawenv/Jaw-v3", **self.world)
        self.observation, self.info = self.env.reset(seed=seed)
        self.left, self.use_filter = round(seconds * HZ), use_filter
        self.names, prior = self.env.unwrapped.parameter_names, self.env.unwrapped.prior
        self.prior = self.told(prior.mean, prior.sd)
        self.task = {"task": TASK, **self.world, "prior": self.prior}

    def move(self, path: list[list[float]]) -> dict[str, Any]:
        """Go to each target in so many seconds; returns what the device read meanwhile."""
        asked = np.array(path, dtype=float)
        if asked.ndim != 2 or asked.shape[1] != 5 or not np.isfinite(asked).all() or not (asked[:, 0] > 0.0).all():
            raise jawenv.InputError("move is no list of [seconds > 0, opening, side, fore_aft, roll]")
        at = self.observation[OBSERVATION_LAYOUT["motor_target"]] * 1.0
        rows = []
        for seconds, *target in asked:
            goal = np.clip(target, [0.0, -1.0, -1.0, -1.0], 1.0)
            steps = max(round(seconds * HZ), 1)
            for step in range(1, min(steps, self.left) + 1):
                if self.left:
                    rows.append(self._step(at + step / steps * (goal - at)))
            at = goal
        return {"rows": rows, "seconds_left": self.left / HZ}

    def _step(self, target: np.ndarray) -> dict[str, Any]:
        action = np.concatenate([[2.0 * target[0] - 1.0], target[1:]]).astype(np.float32)
        self.observation, _, terminated, truncated, self.info = self.env.step(action)
        self.left = 0 if terminated or truncated else self.left - 1
        jaw, span, force = (self.observation[OBSERVATION_LAYOUT[name]] for name in ("jaw", "jaw_range", "force"))
        numbers = (self.info["time"], self.info["cost"], *jaw * span * [30.0, 10.0, 10.0], *24.0 * force[:3])
        return {name: round(float(value), 3) for name, value in zip(READ, numbers, strict=True)}

    def identify(self, _: Any) -> dict[str, Any]:
        """The filter's estimate so far."""
        if not self.use_filter:
            raise jawenv.InputError("identify is not allowed here")
        return {"estimate": self.told(self.info["belief_mean"], self.info["belief_sd"])}

    def told(self, mean: np.ndarray, sd: np.ndarray) -> dict[str, list[float]]:
        """Means and sds by the parameters' names."""
        return {name: np.round(both, 5).tolist() for name, *both in zip(self.names, mean, sd, strict=True)}

    def answer(self, told: dict[str, list[float]]) -> dict[str, Any]:
        """The score of means and sds of all parameters."""
        if not isinstance(told, dict) or set(told) != set(self.names):
            raise jawenv.InputError(f"answer has other names; allowed: {', '.join(self.names)}")
        mean, sd = np.moveaxis(np.array([[of[name] for name in self.names] for of in (told, self.prior)], float), 2, 0)
        if not np.isfinite(mean).all() or not (sd > 0.0).all():
            raise jawenv.InputError("answer has a mean or an sd that is none; allowed: finite means, sds above 0")
        own, prior = (float(log_density(self.info["truth"], *of)) for of in zip(mean, map(np.diag, sd**2), strict=True))
        return {"nats": round(own - prior, 2)}


def talk(experiment: Experiment, lines: Any) -> Any:
    """The replies to an agent's lines, until it has answered."""
    yield experiment.task
    for line in lines:
        try:
            ((what, given),) = json.loads(line).items()
            yield {"move": experiment.move, "identify": experiment.identify, "answer": experiment.answer}[what](given)
            if what == "answer":
                return
        except (ValueError, KeyError, TypeError, AttributeError) as error:
            yield {"error": str(error) or type(error).__name__}


def main() -> None:
    """Read the command line, then talk."""
    parser = argparse.ArgumentParser(description="A jaw as an experiment for an agent that reads and writes text.")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--cohort", default="anyone")
    parser.add_argument("--seconds", type=float, default=10.0)
    parser.add_argument("--no-filter", action="store_true", help="the agent has to estimate by itself")
    parser.add_argument("--marks", action="store_true", help="print what others score, and end")
    given = parser.parse_args()
    experiment = Experiment(given.seed, given.cohort, given.seconds, not given.no_filter)
    for name in ("slow_opening", "universal") if given.marks else ():
        played = jawenv.play(jawenv.Player(name), patients=1, seed=given.seed, env_kwargs=experiment.world)
        told = experiment.told(played.belief_mean[0, -1], played.belief_sd[0, -1])
        print(f"{name}, the filter's answer: {experiment.answer(told)['nats']} nats; the prior's is 0")
    for reply in () if given.marks else talk(experiment, sys.stdin):
        print(json.dumps(reply), flush=True)


if __name__ == "__main__":
    main()
