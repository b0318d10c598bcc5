"""Costs of an entry of a comparison: steps of its training, and the time of one decision.

A planner's is the time of the comparison's own plans over their number: to make one more alone takes minutes.
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from statistics import median
from typing import Any, NamedTuple

import gymnasium as gym

from eval.kept.entries import Entry, Settings, load_entry
from jawenv.base.errors import InputError
from jawenv.base.named_objects import is_named
from jawenv.playing.agents import introduce, own_seed
from jawenv.playing.policies.card import card_of

DECISIONS = 200
UNKNOWN = float("nan")


class Cost(NamedTuple):
    """The cost of one entry."""

    trained_steps: float = UNKNOWN  # steps of the environment or of its twin; NaN for what is not trained
    decision_ms: float = UNKNOWN
    """Median time of one decision for one patient on this machine, of a planner mean time of a plan in the comparison;
    NaN if not timed.
    """


def cost(about: Mapping[str, Any], settings: Mapping[str, Any]) -> Cost:
    """Read the steps from an entry's card, and time it on the first patient if it is no planner.

    Nothing is known of an agent of the user's own, whose module would run, nor of one whose folder is gone.

    Args:
        about: metadata of the entry, as `Entry.about`.
        settings: of the comparison, as `Settings.to_mapping`.
    """
    if is_named(about["spec"]) or about.get("planned"):
        return Cost(decision_ms=about.get("plan_ms", UNKNOWN))
    played = Settings.from_mapping(settings)
    try:
        entry = load_entry(about["spec"], played.world)
    except InputError:
        return Cost()
    card = card_of(entry.spec)
    return Cost(UNKNOWN if card is None else float(card[1].steps), _decision_ms(entry, played.seed))


def _decision_ms(entry: Entry, seed: int) -> float:
    agent: Any = entry.agent
    env = gym.make_vec(entry.env_id, num_envs=1, **entry.env_kwargs)
    observation, _ = env.reset(seed=seed)
    if hasattr(agent, "reset"):
        agent.reset(1, own_seed())
    introduce(agent, env)
    _, state = agent.predict(observation, state=None, episode_start=[True], deterministic=True)
    spent = []
    for _ in range(DECISIONS):
        began = time.perf_counter()
        _, state = agent.predict(observation, state=state, episode_start=[False], deterministic=True)
        spent.append(1e3 * (time.perf_counter() - began))
    return median(spent)
