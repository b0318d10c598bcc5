"""The native vector form of ``jawenv/Jaw-v3``: N worlds, one compiled call per step."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from gymnasium import error, logger
from gymnasium.utils.seeding import np_random
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from jawenv.anatomy import Patient, Prior
from jawenv.base.errors import InputError, shown
from jawenv.device.device import N_MOTORS
from jawenv.envs.argument_checks import action_space, checked_actions, observation_space
from jawenv.envs.configuration import configure
from jawenv.envs.episode_seeds import episode_keys
from jawenv.envs.info import with_masks
from jawenv.envs.rewards import potential
from jawenv.envs.simulation import Simulation
from jawenv.envs.vector_arguments import (
    checked_autoreset_mode,
    checked_num_envs,
    checked_seeds,
    checked_steps,
    enough_memory,
)

if TYPE_CHECKING:
    from jawenv.envs.pictures import WorldPictures

Batch = tuple[NDArray[np.float32], dict[str, Any]]
StepBatch = tuple[NDArray[np.float32], NDArray[np.float64], NDArray[np.bool_], NDArray[np.bool_], dict[str, Any]]


class JawVectorEnv(VectorEnv[NDArray[np.float32], NDArray[np.float32], NDArray[Any]]):
    """N independent worlds; world i equals the single environment with its seed bit for bit.

    Arguments are those of ``JawEnv``, and:

    Args:
        num_envs: N.
        autoreset_mode: "next_step" (the step after an episode's end resets that world, ignoring its action),
            "same_step" (the ending step resets; the last observation and info are in ``info["final_obs"]`` and
            ``info["final_info"]``), or "disabled" (a finished world stands still, with reward 0, until
            ``reset(options={"reset_mask": ...})``).

        max_episode_steps: steps after which episodes are truncated, where that is sooner than ``episode_s``; what
            Gymnasium's ``TimeLimit`` does for the single form.

    ``reset(seed=s)`` seeds world i with s + i. ``options`` may hold ``patients``, one ``Patient``, mapping, path of a
    file or None per world, ``reset_mask`` (N,) bool, and ``asked``, as the argument, for all worlds or one for each.
    """

    metadata: dict[str, Any] = {
        "render_modes": ["rgb_array"],
        "render_fps": 5,
        "autoreset_mode": AutoresetMode.NEXT_STEP,
    }

    def __init__(
        self,
        num_envs: int = 1,
        *,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        max_episode_steps: int | None = None,
        render_mode: str | None = None,
        **arguments: Any,
    ) -> None:
        """Check the arguments and allocate N worlds.

        Raises:
            UnknownArgumentError: an argument is unknown; both an ``InputError`` and a ``TypeError``.
            InputError: an argument has a value that is not allowed.
        """
        self.num_envs = checked_num_envs(num_envs)
        if render_mode not in (None, "rgb_array"):
            raise InputError(f"render_mode is {shown(render_mode)}; allowed in the vector form: rgb_array")
        self.autoreset_mode = checked_autoreset_mode(autoreset_mode)
        self.configuration = configure(arguments, type(self))
        fps = self.configuration.steps_per_s
        self.metadata = {**self.metadata, "render_fps": fps, "autoreset_mode": self.autoreset_mode}
        self.render_mode = render_mode
        with enough_memory(self.num_envs):
            self.simulation = Simulation(self.num_envs, self.configuration)
        self.single_observation_space = observation_space(self.simulation.observation.shape[1])
        self.single_action_space = action_space()
        self.observation_space = batch_space(self.single_observation_space, self.num_envs)
        self.action_space = batch_space(self.single_action_space, self.num_envs)
        steps = min(self.configuration.steps, checked_steps(max_episode_steps))
        self._last_tick = steps * self.configuration.ticks_per_step
        self._begun = False
        self._generators: list[np.random.Generator] = []
        self._seeds: tuple[int, ...] = ()
        self._potential = np.zeros(self.num_envs)
        self._done = np.zeros(self.num_envs, dtype=np.bool_)
        self._all = np.ones(self.num_envs, dtype=np.bool_)
        self._pictures: WorldPictures | None = None
        if render_mode == "rgb_array":
            from jawenv.envs.pictures import WorldPictures

            self._pictures = WorldPictures(self.simulation, fps)
        self.picture_title: tuple[str | None, ...] = (None,) * self.num_envs
        """The title above the pictures of each world; model, cohort and control mode where it is None."""

    @property
    def prior(self) -> Prior:
        """The filter's prior over the log-parameters."""
        return self.simulation.cohort.prior

    @property
    def parameter_names(self) -> tuple[str, ...]:
        """Names of the parameters, as ``log_F_o/masseter_left``, in the order of the belief."""
        return self.simulation.parameter_names

    @property
    def np_random(self) -> Any:
        """The random number generator of each world, a tuple of N, as in ``SyncVectorEnv``.

        Set to one generator, all worlds draw the keys of their coming episodes from it, in turn.
        """
        self._make_generators()
        return tuple(self._generators)

    @np_random.setter
    def np_random(self, value: np.random.Generator) -> None:
        self.set_generators([value] * self.num_envs)

    def set_generators(self, generators: Sequence[np.random.Generator]) -> None:
        """Give each world a generator of its own, (N,)."""
        self._generators, self._seeds = list(generators), (-1,) * self.num_envs

    @property
    def np_random_seed(self) -> Any:
        """The seed of each world's generator, a tuple of N; -1 where it is not known."""
        self._make_generators()
        return self._seeds

    def _make_generators(self) -> None:
        """Generators of seeds that are drawn, where none were given."""
        if not self._generators:
            generators, self._seeds = zip(*(np_random() for _ in range(self.num_envs)), strict=True)
            self._generators = list(generators)

    def reset(self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None) -> Batch:
        """Start episodes in all worlds, or in those of ``options["reset_mask"]``.

        A reset that raises leaves all worlds as they were.
        """
        chosen, again, asked = self._all, None, None
        patients: list[Patient | None] = [None] * self.num_envs
        if options is not None:
            from jawenv.envs import reset_options

            given = reset_options.checked_options(options, ("patients", "reset_mask", "episode_keys", "asked"))
            if given.get("reset_mask") is not None:
                chosen = reset_options.checked_mask(given["reset_mask"], self.num_envs)
            patients = reset_options.checked_patients(given.get("patients"), self.num_envs)
            again = reset_options.checked_keys(given.get("episode_keys"), (self.num_envs, 2), "episode_keys")
            asked = reset_options.checked_questions(given.get("asked"), self.num_envs, self.configuration)
        if not self._begun and not chosen.all():
            raise InputError("option reset_mask leaves worlds out of the first reset; allowed: all worlds")
        generators, seeds = self._reseeded(seed, chosen)
        self._begin(chosen, patients, generators, again, asked)
        self._generators, self._seeds, self._begun = generators, seeds, True
        if self._pictures is not None:
            self._pictures.note()
        return self.simulation.observation.copy(), with_masks(self.simulation.reader.all(), chosen.copy())

    def _reseeded(
        self, seed: int | Sequence[int | None] | None, chosen: NDArray[np.bool_]
    ) -> tuple[list[np.random.Generator], tuple[int, ...]]:
        """Generators and seeds of all worlds, where chosen world i got s + i of an integer s, or entry i of a sequence.

        A world that gets None keeps its generator.
        """
        checked = checked_seeds(seed, self.num_envs)
        self._make_generators()
        generators, seeds = list(self._generators), list(self._seeds)
        for i in np.flatnonzero(chosen).tolist():
            if checked[i] is not None:
                generators[i], seeds[i] = np_random(checked[i])
        return generators, tuple(seeds)

    def _begin(
        self,
        chosen: NDArray[np.bool_],
        patients: list[Patient | None],
        generators: Sequence[np.random.Generator],
        again: NDArray[np.uint64] | None = None,
        asked: Sequence[str | None] | None = None,
    ) -> None:
        with episode_keys(generators, chosen) as keys:
            self.simulation.reset(chosen, patients, keys if again is None else again, asked)
        now = potential(self.configuration.reward, self.simulation)
        self._potential[chosen] = now[chosen]
        self._done[chosen] = False

    def _begin_drawn(self, chosen: NDArray[np.bool_]) -> None:
        """Begin the next episodes of the worlds that have ended, with patients of the cohort."""
        self._begin(chosen, [None] * self.num_envs, self._generators)

    def step(self, actions: NDArray[np.float32]) -> StepBatch:
        """One control period of every world; ``actions`` (N, 4)."""
        if not self._begun:
            raise error.ResetNeeded("call reset() before step()")
        checked = checked_actions(actions, (self.num_envs, N_MOTORS))
        simulation, configuration = self.simulation, self.configuration
        if self.autoreset_mode == AutoresetMode.SAME_STEP and self._done.any():
            raise error.ResetNeeded("a world that was ended by hand must be reset")
        waiting = self._done.copy()
        simulation.advance(checked, ~waiting)
        known, now = simulation.worlds["known"], potential(configuration.reward, simulation)
        info = simulation.reader.all()
        discomfort = configuration.comfort_weight * simulation.cost_above_limit() / configuration.steps_per_s
        reward = now - self._potential - discomfort
        reward[waiting] = 0.0
        self._potential = now
        terminated = info["violation"] | ~np.isfinite(known["log_det"])
        truncated = known["tick"] >= self._last_tick
        if self.autoreset_mode == AutoresetMode.NEXT_STEP and waiting.any():
            terminated, truncated = terminated & ~waiting, truncated & ~waiting
            self._begin_drawn(waiting)
            info = simulation.reader.all()
        self._done = terminated | truncated
        if self.autoreset_mode == AutoresetMode.SAME_STEP and self._done.any():
            info = self._restart(info)
        else:
            info = with_masks(info, self._all.copy())
        if self._pictures is not None:
            self._pictures.note()
        return simulation.observation.copy(), reward, terminated, truncated, info

    def _restart(self, final_info: dict[str, Any]) -> dict[str, Any]:
        """Reset the worlds that are done; keep their last observation and info."""
        done = self._done.copy()
        last = np.full(self.num_envs, None, dtype=object)
        for i in np.flatnonzero(done):
            last[i] = self.simulation.observation[i].copy()
        self._begin_drawn(done)
        info = with_masks(self.simulation.reader.all(), self._all.copy())
        return info | {
            "final_obs": last,
            "_final_obs": done,
            "final_info": with_masks(final_info, done.copy()),
            "_final_info": done.copy(),
        }

    def render(self) -> tuple[NDArray[np.uint8], ...] | None:
        """A frame (height, width, 3) as ``uint8`` of each world, for ``render_mode="rgb_array"``.

        Frames are 1280 by 720 pixels of one world, 640 by 360 of up to 4, and 480 by 270 of more.
        """
        if self._pictures is None:
            logger.warn("render() without render_mode; make the environment with render_mode='rgb_array'")
            return None
        if not self._begun:
            raise error.ResetNeeded("call reset() before render()")
        return self._pictures.draw(self.picture_title)

    def call(self, name: str, *args: Any, **kwargs: Any) -> tuple[Any, ...]:
        """The pictures of all worlds, for "render", or an attribute of each, as in ``SyncVectorEnv``.

        Raises:
            UnknownAttributeError: worlds have no such attribute; both an ``InputError`` and an ``AttributeError``.
            InputError: arguments are given, which neither takes.
        """
        arguments = [*args, *kwargs]
        if arguments:
            raise InputError(f"call({shown(name)}) has the argument {shown(arguments[0])}; allowed: none")
        if name == "render":
            return self.render() or (None,) * self.num_envs
        from jawenv.envs.world_attributes import attribute_of_worlds

        return attribute_of_worlds(self, name)

    def get_attr(self, name: str) -> tuple[Any, ...]:
        """An attribute of each world, by its name in the single form.

        Raises:
            UnknownAttributeError: worlds have no such attribute.
        """
        from jawenv.envs.world_attributes import attribute_of_worlds

        return attribute_of_worlds(self, name)

    def set_attr(self, name: str, values: Any) -> None:
        """Set "np_random" or "picture_title" of each world: to an entry of a list or tuple, or all to one value.

        Raises:
            UnknownAttributeError: the attribute cannot be set.
            InputError: a list of another length than N, or a value that is not allowed.
        """
        from jawenv.envs.world_attributes import set_attribute_of_worlds

        set_attribute_of_worlds(self, name, values)

    def close_extras(self, **kwargs: Any) -> None:
        """Free the pictures."""
        if self._pictures is not None:
            self._pictures.close()
