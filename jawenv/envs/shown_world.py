"""The scene that the renderer draws of one of the worlds: the true motion, and what is believed about it."""

from __future__ import annotations

from typing import Any

import numpy as np

from jawenv.device.comfort import COMFORT_LIMITS, OPENING, excursions
from jawenv.device.device import TICK
from jawenv.envs.info import WorldReader
from jawenv.envs.simulation import Simulation
from jawenv.mechanics.forces import muscle_pull
from jawenv.mechanics.kinematics import contact_point, rotation, split


def build_scene(simulation: Simulation, title: str | None = None, index: int = 0) -> Any:
    """Scene of world ``index``, for the renderer; model, cohort and control mode are its title by default."""
    from jawenv.rendering.scene import Scene

    world, configuration = simulation.worlds[index], simulation.configuration
    truth, known = world["truth"], world["known"]
    one = slice(index, index + 1)
    jaw = truth["jaw"]
    info = WorldReader(simulation.worlds[one], simulation.keys[one], configuration.needs_bound).first()
    q, _ = split(truth["state"])
    contact, body_to_head = np.array(contact_point(jaw, q)), np.array(rotation(q))
    contact[2] += truth["lift"][0]
    mouthpiece = contact + body_to_head @ jaw["mouthpiece"]
    muscles = truth["muscles"]
    tensions = [muscle_pull(jaw, muscles, i, tuple(contact), rotation(q))[3] for i in range(len(muscles))]
    names, limits = simulation.cohort.muscles.names, known["limits"]
    _, side, fore_aft = excursions(limits, jaw, tuple(mouthpiece))
    rest_opening, painless = float(limits["rest_opening"]), float(limits["opening"])
    return Scene(
        muscle_names=tuple(names[i] for i in jaw["muscle"]),
        muscle_origin_m=jaw["origin"].copy(),
        muscle_insertion_m=contact + jaw["insertion"] @ body_to_head.T,
        muscle_tension_N=np.array(tensions),
        contact_m=contact,
        rotation=body_to_head,
        plant=simulation.model.plant,
        slides=simulation.model.free[0],
        condyle_half_width_m=float(jaw["condyle_half_width"]),
        fossa_drop_m=float(jaw["fossa_drop"]),
        fossa_frequency=float(jaw["fossa_frequency"]),
        mouthpiece_m=mouthpiece,
        mouthpiece_force_N=body_to_head @ known["reading"][:3],
        parameter_names=simulation.parameter_names,
        belief_mean=info["belief_mean"],
        belief_cov=info["belief_cov"],
        prior_mean=np.asarray(simulation.cohort.prior.mean),
        prior_sd=np.asarray(simulation.cohort.prior.sd),
        truth=info["truth"],
        comfort={name: info[f"comfort_{name}"] for name in COMFORT_LIMITS if _can_be_used(name, simulation)},
        comfort_hard=dict(zip(COMFORT_LIMITS, limits["hard"].tolist(), strict=True)),
        governor=min(info["governor"], 1.0),  # a sum of shares of ticks, which rounds
        time_s=float(known["tick"]) * TICK,
        episode_s=configuration.episode_s,
        opening_mm=float(jaw["mouthpiece"][2] - mouthpiece[2]) * 1e3,
        opening_limits_mm=1e3 * (rest_opening + painless * np.array([1.0, limits["hard"][OPENING]])),
        excursion_mm=1e3 * np.array([side, fore_aft]),
        excursion_soft_mm=1e3 * np.array([limits["side"], limits["fore_aft"]]),
        information_nats=info["information_claimed"],
        title=title or f"{simulation.model.title}, {simulation.cohort.name} patient, {configuration.control} control",
    )


def moment_of(simulation: Simulation, index: int = 0) -> tuple[float, float, float, float]:
    """``Moment`` of world ``index``, as that of its scene."""
    world = simulation.worlds[index]
    truth, known = world["truth"], world["known"]
    jaw = truth["jaw"]
    q, _ = split(truth["state"])
    mouthpiece = np.array(contact_point(jaw, q)) + np.array(rotation(q)) @ jaw["mouthpiece"]
    mouthpiece[2] += truth["lift"][0]
    _, side, fore_aft = excursions(known["limits"], jaw, tuple(mouthpiece))
    opening = float(jaw["mouthpiece"][2] - mouthpiece[2])
    return float(known["tick"]) * TICK, 1e3 * opening, 1e3 * float(side), 1e3 * float(fore_aft)


def _can_be_used(limit: str, simulation: Simulation) -> bool:
    """Whether the model can move towards a comfort limit at all."""
    fore_aft, side, *_ = simulation.model.free
    return {"side": side, "condyle_side": side, "fore_aft": fore_aft, "condyle_fore_aft": fore_aft}.get(limit, True)
