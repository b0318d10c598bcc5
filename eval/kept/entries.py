"""Entries of a study, maneuvers, runs and agents with their world, and the settings in which they play."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, fields, replace
from typing import TYPE_CHECKING, Any, Self

from agents import registry
from agents.registry import world_of
from jawenv.base.errors import InputError, shown
from jawenv.base.seeds import REPORTS
from jawenv.controls import DEFAULT_CONTROL
from jawenv.envs.configuration import Configuration
from jawenv.ladder import DEFAULT_ENV, KNOWN_WITHIN_SDS
from jawenv.playing.agents import Agent
from jawenv.playing.policies.card import OF_TRAINING
from jawenv.playing.recording import Recording
from jawenv.playing.rollout import LARGEST_SEED, OnStep, play

if TYPE_CHECKING:
    from jawenv.anatomy import Patient

_NAMED_IN_NOTES = ("cohort", "episode_s", "force_sensor")
"""Arguments with the training's value in a note; for others the note only says that they differ."""
_LEARNING = ("reward", "comfort_weight", "track_bound", "record", "model", "estimator")
"""Arguments that say nothing about a world as an agent meets it."""
_ALIKE = {DEFAULT_ENV, KNOWN_WITHIN_SDS}
"""Environments with the same meaning of actions and observations."""


@dataclass(frozen=True)
class Settings:
    """Patients and world of a comparison."""

    world: Configuration = Configuration()  # the environment and its arguments
    patients: int = 64  # how many, >= 1; patient i is drawn, and its noise made, by the seed `seed + i`
    seed: int = REPORTS[0].start  # of the first patient, 0 to 2**32 - 1

    def __post_init__(self) -> None:
        """Check the numbers."""
        if self.patients < 1:
            raise InputError(f"patients is {shown(self.patients)}; allowed: a whole number, 1 or more")
        if not 0 <= self.seed <= LARGEST_SEED:
            raise InputError(f"seed is {shown(self.seed)}; allowed: a whole number, 0 to {LARGEST_SEED}")

    @classmethod
    def of(cls, patients: int = 64, seed: int = REPORTS[0].start, **world: Any) -> Self:
        """Settings of ``env`` and arguments, as `Configuration.from_mapping` takes them."""
        return cls(Configuration.from_mapping(world), patients, seed)

    def to_mapping(self) -> dict[str, Any]:
        """All in plain values, as results keep it."""
        return {"patients": self.patients, "seed": self.seed, **self.world.to_mapping()}

    @property
    def seeds(self) -> range:
        """The seeds of patients and noise."""
        return range(self.seed, self.seed + self.patients)


@dataclass(frozen=True)
class Entry:
    """One row of a comparison."""

    label: str  # unique within the study
    spec: str
    """Text as typed: a maneuver's name, a file, the folder of a run or an exported policy, or an agent of one's own."""
    world: Configuration  # environment and arguments
    note: str  # in which settings it differs from those asked for; empty if in none
    trained: bool  # whether it comes from a training run
    description: str  # a sentence on its method; empty if unknown
    agent: Agent = field(repr=False)  # plays it
    planned: bool = False  # whether it is a planner
    clairvoyant: bool = False  # whether it plans with the patient's true parameters, and so is a yardstick
    replay_of: str = ""  # label of the entry with the replayed targets; empty if none
    agent_seed: int = 0  # of its own draws, see `jawenv.play`

    @property
    def env_id(self) -> str:
        """Gymnasium's id of its environment."""
        return self.world.env_id

    @property
    def env_kwargs(self) -> dict[str, Any]:
        """Arguments of its environment, in plain values."""
        return self.world.arguments

    def play(
        self,
        patients: int | Sequence[Patient | None],
        seed: int | Sequence[int],
        progress: Callable[[int, int], None] | None = None,
        on_step: OnStep | None = None,
        **changes: Any,
    ) -> Recording:
        """Play one episode with each patient, as `jawenv.play`, by which every result of ``eval`` is made.

        Args:
            patients: how many, or whom.
            seed: of the first patient, or one for each.
            progress: see `jawenv.play`.
            on_step: see `jawenv.play`.
            **changes: arguments of the environment in place of the entry's.
        """
        kwargs = self.env_kwargs | changes
        return play(
            self.agent,
            patients=patients,
            seed=seed,
            env_kwargs=kwargs,
            env_id=self.env_id,
            progress=progress,
            on_step=on_step,
            agent_seed=self.agent_seed,
        )

    def about(self) -> dict[str, Any]:
        """All but the agent, for the results' metadata."""
        beside = ("agent", "agent_seed", "world")
        own = {field.name: getattr(self, field.name) for field in fields(self) if field.name not in beside}
        return own | {"env_id": self.env_id, "env_kwargs": self.env_kwargs}


def env_of_runs(specs: Iterable[str]) -> str:
    """Id of the environment that the first trained run of some entries was trained in; the default if there is none."""
    trained_in = (world_of(spec) for spec in specs)
    return next((own.env_id for own in trained_in if own is not None), DEFAULT_ENV)


def fits(trained_in: Configuration, world: Configuration) -> bool:
    """Whether a policy trained in one world can be played in another: actions and observations mean the same."""
    ids = {trained_in.env_id, world.env_id}
    return (len(ids) == 1 or ids <= _ALIKE) and (trained_in.asked is None) == (world.asked is None)


def can_play(spec: str, world: Configuration) -> bool:
    """Whether a policy or a planner can be played in a world; of other agents it is not known before."""
    if spec in registry.PLANNERS:
        return bool(registry.PLANNERS[spec](control=DEFAULT_CONTROL).plays(world))
    trained_in = world_of(spec)
    return trained_in is None or fits(trained_in, world)


def load_entries(
    specs: Sequence[str],
    world: Configuration | None = None,
    *,
    trust: bool = False,
) -> list[Entry]:
    """Load every agent, with its own control mode and sensors where it was trained on others.

    Args:
        specs: maneuvers, files, runs, exported policies or agents of one's own; one named twice counts once.
        world: environment and arguments; the default environment by default.
        trust: whether stable-baselines3 checkpoints may be unpickled, which can run code.
    """
    entries = [load_entry(spec, world or Configuration(), trust=trust) for spec in dict.fromkeys(specs)]
    labels = [entry.label for entry in entries]
    return [
        entry if labels.count(entry.label) == 1 else replace(entry, label=f"{entry.label} ({entry.spec})")
        for entry in entries
    ]


def load_entry(spec: str, asked: Configuration, *, trust: bool = False) -> Entry:
    """Load one agent, as `load_entries`."""
    trained = world_of(spec)
    world, notes = (asked, []) if trained is None else _of_a_run(spec, trained, asked)
    agent = registry.load_agent(
        spec, control=world.control, control_hz=world.control_hz, env_id=world.env_id, trust=trust
    )
    maneuver, clairvoyant = (getattr(agent, name, None) for name in ("maneuver", "clairvoyant"))
    return Entry(
        label=agent.name,
        spec=spec,
        world=world,
        note=", ".join(notes),
        trained=trained is not None or getattr(agent, "is_trained", False) is True,
        description=getattr(maneuver or agent, "description", ""),
        agent=agent,
        planned=clairvoyant is not None,  # planners alone say whether they are
        clairvoyant=clairvoyant is True,
    )


def _of_a_run(spec: str, trained: Configuration, asked: Configuration) -> tuple[Configuration, list[str]]:
    """World of a trained run, and notes on its differences from the world asked for and from the training."""
    if not fits(trained, asked):
        raise InputError(
            f"{spec} was trained in {_env_in_words(trained)}, but this comparison is in {_env_in_words(asked)}: "
            "entries of one comparison have one environment"
        )
    # Arguments implied by an id need no note: the id names them.
    named = {*trained.arguments, *asked.arguments}
    other = [name for name in asked.differences(trained) if name not in _LEARNING and name in named | {"control_hz"}]
    own = {name: getattr(trained, name) for name in OF_TRAINING if name in other}
    notes = [f"played with {name} {value}" for name, value in own.items()]
    notes += [f"trained with {name} {_shown(trained, name)}" for name in _NAMED_IN_NOTES if name in other]
    notes += [f"trained with another {name}" for name in other if name not in (*OF_TRAINING, *_NAMED_IN_NOTES)]
    notes += [] if trained.env_id == asked.env_id else [f"trained in {trained.env_id}"]
    return replace(asked, **own), notes


def _env_in_words(world: Configuration) -> str:
    return world.env_id if world.asked is None else f"{world.env_id} with asked"


def _shown(world: Configuration, name: str) -> Any:
    return world.build_cohort().name if name == "cohort" else getattr(world, name)
