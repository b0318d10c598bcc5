"""Agents by the text that a user types: names, files, runs and modules."""

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

from jawenv.base.errors import InputError, not_among
from jawenv.base.named_objects import is_named
from jawenv.controls import DEFAULT_CONTROL, Control, control_of
from jawenv.envs.configuration import Configuration
from jawenv.ladder import model_of_env
from jawenv.playing.agents import Agent
from jawenv.playing.excitation import BASELINES
from jawenv.playing.maneuvers import maneuver_names
from jawenv.playing.maneuvers.maneuver import SUFFIXES
from jawenv.playing.policies.card import CARD, WEIGHTS, card_of, policy_folder
from jawenv.playing.policies.named import agent_names, in_control, named_agent, steps_per_s
from jawenv.playing.rollout import DEFAULT_ENV


def _clairvoyant(*, control: Control) -> Agent:
    from agents.clairvoyant import Clairvoyant

    return Clairvoyant(control=control)


PLANNERS: dict[str, Callable[..., Any]] = {"clairvoyant": _clairvoyant}
"""Name -> what makes it for a control mode."""


def shipped_names() -> tuple[str, ...]:
    """Every name that `load_agent` knows: maneuvers, policies, excitations and planners of the project."""
    return (*agent_names(), *PLANNERS)


def load_agent(
    spec: str | Path,
    *,
    control: Control = DEFAULT_CONTROL,
    control_hz: float | None = None,
    env_id: str = DEFAULT_ENV,
    trust: bool = False,
) -> Agent:
    """Find or load an agent.

    Args:
        spec: a maneuver's name (`maneuver_names()`), a policy's that comes with the project (`policy_names()`), a
            baseline's (`BASELINES`), a planner's (`PLANNERS`), a maneuver file, recorded actions (.safetensors), the
            folder of a training run or an exported policy, a stable-baselines3 checkpoint, or a class or function of
            one's own, as ``package.module:Name``, which gets control and control_hz if its signature takes them.
        control: control mode of the environment that the agent shall play.
        control_hz: control steps per second of that environment; None for its default.
        env_id: that environment, by its id or as `jawenv.ladder.model_of_env` takes it.
        trust: whether a stable-baselines3 checkpoint may be unpickled, which can run code.
    """
    path, model = Path(spec), model_of_env(env_id)
    if str(spec) in PLANNERS:
        planner: Agent = PLANNERS[str(spec)](control=control)
        return planner
    named = named_agent(spec, control, control_hz, env_id)
    if named is not None:
        return named
    if path.suffix == ".safetensors":
        from agents.replay import Replay

        return in_control(Replay.load(path), control, control_hz)
    if path.exists() or path.suffix == ".zip":
        from agents.policies import load_policy

        return in_control(load_policy(path, env_id=model.env_id, trust=trust), control, control_hz)
    if is_named(str(spec)):
        from agents.own import load_own

        own = load_own(str(spec), {"control": control, "control_hz": steps_per_s(control, control_hz)})
        control_of(own, {"control": control})
        return own
    if "/" in str(spec) or os.sep in str(spec):
        raise InputError(f"agent is '{spec}'; allowed: a file or folder that exists")
    raise not_among(
        "agent",
        str(spec),
        shipped_names(),
        f", a maneuver file ({', '.join(SUFFIXES)}), a run folder, a checkpoint .zip, an exported policy's folder, or "
        "package.module:Name of an agent of your own",
    )


def world_of(spec: str | Path) -> Configuration | None:
    """World of a policy's training; None if the spec is no policy. A checkpoint of a run counts as the run."""
    run = card_of(spec)
    if run is None:
        return None
    try:
        return run[1].environment.world()
    except InputError as error:
        raise InputError(f"{run[0] / CARD}: environment: {error}") from None


def files_of(spec: str | Path) -> tuple[Path, ...]:
    """The files that decide the actions of a spec's agent, beside those of the program.

    For an agent of one's own this is its module, without the module's imports.
    """
    path = Path(spec)
    if str(spec) in (*BASELINES, *PLANNERS, *maneuver_names()):
        return ()
    if (folder := policy_folder(spec)) is not None:
        return (folder / CARD, folder / WEIGHTS)
    if path.suffix in (*SUFFIXES, ".safetensors"):
        return (path,)
    if path.exists():
        run = card_of(path)
        return (path,) if run is None else (path, run[0] / CARD)
    from agents.own import source_of

    own = source_of(str(spec))
    return () if own is None else (own,)
