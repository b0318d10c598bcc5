"""The patient's anatomy: attachments, muscles, mandible and fossa; patients, priors and cohorts."""

from jawenv.anatomy.attachments import Attachment, AttachmentRow, attachment, attachment_rows
from jawenv.anatomy.cohorts import COHORTS, Cohort, cohort
from jawenv.anatomy.mandible import Fossa, Mandible, default_fossa, default_mandible
from jawenv.anatomy.muscles import (
    MUSCLE_NAMES,
    PARAMETER_NAMES,
    PORTIONS,
    WHOLE_MUSCLES,
    MuscleSet,
    known_muscle_sets,
    midplane_muscles,
    muscle_set,
    parameter_names,
    two_sides,
)
from jawenv.anatomy.patient import Patient
from jawenv.anatomy.prior import Prior, Stiffness
from jawenv.anatomy.quantities import Quantity, load_quantities

__all__ = [
    "COHORTS",
    "MUSCLE_NAMES",
    "PARAMETER_NAMES",
    "PORTIONS",
    "WHOLE_MUSCLES",
    "Attachment",
    "AttachmentRow",
    "Cohort",
    "Fossa",
    "Mandible",
    "MuscleSet",
    "Patient",
    "Prior",
    "Quantity",
    "Stiffness",
    "attachment",
    "attachment_rows",
    "cohort",
    "default_fossa",
    "default_mandible",
    "known_muscle_sets",
    "load_quantities",
    "midplane_muscles",
    "muscle_set",
    "parameter_names",
    "two_sides",
]
