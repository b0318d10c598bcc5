"""From a world to the scene that the renderer draws: the true motion, and what is believed about it."""

from __future__ import annotations

from typing import Any

import numpy as np

from jawenv.device.comfort import COMFORT_LIMITS, HARD
from jawenv.envs.plants import TICK
from jawenv.envs.simulation import Simulation
from jawenv.mechanics.forces import muscle_pull
from jawenv.mechanics.kinematics import contact_point, rotation, split


def build_scene(simulation: Simulation) -> Any:
    """Scene of the first world, for the renderer."""
    from jawenv.envs.rendering.scene import Scene

    world, configuration = simulation.worlds[0], simulation.configuration
    jaw, info = world["jaw"], simulation.info(world)
    q, _ = split(world["state"])
    contact, body_to_head = np.array(contact_point(jaw, q)), np.array(rotation(q))
    mouthpiece = contact + body_to_head @ jaw["mouthpiece"]
    muscles = world["muscles"]
    tensions = [muscle_pull(jaw, muscles, i, tuple(contact), rotation(q))[3] for i in range(len(muscles))]
    names = simulation.cohort.muscles.names
    return Scene(
        muscle_names=tuple(names[i] for i in jaw["muscle"]),
        muscle_origin_m=jaw["origin"].copy(),
        muscle_insertion_m=contact + jaw["insertion"] @ body_to_head.T,
        muscle_tension_N=np.array(tensions),
        contact_m=contact,
        rotation=body_to_head,
        fossa_drop_m=float(jaw["fossa_drop"]),
        fossa_frequency=float(jaw["fossa_frequency"]),
        mouthpiece_m=mouthpiece,
        mouthpiece_force_N=body_to_head @ world["reading"][:3],
        parameter_names=info["parameter_names"],
        belief_mean=info["belief_mean"],
        belief_sd=info["belief_sd"],
        prior_mean=np.asarray(simulation.cohort.prior.mean),
        prior_sd=np.asarray(simulation.cohort.prior.sd),
        truth=info["truth"],
        comfort={name: float(info["comfort"][name]) for name in COMFORT_LIMITS},
        comfort_hard=dict(zip(COMFORT_LIMITS, HARD, strict=True)),
        governor=float(info["governor"]),
        time_s=float(world["tick"]) * TICK,
        episode_s=configuration.episode_s,
        opening_mm=float(jaw["mouthpiece"][2] - mouthpiece[2]) * 1e3,
        information_nats=float(info["information_claimed"]),
        title=f"{simulation.model.title}, {configuration.cohort} patient, {configuration.control} control",
    )
