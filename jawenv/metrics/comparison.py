"""Maneuvers, policies and agents of one's own beside each other, on the same patients with the same noise."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from jawenv.base.errors import InputError, shown
from jawenv.base.seeds import REPORTS
from jawenv.envs.configuration import Configuration
from jawenv.metrics.intervals import mean
from jawenv.metrics.score import KNOWN, Score, score
from jawenv.playing.agents import Action, BatchAgent, Mask, Observation, State
from jawenv.playing.maneuvers import Maneuver, Player
from jawenv.playing.policies.card import OF_TRAINING, policy_folder, read_card
from jawenv.playing.policies.named import agent_of
from jawenv.playing.rollout import play


@dataclass
class _Function(BatchAgent):
    """A function of one observation as an agent."""

    function: Callable[[Observation], Any]
    name: str

    def _answer(
        self, rows: Observation, state: State, starts: Mask | None, deterministic: bool
    ) -> tuple[Action, State]:
        return np.array([self.function(row) for row in rows], dtype=np.float32), state


def compare(entries: Sequence[Any], patients: int = 64, seed: int = REPORTS[0].start, **world: Any) -> Any:
    """Play every entry on the same patients with the same noise, and judge it, as ``python -m eval compare`` does.

    Args:
        entries: each a name (``jawenv list``), a maneuver file, the folder of a policy, a `Maneuver`, an agent (see
            `play`), or a function from an observation (63,) to an action (4,).
        patients: how many, >= 1; patient i is drawn, and its noise made, by the seed ``seed + i``.
        seed: of the first patient, 0 to 2**32 - 1.
        **world: ``env``, an id, and arguments of the environment, as ``cohort`` and ``episode_s``.

    Returns:
        A ``pandas.DataFrame`` with a row for each entry, or a list of mappings where pandas is not installed. Columns
        are the mean of the seconds until all error bars are within 5 % (the episode's length where they never are), and
        when nine patients in ten are there (infinite for never); the worst error bar at the end, median, %; the share
        of estimates within 2 sds of the truth, %; NEES over the number of parameters; discomfort, s, mean; and true
        information, nats, less that of the first entry, patient by patient: mean and ends of its 95 % interval.

    Raises:
        InputError: no entry, one that is none of these, or what `play` or the environment refuses.
    """
    asked, rows, first = Configuration.from_mapping(world), [], None
    for entry in entries:
        name, agent, own = _contestant(entry, asked)
        env_kwargs = {**own.arguments, "track_bound": False}
        judged = score(play(agent, patients=patients, seed=seed, env_kwargs=env_kwargs, env_id=own.env_id))
        first = first or (name, judged.information_true)
        rows.append({"entry": name, **_figures(judged, own.episode_s, *first)})
    if not rows:
        raise InputError("entries is empty; allowed: one or more")
    try:
        import pandas as pd
    except ImportError:
        return rows
    return pd.DataFrame(rows).set_index("entry")


def _figures(judged: Score, episode_s: float, first: str, information: Any) -> dict[str, float]:
    """The columns of one entry."""
    known, gained = judged.time_to_s[KNOWN], mean(judged.information_true - information)
    return {
        "all within 5 %, s": float(np.minimum(known, episode_s).mean()),
        "nine in ten, s": float(np.quantile(known, 0.9, method="inverted_cdf")),
        "worst error bar, %": 100.0 * float(np.median(judged.worst_sd)),
        "within 2 sd, %": 100.0 * float(judged.inside[2].mean()),
        f"NEES/{len(judged.parameter_names)}": float(judged.nees.mean()) / len(judged.parameter_names),
        "discomfort, s": float(judged.discomfort_s.mean()),
        f"gain over {first}, nats": gained.value,
        "from": gained.low,
        "to": gained.high,
    }


def _contestant(entry: Any, asked: Configuration) -> tuple[str, Any, Configuration]:
    """Name, agent and world of an entry; a policy keeps the actions and sensors of its training."""
    if isinstance(entry, str | Path):
        if (folder := policy_folder(entry)) is not None:
            trained = read_card(folder).environment.world()
            asked = replace(asked, **{name: getattr(trained, name) for name in OF_TRAINING})
        agent = agent_of(entry, asked.control, asked.control_hz, asked.env_id)
    elif isinstance(entry, Maneuver):
        agent = Player(entry, control=asked.control, control_hz=asked.control_hz)
    elif callable(getattr(entry, "predict", None)):
        agent = entry
    elif callable(entry):
        agent = _Function(entry, getattr(entry, "__name__", type(entry).__name__))
    else:
        allowed = "a name, a file, a policy's folder, a Maneuver, an agent or a function"
        raise InputError(f"entry is {shown(entry)}; allowed: {allowed}")
    return getattr(agent, "name", type(agent).__name__), agent, asked
