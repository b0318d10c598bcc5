"""The single environment ``jawenv/Jaw-v0``."""

from __future__ import annotations

from typing import Any, Literal, cast

import gymnasium as gym
import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from jawenv.anatomy import Patient, Prior
from jawenv.device.device import N_MOTORS
from jawenv.envs.actions import checked_actions
from jawenv.envs.observation import OBSERVATION_BOUND
from jawenv.envs.rewards import potential
from jawenv.envs.scene import build_scene
from jawenv.envs.simulation import Simulation, configure
from jawenv.errors import InputError

Observation = NDArray[np.float32]
Action = NDArray[np.float32]
_ON = np.ones(1, dtype=np.bool_)


def observation_space(size: int) -> Any:
    """The flat observation of one world; ``observation_layout`` says what lies where."""
    return spaces.Box(-OBSERVATION_BOUND, OBSERVATION_BOUND, (size,), np.float32)


def action_space() -> Any:
    """One number in [-1, 1] for each motor."""
    return spaces.Box(-1.0, 1.0, (N_MOTORS,), np.float32)


def patient_of(value: Any) -> Patient:
    """A patient from reset options: a ``Patient`` or a mapping of its fields."""
    return value if isinstance(value, Patient) else Patient.from_dict(value)


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
    is the rate of its target position, which a stiff servo follows.

    ## Observation Space
    ``Box(-10, 10, (63,), float32)``: belief (mean, sd), filtered motion, excursions, load cell, motors, comfort
    margins, time left; see ``jawenv.envs.observation.OBSERVATION_LAYOUT``. It never contains the truth.

    ## Rewards
    ``"uncertainty"``: nats of information that the filter claims to have gained in this step. ``"bound"``: the same for
    the posterior Cramer-Rao bound. ``"score"``: gain of the log posterior density at the truth. From each,
    ``comfort_weight`` times the integral of the cost over the step (s) is taken.

    ## Starting State
    A patient drawn from ``cohort``, or ``options={"patient": Patient(...)}``, relaxed, at rest. The filter starts from
    the cohort's prior.

    ## Episode End
    Terminated when a hard comfort limit is crossed in spite of the device's governor, or when the filter's covariance
    is no longer positive definite. Truncated after ``episode_s``.

    ## Arguments
    ``control`` "force" | "trajectory"; ``sensors`` "pose" | "point"; ``reward``; ``cohort``; ``episode_s`` (30);
    ``control_hz`` (20); ``comfort_weight`` (0); ``track_bound`` (False: compute the bound for ``info`` as well);
    ``device`` (mapping of fields of ``jawenv.device.Device``); ``render_mode``.

    With ``sensors="point"`` the filter's claims are not calibrated: three coordinates do not determine five motions.

    ## Version History
    * v0: first version.
    """

    metadata: dict[str, Any] = {"render_modes": ["human", "rgb_array"], "render_fps": 20}

    def __init__(self, *, render_mode: str | None = None, **arguments: Any) -> None:
        """Check the arguments and allocate one world.

        Raises:
            InputError: an argument is unknown or has a value that is not allowed.
        """
        if render_mode is not None and render_mode not in self.metadata["render_modes"]:
            raise InputError(f"render_mode is {render_mode!r}; allowed: {', '.join(self.metadata['render_modes'])}")
        self.configuration = configure(arguments)
        self.render_mode = render_mode
        self.simulation = Simulation(1, self.configuration)
        self.observation_space: spaces.Space[Observation] = observation_space(self.simulation.observation.shape[1])
        self.action_space: spaces.Space[Action] = action_space()
        self.metadata = {**self.metadata, "render_fps": self.configuration.control_hz}
        self._seeded = False
        self._potential = 0.0
        self._renderer: Any = None

    @property
    def prior(self) -> Prior:
        """The filter's prior over the log-parameters."""
        return self.simulation.cohort.prior

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Start an episode; ``options={"patient": ...}`` takes a ``Patient`` or a mapping of its fields.

        Raises:
            InputError: an option is unknown, or the patient is not usable.
        """
        super().reset(seed=seed)
        for name in options or {}:
            if name != "patient":
                raise InputError(f"option {name!r} is unknown; allowed: patient")
        if seed is not None or not self._seeded:
            self.simulation.seed_world(0, self.np_random)
            self._seeded = True
        given = (options or {}).get("patient")
        self.simulation.reset(_ON, [None if given is None else patient_of(given)])
        self._potential = float(potential(self.configuration.reward, self.simulation.worlds)[0])
        if self._renderer is not None:
            self._renderer.reset()
        if self.render_mode == "human":
            self.render()
        return self.simulation.observation[0].copy(), self.simulation.info(self.simulation.worlds[0])

    def step(self, action: Action) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """One control period.

        Raises:
            InputError: the action has another shape than (4,), or a component that is no number in [-1, 1].
        """
        if not self._seeded:
            raise gym.error.ResetNeeded("call reset() before step()")
        checked = checked_actions(action, (N_MOTORS,))
        simulation, configuration = self.simulation, self.configuration
        simulation.advance(checked[None], _ON)
        world = simulation.worlds[0]
        now = float(potential(configuration.reward, simulation.worlds)[0])
        info = simulation.info(world)
        discomfort = configuration.comfort_weight * float(info["cost"]) / configuration.control_hz
        reward = now - self._potential - discomfort
        self._potential = now
        terminated = bool(info["violation"] or not np.isfinite(world["log_det"]))
        truncated = bool(world["tick"] >= configuration.steps * configuration.ticks_per_step)
        if self.render_mode == "human":
            self.render()
        return simulation.observation[0].copy(), reward, terminated, truncated, info

    def render(self) -> Any:
        """The frame (720, 1280, 3) as ``uint8`` for ``"rgb_array"``; shown in a window for ``"human"``."""
        if self.render_mode is None:
            gym.logger.warn("render() without render_mode; make the environment with render_mode='rgb_array'")
            return None
        if not self._seeded:
            raise gym.error.ResetNeeded("call reset() before render()")
        if self._renderer is None:
            from jawenv.envs.rendering.renderer import Renderer

            self._renderer = Renderer(
                cast(Literal["human", "rgb_array"], self.render_mode), self.configuration.control_hz
            )
        scene = build_scene(self.simulation)
        return self._renderer.draw(scene) if self.render_mode == "rgb_array" else self._renderer.show(scene)

    def close(self) -> None:
        """Close the window, if any."""
        if self._renderer is not None:
            self._renderer.close()
            self._renderer = None
