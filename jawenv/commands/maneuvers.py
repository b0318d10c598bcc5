"""The command ``jawenv score``, of a maneuver or another agent that comes with jawenv."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from jawenv.envs.configuration import Configuration
from jawenv.metrics import score
from jawenv.playing.policies.card import policy_folder, read_card
from jawenv.playing.policies.named import agent_of
from jawenv.playing.rollout import play


def world_for(spec: str, asked: Mapping[str, Any]) -> Configuration:
    """The world that is asked for; what is not said of a policy's is that of its training."""
    folder = policy_folder(spec)
    if folder is None:
        return Configuration.from_mapping(asked)
    environment = read_card(folder).environment
    environment.world()  # refuses cards that name code
    trained = {"env": environment.id, **environment.kwargs()}
    if "control" in asked:
        trained.pop("control_hz")
    return Configuration.from_mapping(trained | dict(asked))


def print_score(maneuver: str, patients: int, seed: int, world: Configuration) -> None:
    """Play an agent on patients, and print what it found out."""
    env_id = world.env_id
    player = agent_of(maneuver, world.control, world.control_hz, env_id)
    reached = score(play(player, patients=patients, seed=seed, env_kwargs=world.arguments, env_id=env_id))
    medians = (np.median(values, axis=0) for values in (reached.sd, np.abs(reached.error), reached.bound_sd))
    cohort = world.build_cohort().name
    print(f"{player.name} in {env_id} on {patients} patients of {cohort}, {world.episode_s:g} s; medians over them\n")
    print(f"{'parameter':32s}{'error bar':>12}{'error':>9}{'bound':>9}")
    for name, sd, error, bound in zip(reached.parameter_names, *medians, strict=True):
        print(f"{name:32s}{100 * sd:10.1f} %{100 * error:7.1f} %{100 * bound:7.1f} %")
    for threshold, times in reached.time_to_s.items():
        share = np.isfinite(times).mean()
        middle = np.quantile(times, 0.5, method="inverted_cdf")
        words = f"{middle:.1f} s" if np.isfinite(middle) else "never"
        print(f"all within {100 * threshold:.0f} %: {words} in the median, reached by {100 * share:.0f} %")
    true, claimed = reached.information_true.mean(), reached.information_claimed.mean()
    print(f"information: {true:.1f} nats, {claimed:.1f} by the error bars")
    print(f"NEES: {reached.nees.mean():.1f} (about {len(reached.parameter_names)} if the error bars are right)")
    crossed = 100 * reached.violated.mean()
    print(f"discomfort: {reached.discomfort_s.mean():.2f} s, a hard limit crossed in {crossed:.0f} %")
    if reached.alarm:
        print(f"alarm: {reached.alarm}; do not trust their beliefs")
    if not world.build_knowledge().exact:
        print("the bound is that of a filter that knows the anatomy")
