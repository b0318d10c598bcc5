"""What is compared: every maneuver or trained run with the settings under which it is played."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from agents import registry
from agents.card import exported_place, read_card
from agents.planning import Planner
from agents.policies import TrainedPolicy, config_of_run
from agents.residual import ResidualPolicy
from jawenv.anatomy import anatomy_of
from jawenv.anatomy.knowledge import knowledge
from jawenv.controls import DEFAULT_CONTROL, mode_of
from jawenv.device.comfort_settings import comfort_of
from jawenv.device.device import device_of
from jawenv.errors import InputError
from jawenv.ladder import KNOWN_WITHIN_SDS
from jawenv.playing.protocol import Agent
from jawenv.playing.recording import Recording
from jawenv.playing.rollout import DEFAULT_ENV, play
from jawenv.reality import check_reality

if TYPE_CHECKING:
    from jawenv.anatomy import Patient
    from training.run.config import EnvConfig

_OWN_OF_A_RUN = ("control", "sensors", "control_hz")
_STUDYS_OWN = ("cohort", "episode_s", "force_sensor")
_WORLD: dict[str, Callable[[Any], object]] = {
    "device": device_of,
    "reality": check_reality,
    "knowledge": knowledge,
    "comfort": comfort_of,
    "anatomy": anatomy_of,
}
"""Arguments of which a note says only that those of the training were others, and what makes of them what they mean."""
_ALIKE = {DEFAULT_ENV, KNOWN_WITHIN_SDS}
"""Environments whose actions and observations mean the same."""
_DEFAULTS: dict[str, Any] = {
    "control": DEFAULT_CONTROL,
    "sensors": "pose",
    "cohort": "trismus",
    "episode_s": 30.0,
    "force_sensor": "cell",
}


@dataclass(frozen=True)
class Entry:
    """One row of a comparison.

    Attributes:
        label: unique within the study.
        spec: what the user typed: a maneuver's name, a file, the folder of a run or an exported policy, or an agent of
            one's own.
        env_id: the environment it is played in.
        env_kwargs: its arguments.
        note: in which settings it differs from those asked for; empty if in none.
        trained: whether it comes from a training run.
        planned: whether it is a planner.
        clairvoyant: whether it plans with the patient's true parameters, and so is a yardstick.
        replay_of: label of the entry whose averaged targets it replays; empty if of none.
        description: what it does, in a sentence; empty if unknown.
        agent: plays it.
    """

    label: str
    spec: str
    env_id: str
    env_kwargs: dict[str, Any]
    note: str
    trained: bool
    description: str
    agent: Agent = field(repr=False)
    planned: bool = False
    clairvoyant: bool = False
    replay_of: str = ""

    def play(
        self,
        patients: int | Sequence[Patient | None],
        seed: int,
        progress: Callable[[int, int], None] | None = None,
        **changes: Any,
    ) -> Recording:
        """Play one episode with each patient, as `jawenv.play`, by which every result of ``eval`` is made.

        Args:
            patients: how many, or whom.
            seed: of the first patient.
            progress: see `jawenv.play`.
            **changes: arguments of the environment in place of the entry's.
        """
        kwargs = self.env_kwargs | changes
        return play(self.agent, patients=patients, seed=seed, env_kwargs=kwargs, env_id=self.env_id, progress=progress)

    def about(self) -> dict[str, Any]:
        """All but the agent, for the results' metadata."""
        return {each.name: getattr(self, each.name) for each in fields(self) if each.name != "agent"}


def maneuver_names() -> tuple[str, ...]:
    """Every hand-made maneuver of the project, and the random policy as the floor."""
    return (*registry.names(), "random")


def env_of_runs(specs: Iterable[str]) -> str:
    """Id of the environment that the first trained run of some entries was trained in; the default if there is none.

    Raises:
        InputError: a run's configuration is damaged.
    """
    trained_in = (env_of_run(spec) for spec in specs)
    return next((own.id for own in trained_in if own is not None), DEFAULT_ENV)


def fits(trained_in: str, env_id: str) -> bool:
    """Whether what was trained in the environment of one id can be played in that of another."""
    return trained_in == env_id or {trained_in, env_id} <= _ALIKE


def load_entries(
    specs: Sequence[str],
    env_kwargs: dict[str, Any],
    env_id: str = DEFAULT_ENV,
    *,
    trust: bool = False,
    load: Callable[..., Agent] = registry.load_agent,
) -> list[Entry]:
    """Load every agent, with its own control mode and sensors where it was trained on others.

    Args:
        specs: maneuvers, files, runs, exported policies or agents of one's own; one named twice counts once.
        env_kwargs: settings asked for.
        env_id: the environment of the study.
        trust: whether checkpoints that lie in no run's folder may be unpickled, which can run code.
        load: makes the agents, as `agents.registry.load_agent`.

    Raises:
        InputError: an unknown maneuver, a checkpoint that needs trust, a damaged file or checkpoint, or a run that was
            trained in another environment.
    """
    entries = [_load(spec, env_kwargs, env_id, trust, load) for spec in dict.fromkeys(specs)]
    labels = [entry.label for entry in entries]
    return [
        entry if labels.count(entry.label) == 1 else replace(entry, label=f"{entry.label} ({entry.spec})")
        for entry in entries
    ]


def _load(spec: str, env_kwargs: dict[str, Any], env_id: str, trust: bool, load: Callable[..., Agent]) -> Entry:
    run = env_of_run(spec)
    if run is not None and not fits(run.id, env_id):
        raise InputError(
            f"{spec} was trained in {run.id}, but this comparison is in {env_id}: "
            "entries of one comparison have one environment"
        )
    trained_in = {} if run is None else _completed(run.kwargs)
    asked = _completed(env_kwargs)
    own = {key: trained_in[key] for key in _OWN_OF_A_RUN if trained_in.get(key, asked[key]) != asked[key]}
    notes = [f"played with {key} {value}" for key, value in own.items()]
    notes += [
        f"trained with {key} {trained_in[key]}" for key in _STUDYS_OWN if trained_in.get(key, asked[key]) != asked[key]
    ]
    if run is not None:
        notes += [f"trained with another {key}" for key in _WORLD if _differ(key, trained_in.get(key), asked.get(key))]
    settings = asked | own
    agent = load(spec, control=settings["control"], control_hz=settings["control_hz"], env_id=env_id, trust=trust)
    notes += [] if run is None or run.id == env_id else [f"trained in {run.id}"]
    maneuver = getattr(agent, "maneuver", None)
    return Entry(
        label=agent.name,
        spec=spec,
        env_id=env_id,
        env_kwargs=env_kwargs | own,
        note=", ".join(notes),
        trained=run is not None or isinstance(agent, TrainedPolicy | ResidualPolicy),
        description=getattr(maneuver or agent, "description", ""),
        agent=agent,
        planned=isinstance(agent, Planner),
        clairvoyant=isinstance(agent, Planner) and agent.plan.clairvoyant,
    )


def _differ(key: str, one: Any, other: Any) -> bool:
    """Whether two values of an argument of `_WORLD` mean something else; as they are, where a file of one has gone."""
    try:
        return _WORLD[key](one) != _WORLD[key](other)
    except InputError:
        return bool(one != other)


def _completed(env_kwargs: dict[str, Any]) -> dict[str, Any]:
    """Arguments of an environment with their defaults."""
    return _DEFAULTS | {"control_hz": mode_of(env_kwargs).steps_per_s} | env_kwargs


def env_of_run(spec: str) -> EnvConfig | None:
    """The environment that a run or an exported policy was trained in; None if `spec` is none of them.

    A checkpoint of a run counts as the run.

    Raises:
        InputError: a run's configuration, or a policy's card, is damaged.
    """
    if (place := exported_place(spec)) is not None:
        from training.run.config import EnvConfig

        trained_in = read_card(place).environment
        return EnvConfig(id=trained_in.id, kwargs=trained_in.kwargs())
    config_file = config_of_run(Path(spec))
    if config_file is None:
        return None
    from training.run.config import TrainingConfig

    return TrainingConfig.load(config_file).env
