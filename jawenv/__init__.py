"""jawenv: active identification of jaw-muscle stiffness as Gymnasium environments.

Importing the package registers the environments and compiles nothing; everything else is imported on first use.
"""

from __future__ import annotations

from importlib import import_module
from importlib.metadata import PackageNotFoundError, version
from typing import TYPE_CHECKING, Any

from jawenv.envs.registration import register_environments

if TYPE_CHECKING:
    from jawenv.analysis.bound import bound_along
    from jawenv.analysis.identifiability import identifiability
    from jawenv.anatomy import COHORTS, MUSCLE_NAMES, PARAMETER_NAMES, Cohort, Patient, cohort
    from jawenv.anatomy.description import Anatomy
    from jawenv.anatomy.knowledge import Knowledge
    from jawenv.answers.identify import identify
    from jawenv.base.errors import InputError
    from jawenv.device import Device
    from jawenv.device.comfort_settings import Comfort
    from jawenv.inference.information_gain import contrastive_bounds
    from jawenv.inference.likelihood import fisher_information, log_likelihood
    from jawenv.inference.patient_law import PatientLaw
    from jawenv.inference.simulations import Simulations, simulate
    from jawenv.inference.treatable import treatable
    from jawenv.mechanics.acceleration import acceleration
    from jawenv.mechanics.plant import Motion, PatientJaw, Plant
    from jawenv.metrics.score import score
    from jawenv.playing.maneuvers import Maneuver, Player, maneuver_names
    from jawenv.playing.rollout import information_bound, play
    from jawenv.recordings.online import OnlineFilter

_HOMES = {
    "Anatomy": "jawenv.anatomy.description",
    "COHORTS": "jawenv.anatomy",
    "Cohort": "jawenv.anatomy",
    "Comfort": "jawenv.device.comfort_settings",
    "Device": "jawenv.device",
    "InputError": "jawenv.base.errors",
    "Knowledge": "jawenv.anatomy.knowledge",
    "MUSCLE_NAMES": "jawenv.anatomy",
    "Maneuver": "jawenv.playing.maneuvers",
    "Motion": "jawenv.mechanics.plant",
    "OnlineFilter": "jawenv.recordings.online",
    "PARAMETER_NAMES": "jawenv.anatomy",
    "Patient": "jawenv.anatomy",
    "PatientJaw": "jawenv.mechanics.plant",
    "PatientLaw": "jawenv.inference.patient_law",
    "Plant": "jawenv.mechanics.plant",
    "Player": "jawenv.playing.maneuvers",
    "acceleration": "jawenv.mechanics.acceleration",
    "bound_along": "jawenv.analysis.bound",
    "cohort": "jawenv.anatomy",
    "contrastive_bounds": "jawenv.inference.information_gain",
    "fisher_information": "jawenv.inference.likelihood",
    "identifiability": "jawenv.analysis.identifiability",
    "identify": "jawenv.answers.identify",
    "information_bound": "jawenv.playing.rollout",
    "log_likelihood": "jawenv.inference.likelihood",
    "maneuver_names": "jawenv.playing.maneuvers",
    "play": "jawenv.playing.rollout",
    "Simulations": "jawenv.inference.simulations",
    "score": "jawenv.metrics",
    "simulate": "jawenv.inference.simulations",
    "treatable": "jawenv.inference.treatable",
}

try:
    __version__ = version("jawenv")
except PackageNotFoundError:  # run from a checkout that was never installed
    __version__ = "0+unknown"

__all__ = [
    "COHORTS",
    "MUSCLE_NAMES",
    "PARAMETER_NAMES",
    "Anatomy",
    "Cohort",
    "Comfort",
    "Device",
    "InputError",
    "Knowledge",
    "Maneuver",
    "Motion",
    "OnlineFilter",
    "Patient",
    "PatientJaw",
    "PatientLaw",
    "Plant",
    "Player",
    "Simulations",
    "acceleration",
    "bound_along",
    "cohort",
    "contrastive_bounds",
    "fisher_information",
    "identifiability",
    "identify",
    "information_bound",
    "log_likelihood",
    "maneuver_names",
    "play",
    "score",
    "simulate",
    "treatable",
]

register_environments()


def __getattr__(name: str) -> Any:
    """Import a public name on first use."""
    home = _HOMES.get(name)
    if home is None:
        raise AttributeError(f"module 'jawenv' has no attribute {name!r}")
    value = getattr(import_module(home), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    """Public names, imported or not."""
    return sorted([*globals(), *__all__])
