"""Parts of a twin: the constants of an environment, and patients with their limits of comfort."""

from __future__ import annotations

from dataclasses import dataclass, fields
from math import pi
from typing import Any

import numpy as np
import torch
from torch import Tensor

from agents.twin import MODEL
from agents.twin.mechanics import Jaw
from agents.twin.nuisances import Nuisances
from jawenv.base.errors import InputError
from jawenv.device.channels import CHANNELS
from jawenv.device.comfort import (
    COMFORT_LIMITS,
    CONDYLE_FORE_AFT,
    CONDYLE_SIDE,
    FORE_AFT,
    GOVERNOR_ONSET,
    OPENING,
    SIDE,
    SPEED,
)
from jawenv.device.device import LAW_TICKS, TICK
from jawenv.device.guard import CREST_SHARE, DRIVERS, GUARDS, LOOK_AHEAD_S
from jawenv.ladder import title_of_env

STOPPED = (FORE_AFT, SIDE, OPENING, CONDYLE_FORE_AFT, CONDYLE_SIDE)
"""Limits with an end stop, in the order of ``Twin.onset``."""
LAWS_PER_DECISION = 2
"""Times that the device's law acts between two decisions; 4 in the environment. Acting once, it moves the jaw so
roughly that discomfort is four times too high."""
COST_SD = (0.02, 0.01, 0.034, 0.048, 0.058, 0.046, 0.42, 0.02)
"""Sds of the used fractions in the environment that the twin lacks, by limit; of the speed as a share of the shaking by
the unmodelled force alone. Half of the cost of a side or a fore-aft excursion is of its swing about the twin's.
Means of what `tests/agents/twin/agreement.py` fits on paths of policies; where it fits none, small."""
_DRIVES = [[float(channel in DRIVERS[limit]) for channel in CHANNELS] for limit in COMFORT_LIMITS]
_GUARD = [[GUARDS.get(limit, {}).get(channel, 0.0) for channel in CHANNELS] for limit in (*COMFORT_LIMITS, "crest")]


@dataclass(frozen=True)
class Patients:
    """P patients and their limits of comfort: tensors with P leading, named as ``jawenv.device.comfort.Limits``."""

    jaw: Jaw  # their anatomies
    theta: Tensor  # (P, 12) natural-log parameters
    rest: Tensor  # (P, 5) pose at rest
    rest_opening: Tensor
    opening: Tensor
    path: Tensor
    rest_side: Tensor
    side: Tensor
    fore_aft: Tensor
    condyle_middle: Tensor
    condyle_half: Tensor
    rest_condyle_side: Tensor
    end: Tensor
    tension: Tensor

    @classmethod
    def of_worlds(cls, worlds: Any) -> Patients:
        """The true patients of the worlds of a simulation, at rest after its ``reset``."""
        truth, limits = worlds["truth"], worlds["known"]["limits"]
        given = {"theta": truth["log_parameters"], "rest": truth["state"][:, :5]}
        given |= {name: limits[name] for name in cls.names()[2:]}
        tensors = {name: torch.tensor(np.asarray(value, dtype=np.float64)) for name, value in given.items()}
        return cls(Jaw.of(truth["jaw"]), **tensors)

    @classmethod
    def names(cls) -> list[str]:
        """Names of the tensors beside the jaw's."""
        return [field.name for field in fields(cls)[1:]]

    def tensors(self) -> dict[str, Tensor]:
        """The tensors beside the jaw's, by name."""
        return {name: getattr(self, name) for name in self.names()}

    def __len__(self) -> int:
        return len(self.theta)

    def __getitem__(self, chosen: Any) -> Patients:
        return Patients(self.jaw[chosen], **{name: value[chosen] for name, value in self.tensors().items()})


class Twin:
    """Constants of an environment: anatomy, device, comfort and the filter's noise.

    Args:
        simulation: of the environment.
    """

    def __init__(self, simulation: Any) -> None:
        if simulation.configuration.model != MODEL:
            title = title_of_env(simulation.configuration.env_id)
            raise InputError(f"env is {title!r}; allowed for the twin: 'Jaw' and 'JawImaged'")
        model, device, settings = simulation.models[0], simulation.device[0], simulation.settings[0]
        noise, comfort = settings["filter"], settings["comfort"]
        self.jaw = Jaw.of(model)
        self.arms, self.directions = torch.tensor(device["point"]), torch.tensor(device["direction"])
        self.servo, self.max_rate = float(device["servo_stiffness"]), float(device["max_rate"])
        self.reach = float(device["full_scale"]) / self.servo
        self.encoder_sd = torch.tensor(np.sqrt(noise["measurement_variance"][:6]))
        self.wrench_variance = torch.tensor(noise["wrench_variance"][:6])
        self.model_error, self.systematic_error = float(noise["model_error"]), float(noise["systematic_error"])
        self.first_ticks_count = bool(noise["full_weight_ticks"] > 0.0)
        self.nuisances = Nuisances.of(noise["nuisances"])
        # m/s that the unmodelled force gives the mouthpiece in a tick: so fast shakes a jaw that is held still.
        self.shaking = TICK * float(model["mouthpiece_mobility"]) * float(noise["wrench_variance"][0]) ** 0.5
        self.force, self.speed, self.condyle_side = (float(comfort[key]) for key in ("force", "speed", "condyle_side"))
        self.tension_margin = float(comfort["tension_margin"])
        self.cost_sd = torch.tensor(COST_SD, dtype=torch.float64)
        self.cost_sd[SPEED] *= self.shaking / self.speed
        self.hard, self.guard = torch.tensor(comfort["hard"]), torch.tensor(_GUARD, dtype=torch.float64)
        self.budget = float(settings["control"]["budget"])
        self.drives = torch.tensor(_DRIVES, dtype=torch.float64)
        self.lets_go = self.drives.clone()  # the same where motors let go, which they do not for speed
        self.lets_go[SPEED] = 0.0
        self.look_ahead_s = torch.tensor(list(LOOK_AHEAD_S.values()), dtype=torch.float64)
        self.onset = 1.0 + GOVERNOR_ONSET * (self.hard[list(STOPPED)] - 1.0)
        self.stop = float(device["stop_stiffness"])
        self.servo_damping = float(device["servo_damping"])
        self.sliding_damping, self.turning_damping = float(model["damping_sliding"]), float(model["damping_rotation"])
        self.crest = CREST_SHARE * pi / float(self.jaw.fossa_frequency)
        self.prior_mean, self.prior_sd = torch.tensor(noise["prior_mean"]), torch.tensor(noise["prior_sd"])
        self.gain_sd = float(noise["gain_variance"]) ** 0.5
        self.decision_s: float = 1.0 / simulation.configuration.steps_per_s
        self.dt: float = self.decision_s / LAWS_PER_DECISION
        self.memory, self.disturbance_variance = 0.0, torch.zeros(6, dtype=torch.float64)
        if len(noise["disturbance_variance"]):
            decay = float(noise["disturbance_decay"])
            self.memory = decay ** (self.dt / TICK)
            self.disturbance_variance = torch.tensor(noise["disturbance_variance"] / (1.0 - decay**2))

    def gain(self, rate: float) -> float:
        """Gain of an error, 1/s, in steps of ``dt``: it falls as by the ``rate`` (1/s) of a law every 50 ms."""
        short: float = LAW_TICKS * TICK
        return float(1.0 - (1.0 - rate * short) ** (self.dt / short)) / self.dt
