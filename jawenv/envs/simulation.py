"""N worlds that share one device, cohort and estimator: what both Gymnasium faces run on."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numba
import numpy as np
from numpy.typing import NDArray

from jawenv.anatomy import Patient
from jawenv.base.errors import InputError
from jawenv.device.device import N_MOTORS
from jawenv.device.force_sensor import (
    device_with_sensor,
    motor_errors,
    sds_of_sensor,
    slack_force,
)
from jawenv.envs.build import build_settings, kept_ticks, kept_truths
from jawenv.envs.configuration import Configuration
from jawenv.envs.info import WorldReader
from jawenv.envs.world.kept_ticks import true_tick_dtype
from jawenv.envs.world.record import world_dtype
from jawenv.envs.world.reset_kernel import begin, beginning_dtype
from jawenv.envs.world.step_kernel import Shared, StepRows, advance, scratch_dtype
from jawenv.filter.settings import Geometry
from jawenv.filter.tick import ROW
from jawenv.kernels.noise import Streams, philox
from jawenv.kernels.records import record_zeros
from jawenv.ladder import model_named
from jawenv.mechanics.building import build_jaw, gravity_in_head
from jawenv.mechanics.dynamics import N_STATES, N_WRENCH

if TYPE_CHECKING:
    from jawenv.envs.moved_plants import MovedJaw, MovedPlants
    from jawenv.envs.own_estimators import OwnEstimators
    from jawenv.filter.nuisances.unknowns import Values
    from jawenv.mechanics.plant import Plant

REDRAWS = 200
_FIRST_COUNTER: tuple[Any, Any, Any, Any] = (np.uint64(0), np.uint64(0), np.uint64(0), np.uint64(0))


class Simulation:
    """N worlds, advanced together by compiled code; world i depends on its own key and actions alone.

    Args:
        num_worlds: N.
        configuration: Checked arguments.
    """

    def __init__(self, num_worlds: int, configuration: Configuration) -> None:
        """Allocate the worlds; nothing is simulated before ``reset``."""
        self.configuration = configuration
        self.model = model_named(configuration.model)
        muscles, mandible = configuration.muscles, configuration.mandible
        self.cohort = configuration.build_cohort()
        device = configuration.build_device()
        self.device = device_with_sensor(configuration.force_sensor, device)
        self._motor_sds = sds_of_sensor(configuration.force_sensor, device)
        self._slack_below = slack_force(configuration.force_sensor, device)
        self.reality = configuration.build_reality()
        own_plant = configuration.own_plant
        self._jaw = build_jaw(muscles, mandible, configuration.fossa, free=self.model.free)
        self.knowledge = configuration.build_knowledge()
        with_memory = bool(self.device[0]["unmodelled_time"] > 0.0)
        self.nuisance_sds = self._directions(with_memory)
        """One sd of each nuisance that the filter integrates out, in its order."""
        disturbance = N_WRENCH if with_memory else 0
        sizes = len(muscles), len(muscles.muscle), N_STATES, len(self.nuisance_sds), disturbance
        parts = self._jaw, self.cohort.muscles, self.cohort.prior, self.knowledge, self.nuisance_sds, self._jaw
        self.settings = build_settings(configuration, Geometry(*parts, self.force_errors), sizes)
        self.worlds = record_zeros(num_worlds, world_dtype(*sizes))
        self.models = record_zeros(num_worlds, self._jaw.dtype)
        self._gravity = mandible.gravity
        config: Any = numba.config
        threads: int = config.NUMBA_NUM_THREADS  # the most that set_num_threads can ask for, now or later
        self.scratches = record_zeros(threads, scratch_dtype(*sizes))
        self._beginnings = record_zeros(threads, beginning_dtype(sizes[1]))
        self.ticks = record_zeros((num_worlds, kept_ticks(configuration) + 1), ROW)
        """(N, ticks) what was read, as far as it is kept."""
        self.paths = record_zeros((num_worlds, kept_truths(configuration)), true_tick_dtype(sizes[2]))
        """(N, ticks) what was true then, as far as it is kept."""
        self.observation = np.zeros((num_worlds, configuration.parts.size), dtype=np.float32)
        """(N, size) as of the last reset or step."""
        self.asked = np.ones((num_worlds, len(muscles)), dtype=np.bool_)
        """(N, M) the muscles that the present episodes ask for; all by default."""
        self.cost_so_far = np.zeros(num_worlds)
        """(N,) sum of the steps' costs since the episode began."""
        moved = own_plant is not None or self.model.plant == "contact"
        self.moved = self._moved_plants(own_plant, sizes) if moved else None
        """The true jaws, where Python moves them."""
        self._bound_scratches = self._scratches_of_bound(threads, sizes) if configuration.needs_bound else None
        self.keys = np.zeros((num_worlds, 2), dtype=np.uint64)
        """(N, 2) of all random numbers of the present episodes."""
        asked = None if configuration.asked is None else self.asked
        light, budget = configuration.info == "light", configuration.comfort_budget_s is not None
        own = configuration.own_estimator is not None
        self.reader = WorldReader(self.worlds, self.keys, configuration.needs_bound, light, asked, budget, own)
        self.own_estimators = None if configuration.own_estimator is None else self._own_estimators()
        """The user's estimators, where they are in the place of the device's filter."""

    def _directions(self, with_memory: bool) -> list[Values]:
        """One sd of each nuisance; none where all is known exactly."""
        if self.knowledge.exact and self._motor_sds is None:
            return []
        from jawenv.filter.nuisances.directions import directions

        about = self.cohort.muscles, self._jaw, self.cohort.typical, self._motor_sds
        return directions(self.knowledge, *about, with_memory=with_memory)

    def _own_estimators(self) -> OwnEstimators:
        from jawenv.envs.own_estimators import OwnEstimators

        return OwnEstimators(self.configuration.own_estimator, self)

    @staticmethod
    def _scratches_of_bound(threads: int, sizes: tuple[int, int, int, int, int]) -> NDArray[np.void]:
        from jawenv.filter.bound.bound_recursion import bound_scratch_dtype

        return record_zeros(threads, bound_scratch_dtype(*sizes))

    def _moved_plants(self, own: Plant | None, sizes: tuple[int, int, int, int, int]) -> MovedPlants:
        from jawenv.envs.moved_plants import HeldWrench, MovedPlants

        plant: MovedJaw
        if own is None:
            from jawenv.envs.sagittal_plant import SagittalPlant

            plant = SagittalPlant()
        else:
            plant = HeldWrench(own)
        muscles = self.cohort.muscles
        names = tuple(muscles.names[index] for index in muscles.muscle)
        shared = Shared(self.device, self.settings, record_zeros(len(self.worlds), scratch_dtype(*sizes)))
        rows = StepRows(self.ticks, self.paths, self.observation)
        return MovedPlants(plant, names, shared, self.models, self.worlds, rows)

    @property
    def _costs(self) -> NDArray[np.float64]:
        """(N, limits) costs of the last step."""
        costs: NDArray[np.float64] = self.worlds["truth"]["costs"]
        return costs

    @property
    def targets(self) -> NDArray[np.float64]:
        """(N, 4) where the device's law of targets control is, fractions of comfort; a copy."""
        targets: NDArray[np.float64] = self.worlds["known"]["tracker"]["target"].copy()
        return targets

    def reset(
        self,
        chosen: NDArray[np.bool_],
        patients: Sequence[Patient | None],
        keys: NDArray[np.uint64],
        asked: Sequence[str | None] | None = None,
    ) -> None:
        """Begin a new episode in every chosen world; where one cannot begin, all worlds stay as they were.

        Args:
            chosen: (N,) which worlds.
            patients: A patient per world, or None where one is to be drawn from the cohort.
            keys: (N, 2) of all random numbers of the episodes; only those of chosen worlds are read.
            asked: The muscles that each world asks for, or None for the configuration's.
        """
        numbers = np.flatnonzero(chosen)
        ticks = self.ticks[:, 0], self.paths[:, 0]
        of_episodes = self.asked, self.cost_so_far, self.keys
        arrays: tuple[NDArray[Any], ...] = (self.worlds, self.models, *of_episodes, self.observation, *ticks)
        before = [array[numbers] for array in arrays]
        plants = None if self.moved is None else self.moved.each
        try:
            self.keys[numbers] = keys[numbers]
            for i in numbers.tolist():
                question = (None if asked is None else asked[i]) or self.configuration.asked
                self.asked[i] = self._answers(question, keys[i])
            self.cost_so_far[numbers] = 0.0
            self._begin(chosen, patients, keys)
            self._read_first(chosen)
            if self.own_estimators is not None:
                self.own_estimators.begin(chosen)
            self._show_end(chosen)
        except BaseException:
            for array, values in zip(arrays, before, strict=True):
                array[numbers] = values
            if self.moved is not None and plants is not None:
                self.moved.each = plants
            raise

    def _answers(self, question: str | None, key: NDArray[np.uint64]) -> NDArray[np.bool_] | bool:
        """The muscles that a question asks for; all without one."""
        if question is None:
            return True
        from jawenv.envs.asked import asked_muscles

        return asked_muscles(question, self.cohort.muscles.names, key)

    def _begin(self, chosen: NDArray[np.bool_], patients: Sequence[Patient | None], keys: NDArray[np.uint64]) -> None:
        """Place and put at rest every chosen world, with another patient where a drawn one cannot be treated."""
        drawn: dict[int, Streams] = {}
        for i in np.flatnonzero(chosen):
            random_words = philox(tuple(keys[i]), _FIRST_COUNTER)
            self.worlds["truth"]["key"][i] = random_words[:2]
            drawn[int(i)] = Streams.of(np.array(random_words[2:], dtype=np.uint64))
            self._place(int(i), patients[int(i)], drawn[int(i)])
        waiting = chosen.copy()
        accepted = np.ones(len(chosen), dtype=np.bool_)
        for _ in range(REDRAWS):
            shared = Shared(self.device, self.settings, self.scratches)
            begin(shared, self.models, self.worlds, waiting, self._beginnings, accepted)
            waiting = waiting & ~accepted
            if not waiting.any():
                break
            for i in np.flatnonzero(waiting):
                patient = patients[int(i)]
                if patient is not None:
                    raise InputError(
                        f"patient {patient.name!r} has no rest pose within reach of the device, or a painless range "
                        "of less than 5 mm; allowed: a jaw that rests less than 35 mm open and 5 mm aside"
                    )
                self._place(int(i), None, drawn[int(i)])
        else:
            raise InputError(f"cohort {self.cohort.name!r}: {REDRAWS} patients in a row cannot be treated")

    def _place(self, index: int, patient: Patient | None, streams: Streams) -> None:
        """Write a patient, given or drawn, into a world and into what the filter knows of its geometry."""
        if patient is None:
            log_parameters, tilt, anatomy_seed = self.cohort.draw_log_parameters(streams.patient), 0.0, None
        else:
            names = self.cohort.muscles.names
            if patient.muscles != names:
                raise InputError(
                    f"patient {patient.name!r} has the muscles {', '.join(patient.muscles)}; "
                    f"allowed in {self.model.title}: {', '.join(names)}"
                )
            log_parameters, tilt = patient.log_parameters(), patient.head_tilt_deg
            anatomy_seed = patient.anatomy_seed
        self._jaw["gravity"] = gravity_in_head(self._gravity, tilt)
        self.models[index] = self._jaw
        truth = self.worlds["truth"][index]
        truth["jaw"], truth["log_parameters"] = self._jaw, log_parameters
        truth["no_cell"], truth["slack_below"] = self._motor_sds is not None, self._slack_below
        truth["friction_share"] = truth["motor_rate"] = 0.0  # at rest
        if self.knowledge.exact and self.reality.untold().exact and self._motor_sds is None:
            self._perturb_geometry(truth["jaw"], streams)
        else:
            self._draw_unknowns(truth, streams, anatomy_seed)

    def _perturb_geometry(self, jaw: Any, streams: Streams) -> None:
        """Let a true jaw's geometry differ from the filter's model, where the reality says so."""
        if self.reality.moves_geometry:
            from jawenv.reality.geometry import perturb_geometry

            perturb_geometry(self.reality, self.cohort.muscles, jaw, streams.geometry)

    def _draw_unknowns(self, truth: Any, streams: Streams, anatomy_seed: int | None) -> None:
        """Draw what is not known exactly into a world's truth."""
        from jawenv.envs.world.unknown_truth import draw_truth
        from jawenv.filter.nuisances.unknowns import MOTORS, along

        values = draw_truth(truth, self.knowledge, self.reality, self.cohort.muscles, streams, anatomy_seed)
        truth["nuisances"] = [along(values, sds) for sds in self.nuisance_sds]
        if self._motor_sds is not None:
            truth["motor_errors"] = motor_errors(self._motor_sds, values[MOTORS], self.device[0])

    def _read_first(self, chosen: NDArray[np.bool_]) -> None:
        """Read the sensors of the chosen worlds, whose episodes have begun, for the first time."""
        if self.moved is not None:
            self.moved.reset(chosen)
        else:
            self._advance_compiled(np.zeros((len(chosen), N_MOTORS)), chosen)
        self._track_bound(chosen)

    def advance(self, actions: NDArray[np.float64], active: NDArray[np.bool_]) -> None:
        """One control period of every active world with ``actions`` (N, 4) in [-1, 1]."""
        own = self.own_estimators
        if own is not None:
            own.before_step(active)
        if self.moved is not None:
            self.moved.advance(actions, active)
        else:
            self._advance_compiled(actions, active)
        self._track_bound(active)
        if own is not None:
            own.after_step(active)
        np.add(self.cost_so_far, self._costs.sum(axis=1), out=self.cost_so_far, where=active)
        self._show_end(active)

    def cost_above_limit(self) -> NDArray[np.float64]:
        """The cost (N,) of the last step, as far as the episode's discomfort is above ``comfort_limit_s``."""
        limit = self.configuration.comfort_limit_s * self.configuration.steps_per_s
        cost: NDArray[np.float64] = self._costs.sum(axis=1)
        return np.minimum(cost, np.maximum(self.cost_so_far - limit, 0.0))

    def _show_end(self, chosen: NDArray[np.bool_]) -> None:
        if self.configuration.asked is not None or self.configuration.comfort_budget_s is not None:
            from jawenv.envs.observation.optional import fill_optional_parts

            fill_optional_parts(self, chosen)

    def _advance_compiled(self, actions: NDArray[np.float64], active: NDArray[np.bool_]) -> None:
        shared = Shared(self.device, self.settings, self.scratches)
        rows = StepRows(self.ticks, self.paths, self.observation)
        advance(shared, self.models, self.worlds, actions, active, rows)

    def _track_bound(self, active: NDArray[np.bool_]) -> None:
        """The bound of the active worlds at the end of their control period, if it is asked for."""
        if self.configuration.needs_bound:
            from jawenv.envs.world.bound_kernel import track_bound

            track_bound(self.models, self.worlds, active, self.settings, self._bound_scratches, self.paths)

    @property
    def force_errors(self) -> tuple[NDArray[np.float64], Any] | None:
        """Sds of the motors' errors and the device's record where no load cell reads the force."""
        return None if self._motor_sds is None else (self._motor_sds, self.device[0])

    @property
    def parameter_names(self) -> tuple[str, ...]:
        """Names of the parameters, as ``log_F_o/masseter_left``, in the order of the belief."""
        return self.cohort.muscles.parameter_names
