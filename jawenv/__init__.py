"""jawenv: active identification of jaw-muscle stiffness as Gymnasium environments.

Importing the package registers the environments and compiles nothing; everything else is imported on first use.
"""

from __future__ import annotations

from importlib import import_module
from importlib.metadata import PackageNotFoundError, version
from typing import TYPE_CHECKING, Any

from jawenv.envs.registration import register_environments

if TYPE_CHECKING:
    from jawenv.analysis.bound import bound_along as bound_along
    from jawenv.analysis.identifiability import identifiability as identifiability
    from jawenv.anatomy import COHORTS as COHORTS
    from jawenv.anatomy import MUSCLE_NAMES as MUSCLE_NAMES
    from jawenv.anatomy import PARAMETER_NAMES as PARAMETER_NAMES
    from jawenv.anatomy import Cohort as Cohort
    from jawenv.anatomy import Patient as Patient
    from jawenv.anatomy import cohort as cohort
    from jawenv.anatomy.description import Anatomy as Anatomy
    from jawenv.anatomy.knowledge import Knowledge as Knowledge
    from jawenv.answers.identify import identify as identify
    from jawenv.base.errors import InputError as InputError
    from jawenv.device import Device as Device
    from jawenv.device.comfort_settings import Comfort as Comfort
    from jawenv.inference.information_gain import contrastive_bounds as contrastive_bounds
    from jawenv.inference.likelihood import fisher_information as fisher_information
    from jawenv.inference.likelihood import log_likelihood as log_likelihood
    from jawenv.inference.patient_law import PatientLaw as PatientLaw
    from jawenv.inference.simulations import Simulations as Simulations
    from jawenv.inference.simulations import simulate as simulate
    from jawenv.inference.treatable import treatable as treatable
    from jawenv.mechanics.acceleration import acceleration as acceleration
    from jawenv.mechanics.plant import Motion as Motion
    from jawenv.mechanics.plant import PatientJaw as PatientJaw
    from jawenv.mechanics.plant import Plant as Plant
    from jawenv.metrics.comparison import compare as compare
    from jawenv.metrics.score import score as score
    from jawenv.playing.maneuvers import Maneuver as Maneuver
    from jawenv.playing.maneuvers import Player as Player
    from jawenv.playing.maneuvers import maneuver_names as maneuver_names
    from jawenv.playing.rollout import play as play
    from jawenv.recordings.online import OnlineFilter as OnlineFilter

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
    "compare": "jawenv.metrics.comparison",
    "contrastive_bounds": "jawenv.inference.information_gain",
    "fisher_information": "jawenv.inference.likelihood",
    "identifiability": "jawenv.analysis.identifiability",
    "identify": "jawenv.answers.identify",
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

__all__ = [*_HOMES]

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
