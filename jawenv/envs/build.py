"""Settings of a simulation's worlds by its configuration, and how much of an episode it keeps."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from jawenv.device.device import TICK
from jawenv.envs.configuration import Configuration
from jawenv.envs.world.record import settings_dtype
from jawenv.filter.settings import Geometry, fill_settings, noise_of, start_sd, used_readings, wrench_variances
from jawenv.filter.tick import LAST_WINDOW
from jawenv.kernels.records import record_zeros
from jawenv.mechanics.dynamics import N_WRENCH


def kept_ticks(configuration: Configuration) -> int:
    """Number of ticks kept of an episode: all if it is recorded or read again, or as many as the filter replays."""
    ticks = configuration.steps * configuration.ticks_per_step
    whole = configuration.record or configuration.own_estimator is not None
    return ticks if whole else min(ticks, LAST_WINDOW)


def kept_truths(configuration: Configuration) -> int:
    """Number of rows kept of the truth: of an episode to be recorded, of the bound's last period, or one."""
    if configuration.record:
        return kept_ticks(configuration) + 1
    return configuration.ticks_per_step + 1 if configuration.needs_bound else 1


def build_settings(
    configuration: Configuration, geometry: Geometry, sizes: tuple[int, int, int, int, int]
) -> NDArray[np.void]:
    """One record of dtype ``settings_dtype``, in an array.

    Args:
        configuration: of the environment.
        geometry: of its patients, as the filter knows them.
        sizes: arguments of ``settings_dtype``.
    """
    records = record_zeros(1, settings_dtype(*sizes))
    settings, device = records[0], configuration.build_device()
    noise = noise_of(device, configuration.force_sensor, TICK)
    settings["filter"]["motion_only"] = configuration.motion_only
    settings["filter"]["used"] = used_readings(configuration.sensors)
    fill_settings(records["filter"][0], geometry, noise, start_sd(geometry.jaw))
    settings["noise_variance"] = wrench_variances(device, configuration.force_sensor)
    settings["noise_variance"][:N_WRENCH] = settings["filter"]["wrench_variance"]
    settings["reality"] = configuration.build_reality().records()[0]
    settings["comfort"] = configuration.build_comfort().records()[0]
    _set_control(settings["control"], configuration)
    # How fast the true unknown wrench decays that lasts, where another time than the filter's is told.
    time = float(settings["reality"]["unmodelled_time"]) or noise.disturbance_time_s
    settings["unmodelled_decay"] = np.exp(-TICK / time) if time > 0.0 else 0.0
    settings["channels"] = int(settings["filter"]["used"].sum()) + N_WRENCH
    return records


def _set_control(control: Any, configuration: Configuration) -> None:
    """Fill a record of dtype ``Control``."""
    control["servo"] = configuration.mode.has_servos
    control["targets"] = configuration.mode.takes_targets
    control["budget"] = configuration.comfort_budget_s or 0.0
    control["steps"], control["ticks_per_step"] = configuration.steps, configuration.ticks_per_step
