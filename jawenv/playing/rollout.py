"""Play an agent on many patients and keep what is needed to judge it.

One call plays N worlds at once in the native vector environment; world i uses the seed `seed + i` for its
patient and its noise, so two agents played with the same seed meet the same patients and the same
disturbances.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from importlib import import_module
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
import numpy.typing as npt

from jawenv.base.errors import InputError, shown
from jawenv.base.numeric_fields import whole_number
from jawenv.controls import control_of
from jawenv.ladder import DEFAULT_ENV as DEFAULT_ENV
from jawenv.playing.agents import Action, checked_decision, introduce, own_seed
from jawenv.playing.recording import Array, Mask, Recording

if TYPE_CHECKING:
    from jawenv.anatomy import Patient
    from jawenv.base.files import Source
    from jawenv.recordings.record import Record

OnStep: TypeAlias = Callable[[Any, Action | None], None]

LARGEST_SEED = 2**32 - 1  # of a first patient
LARGEST_OF_MANY = 2**63 - 1  # where each patient has one of his own, as tables hold them

_TRACKED = (
    "belief_mean",
    "belief_cov",
    "bound_sd",
    "information_claimed",
    "information_true",
    "information_bound",
    "cost",
    "governor",
    "violation",
    "misfit",
    "settled",
)
_ZERO_AFTER_THE_END = {"cost", "governor"}


def play(
    agent: Any,
    *,
    patients: int | Sequence[Patient | Source | None],
    seed: int | Sequence[int],
    env_kwargs: Mapping[str, Any] | None = None,
    env_id: str = DEFAULT_ENV,
    progress: Callable[[int, int], None] | None = None,
    on_step: OnStep | None = None,
    agent_seed: int = 0,
) -> Recording:
    """Play one episode of an agent with every patient, all at the same time.

    Args:
        agent: anything with stable-baselines3's `predict(observation, state, episode_start, deterministic)`;
            `reset(num_envs, seed)` is called first where the agent has one, and then `attach(env)`
            (`jawenv.playing.agents.introduce`).
        patients: how many to draw from the environment's cohort (world i by the seed `seed + i`), or the
            patients: each a `Patient`, a mapping of its fields, the path of a file, or None to draw one.
        seed: of patients and noise; of the first world, 0 to 2**32 - 1, or one for each, 0 to 2**63 - 1.
        env_kwargs: arguments of the environment; the bound is tracked unless `track_bound` says otherwise, `info` is
            full, and `control` is that of the agent if it has an attribute of this name.
        env_id: a registered environment of jawenv; where it has no native vector form, single ones are stepped.
        progress: called with (steps done, steps of the longest episode) after every control step.
        on_step: called with the environment and the actions (N, 4) before every control step, and at the end with None
            in place of actions; it reads the environment, and changes nothing.
        agent_seed: another number makes other draws of an agent that draws. Its `reset` gets `agents.own_seed` of this,
            and nothing of `seed`, by which it could make its patients.

    Returns:
        The recording of all worlds. A world that ends early stays frozen while the others go on.

    Raises:
        InputError: an agent without `predict`, no patient, a seed out of range, another `control` than the agent's,
            or what the environment refuses.
    """
    if not callable(getattr(agent, "predict", None)):
        raise InputError(
            f"agent is {shown(agent)}; allowed: an object with "
            "predict(observation, state, episode_start, deterministic)"
        )
    number = _number_of(patients)
    seeds = _seeds_of(seed, number)
    if not isinstance(env_kwargs, Mapping | None):
        raise InputError(f"env_kwargs is {shown(env_kwargs)}; allowed: a mapping of the environment's arguments")
    kwargs = {"track_bound": True, **(env_kwargs or {})}
    kwargs.pop("info", None)
    if (control := control_of(agent, kwargs)) is not None:
        kwargs["control"] = control
    env = _worlds(env_id, number, kwargs)
    try:
        options = {"patients": list(patients)} if isinstance(patients, Sequence) else None
        observation, info = env.reset(seed=seeds, options=options)
        if hasattr(agent, "reset"):
            agent.reset(number, own_seed(agent_seed))
        introduce(agent, env)
        recording = _watch(agent, env, observation, info, progress, on_step or _ignore)
        if not env.unwrapped.configuration.record:
            return recording
        return replace(recording, records=tuple(_record(env, i) for i in range(number)))
    finally:
        env.close()


def _ignore(env: Any, action: Action | None) -> None:
    """Nobody watches."""


def _worlds(env_id: str, number: int, kwargs: Mapping[str, Any]) -> Any:
    """The native vector form of an environment, or single ones side by side where it has none."""
    import gymnasium as gym

    module, _, name = env_id.rpartition(":")
    if module:
        import_module(module)
    if gym.spec(name).vector_entry_point is None:
        from jawenv.playing.singles import SingleWorlds

        return SingleWorlds(env_id, number, kwargs)
    return gym.make_vec(env_id, num_envs=number, autoreset_mode="disabled", **kwargs)


def _record(env: Any, index: int) -> Record:
    """The record of one world's device."""
    from jawenv.playing.singles import SingleWorlds
    from jawenv.recordings.of_simulation import record_of

    if isinstance(env, SingleWorlds):
        return env.record(index)
    return record_of(env.unwrapped.simulation, index)


def _number_of(patients: object) -> int:
    """Number of patients that are asked for, by their number or by themselves."""
    if isinstance(patients, Sequence) and not isinstance(patients, str):
        number: int | None = len(patients)
    else:
        number = whole_number(patients)
    if number is None:
        raise InputError(f"patients is {shown(patients)}; allowed: a whole number, or a sequence of patients")
    if number < 1:
        raise InputError(f"patients is {number}; allowed: 1 or more")
    return number


def _seeds_of(seed: int | Sequence[int], number: int) -> list[int]:
    """The seed of each of so many worlds."""
    one = not isinstance(seed, Sequence) or isinstance(seed, str)
    values: Sequence[object] = [seed] if one else seed  # type: ignore[assignment]
    largest = LARGEST_SEED if one else LARGEST_OF_MANY
    seeds = [whole for whole in map(whole_number, values) if whole is not None and 0 <= whole <= largest]
    if len(seeds) < len(values):
        raise InputError(f"seed is {shown(seed)}; allowed: a whole number, 0 to {largest}")
    if one:
        return [seeds[0] + i for i in range(number)]
    if len(seeds) != number:
        raise InputError(f"seed is {len(seeds)}; allowed: one, or one for each of {number} patients")
    return seeds


def _watch(
    agent: Any,
    env: Any,
    observation: npt.NDArray[np.float32],
    info: dict[str, Any],
    progress: Callable[[int, int], None] | None,
    on_step: OnStep,
) -> Recording:
    """Step all worlds to their ends and keep what they tell."""
    number, configuration = env.num_envs, env.unwrapped.configuration
    steps = configuration.steps
    values = {key: np.empty((number, steps + 1, *np.shape(value)[1:])) for key, value in _tracked_values(info).items()}
    valid = np.zeros((number, steps + 1), dtype=bool)
    running, terminated = np.ones(number, dtype=bool), np.zeros(number, dtype=bool)
    starts: Mask = running.copy()
    state: Any = None
    _write_step(values, 0, info, running)
    valid[:, 0] = True
    for step in range(1, steps + 1):
        decision = agent.predict(observation, state=state, episode_start=starts, deterministic=True)
        action, state = checked_decision(decision, agent)
        on_step(env, action)
        observation, _, ended, cut_off, info = env.step(action)
        starts = np.zeros(number, dtype=bool)
        # A filter that has diverged has no belief to keep: its episode ended the step before.
        has_belief = running & np.isfinite(info["belief_cov"]).all(axis=(1, 2))
        _write_step(values, step, info, has_belief)
        valid[:, step] = has_belief
        terminated |= running & ended
        running &= ~(ended | cut_off)
        if progress is not None:
            progress(step, steps)
        if not running.any():
            break
    on_step(env, None)
    arrays: dict[str, Any] = {key: value[:, : step + 1] for key, value in values.items()}
    prior = env.unwrapped.prior
    return Recording(
        time=np.arange(step + 1) / configuration.steps_per_s,
        truth=np.array(info["truth"], dtype=np.float64),
        prior_mean=np.array(prior.mean, dtype=np.float64),
        prior_sd=np.array(prior.sd, dtype=np.float64),
        violation=arrays.pop("violation").astype(bool),
        settled=arrays.pop("settled").astype(bool),
        valid=valid[:, : step + 1],
        terminated=terminated,
        asked=np.repeat(info["asked"], 2, axis=1) if "asked" in info else np.ones(info["truth"].shape, dtype=bool),
        parameter_names=env.unwrapped.parameter_names,
        comfort_names=_comfort_names(),
        **arrays,
    )


def _comfort_names() -> tuple[str, ...]:
    from jawenv.device.comfort import COMFORT_LIMITS

    return COMFORT_LIMITS


def _tracked_values(info: dict[str, Any]) -> dict[str, Any]:
    """A recording's part of a vector environment's info, the comfort limits in the last axis."""
    untracked = {
        "bound_sd": np.full_like(info["belief_sd"], np.nan),
        "information_bound": np.full_like(info["nees"], np.nan),
    }
    comfort = np.stack([info[f"comfort_{name}"] for name in _comfort_names()], axis=-1)
    return {key: info[key] if key in info else untracked[key] for key in _TRACKED} | {"comfort": comfort}


def _write_step(values: dict[str, Array], step: int, info: dict[str, Any], has_belief: Mask) -> None:
    """Write one step; a world that has ended keeps its last values, at no cost and with nothing to govern."""
    for key, value in _tracked_values(info).items():
        values[key][:, step] = value
        if step > 0:
            ended = 0.0 if key in _ZERO_AFTER_THE_END else values[key][~has_belief, step - 1]
            values[key][~has_belief, step] = ended
