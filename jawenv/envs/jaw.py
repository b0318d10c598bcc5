"""The single environment ``jawenv/Jaw-v3``."""

from __future__ import annotations

from typing import Any, Literal, cast

import gymnasium as gym
import numpy as np
from gymnasium import spaces
from gymnasium.utils.seeding import np_random
from numpy.typing import NDArray

from jawenv.anatomy import Prior
from jawenv.base.errors import InputError, shown
from jawenv.envs.argument_checks import action_space, checked_action, observation_space
from jawenv.envs.configuration import configure, described
from jawenv.envs.episode_seeds import checked_seed, episode_keys
from jawenv.envs.rewards import potential
from jawenv.envs.simulation import Simulation

Observation = NDArray[np.float32]
Action = NDArray[np.float32]
_ON = np.ones(1, dtype=np.bool_)


class JawEnv(gym.Env[Observation, Action]):
    """Learn the stiffness of six closing muscles of a trismus patient by moving the jaw.

    ## Description
    A wearable device with four motors moves the mandible of a relaxed patient. Each closing muscle pulls with
    ``F = F_o exp(b (l - l_o) / l_o)``; a Kalman filter estimates the logarithms of all 12 F_o and b from the
    load cell and the encoders. One step is one command of the device; the reward is the uncertainty that went away.

    ## Action Space
    ``Box(-1, 1, (4,), float32)``: motors vertical left, vertical right (positive opens), horizontal left, horizontal
    right (positive pushes forward). With ``control="force"`` the action times ``full_scale_N`` of the device is the
    force that the motor is to exert on the mouthpiece; with ``control="trajectory"`` the action times ``max_rate_mm_s``
    is the rate of its target position, which a servo follows. With ``control="targets"`` the action is where the jaw is
    to be at the end of the step: opening (-1 shut, 1 the painless range), side, fore-aft force and roll, as fractions
    of this patient's comfort; the device's law and guard take it there.

    ## Observation Space
    ``Box(-10, 10, (63,), float32)``: belief (mean, sd), filtered motion, excursions, load cell, motors, comfort
    margins, time left; see ``jawenv.envs.observation.OBSERVATION_LAYOUT``. It never contains the truth. With ``asked``
    there are 7 more: the muscles asked for, and the discomfort of the episode so far.

    ## Rewards
    ``"uncertainty"``: nats of information that the filter claims to have gained in this step. ``"bound"``: the same for
    the posterior Cramer-Rao bound. ``"score"``: gain of the log posterior density at the truth. ``"worst"``: fall of
    the logarithm of nearly the largest sd, times the number of parameters. ``"mixed"``: mean of the first and this.
    From each, ``comfort_weight`` times the integral of the cost over the step (s) is taken, as far as that of the
    episode is above ``comfort_limit_s``. With ``asked``, ``"worst"`` is of the parameters of the muscles asked for.

    ## Starting State
    A patient drawn from ``cohort``, or ``options={"patient": ...}``: a ``jawenv.Patient``, a mapping of its fields or
    the path of a file; relaxed, at rest. The filter starts from the cohort's prior.

    ## Episode End
    Terminated when a hard comfort limit is crossed in spite of the device's governor, or when the filter's covariance
    is no longer positive definite. Truncated after ``episode_s``. A step after that warns and changes nothing: the same
    observation and flags, reward 0.

    ## Arguments
    {arguments}
    * ``render_mode``: None, "rgb_array" or "human".

    ``env.spec.to_json()`` takes names, numbers, mappings, paths as text, a ``Device``, ``Reality`` or ``Comfort``,
    which comes back as the mapping of its fields. It takes no ``Cohort`` (give it ``Cohort.to_dict()``), no
    ``pathlib.Path``, no NumPy scalar, no ``Anatomy`` and no estimator of one's own; pickle takes all forms. A path
    stands for the file as it is when the environment is made.

    With ``sensors="point"`` the filter's claims are not calibrated: three coordinates do not determine five motions.

    ## Version History
    * v3: patients as stiff as trismus is, a closing tone, a stronger device, comfort to 20 N; the filter's point of
      linearisation stays between replays, and its column of the cell's gain is the model's.
    * v2: targets control is the default.
    * v1: a gentler device (12 N/s, softer servos), a filter without corrections and with a gate; ``info["gated"]``.
    * v0: first version.
    """

    metadata: dict[str, Any] = {"render_modes": ["human", "rgb_array"], "render_fps": 20}

    def __init__(
        self,
        *,
        render_mode: str | None = None,
        **arguments: Any,
    ) -> None:
        """Check the arguments and allocate one world.

        Raises:
            UnknownArgumentError: an argument is unknown; both an ``InputError`` and a ``TypeError``.
            InputError: an argument has a value that is not allowed, or there is no display for "human".
        """
        if render_mode is not None and render_mode not in self.metadata["render_modes"]:
            modes = ", ".join(self.metadata["render_modes"])
            raise InputError(f"render_mode is {shown(render_mode)}; allowed: {modes}")
        self.configuration = configure(arguments, type(self))
        if render_mode == "human":
            from jawenv.base.display import check_window

            check_window("render_mode: 'human'", "use 'rgb_array', or SDL_VIDEODRIVER=dummy to draw unseen")
        self.render_mode = render_mode
        self.simulation = Simulation(1, self.configuration)
        self.observation_space: spaces.Space[Observation] = observation_space(self.simulation.observation.shape[1])
        self.action_space: spaces.Space[Action] = action_space()
        self.metadata = {**self.metadata, "render_fps": self.configuration.steps_per_s}
        self._begun = False
        self._potential = 0.0
        self._end: tuple[bool, bool] | None = None
        self._renderer: Any = None
        self.picture_title: str | None = None
        """The title above the pictures; model, cohort and control mode where it is None."""

    @property
    def prior(self) -> Prior:
        """The filter's prior over the log-parameters."""
        return self.simulation.cohort.prior

    @property
    def parameter_names(self) -> tuple[str, ...]:
        """Names of the parameters, as ``log_F_o/masseter_left``, in the order of the belief."""
        return self.simulation.parameter_names

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Start an episode, all of whose random numbers follow from one draw of ``np_random``.

        A reset that raises leaves the environment as it was.

        Args:
            seed: whole number, 0 or more, of a new ``np_random``; without one, the present ``np_random`` goes on.
            options: ``{"patient": ...}`` with a ``Patient``, a mapping of its fields or the path of a file;
                ``{"episode_key": ...}`` to begin the episode again whose ``info`` has it; ``{"asked": ...}`` as the
                argument, for this episode.
        """
        patient, again, asked = None, None, None
        if options is not None:
            from jawenv.envs.reset_options import checked_keys, checked_options, checked_patient, checked_questions

            given = checked_options(options, ("patient", "episode_key", "asked"))
            patient = checked_patient(given.get("patient"), "option patient")
            again = checked_keys(given.get("episode_key"), (2,), "episode_key")
            asked = checked_questions(given.get("asked"), 1, self.configuration)
        seed = checked_seed(seed)
        generator, number = (self.np_random, self.np_random_seed) if seed is None else np_random(seed)
        with episode_keys([generator], _ON) as keys:
            self.simulation.reset(_ON, [patient], keys if again is None else again[None], asked)
        self._np_random, self._np_random_seed = generator, number
        self._begun, self._end = True, None
        self._potential = float(potential(self.configuration.reward, self.simulation)[0])
        if self.render_mode is not None:
            self._renderer_made().reset()
            self._note()
        if self.render_mode == "human":
            self.render()
        return self.simulation.observation[0].copy(), self.simulation.reader.first()

    def step(self, action: Action) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """One control period. After the end of the episode it warns, and nothing moves any more."""
        if not self._begun:
            raise gym.error.ResetNeeded("call reset() before step()")
        checked = checked_action(action)
        simulation, configuration = self.simulation, self.configuration
        if self._end is not None:
            gym.logger.warn("step() after the end of the episode does nothing; call reset()")
            return simulation.observation[0].copy(), 0.0, *self._end, simulation.reader.first()
        simulation.advance(checked, _ON)
        known = simulation.worlds[0]["known"]
        now = float(potential(configuration.reward, simulation)[0])
        info = simulation.reader.first()
        cost = float(simulation.cost_above_limit()[0])
        discomfort = configuration.comfort_weight * cost / configuration.steps_per_s
        reward = now - self._potential - discomfort
        self._potential = now
        terminated = bool(info["violation"] or not np.isfinite(known["log_det"]))
        truncated = bool(known["tick"] >= configuration.steps * configuration.ticks_per_step)
        if terminated or truncated:
            self._end = terminated, truncated
        self._note()
        if self.render_mode == "human":
            self.render()
        return simulation.observation[0].copy(), reward, terminated, truncated, info

    def render(self) -> Any:
        """The frame (720, 1280, 3) as ``uint8`` for ``"rgb_array"``; shown in a window for ``"human"``."""
        if self.render_mode is None:
            gym.logger.warn("render() without render_mode; make the environment with render_mode='rgb_array'")
            return None
        if not self._begun:
            raise gym.error.ResetNeeded("call reset() before render()")
        from jawenv.envs.shown_world import build_scene

        renderer, scene = self._renderer_made(), build_scene(self.simulation, self.picture_title)
        return renderer.draw(scene) if self.render_mode == "rgb_array" else renderer.show(scene)

    def _note(self) -> None:
        """Keep the moment for the picture's curves, where there is a picture."""
        if self._renderer is not None:
            from jawenv.envs.shown_world import moment_of

            self._renderer.note(moment_of(self.simulation))

    def _renderer_made(self) -> Any:
        """The renderer, which imports pygame when it first draws."""
        if self._renderer is None:
            from jawenv.rendering.renderer import Renderer

            mode = cast(Literal["human", "rgb_array"], self.render_mode)
            self._renderer = Renderer(mode, self.configuration.steps_per_s)
        return self._renderer

    def close(self) -> None:
        """Close the window, if any."""
        if self._renderer is not None:
            self._renderer.close()
            self._renderer = None


JawEnv.__doc__ = str(JawEnv.__doc__).replace("{arguments}", described().replace("\n", "\n    "))
