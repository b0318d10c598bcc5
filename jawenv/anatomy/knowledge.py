"""Knowledge of a patient and of the device's mounting: one description for the truth and for the filter.

The truth of each episode is drawn from it, as a patient is drawn from a cohort. The filter has the nominal values and
the sds, as it has the cohort's prior.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType

from jawenv.base.errors import not_among
from jawenv.base.files import Source, instance_of
from jawenv.base.numeric_fields import NumericFields, number


@dataclass(frozen=True)
class Knowledge(NumericFields):
    """Sds of what the device does not know exactly; 0 by default, and all of them normal and independent.

    Grade M: measured, A: assumption of a published model, D: derived by computation, G: guess.

    Attributes:
        attachments: of each coordinate of each end of each muscle's line, in sds of the table of attachments: 0.1 with
            an image of the patient (M; the share G). The mean anatomy, 1, is not allowed: it loses the filter.
            ``l_o`` is the closed-jaw length of the true attachments, since F_o is the tension of the closed jaw.
        fossa: of drop and spatial frequency of the condyle's path, relative: 0.1 spans with 2 sd about what published
            paths do (D).
        mass: of the mandible with its soft tissue, relative. Published masses differ by a factor of two, those of one
            method by about a tenth (D).
        centre_of_mass_x_mm, centre_of_mass_y_mm, centre_of_mass_z_mm: of each coordinate (G).
        head_tilt_deg: of the head's pitch, and so of gravity: a head in a rest moves by a few degrees (G).
        closing_tone_N: of the closers' tone, the same in all (G).
        mouthpiece_mm: of each coordinate of where mouthpiece and teeth are, seen from the condyles. The encoders are
            zeroed with the teeth together, so that it shows as the jaw turns (0.5, G).
        mouthpiece_deg: of each angle in which the mouthpiece sits, by which the readings are turned (0.5, G).
        cell_offset_N: of the load cell's offset, each component of the force. Makers' accuracy of miniature cells is
            0.05 to 0.25 % of 100 N with drift; 0.1 after taring (G).
        cell_offset_N_m: the same of the moments (G).
        damping: of the damping of rotation and of sliding, relative: nothing of it was measured in vivo (G). With more
            the filter claims too much.
        inertia: of the moments of inertia about the centre of mass, relative (G). It is drawn and the filter takes no
            account of it: a column of it teaches nothing, and without one 0.1 is harmless.
        cell_deg: of each angle between the axes of load cell and encoders: 0 where they were aligned on a bench, 0.2
            to 1 where a cell was mounted by hand (G). The cell's gain is `Device.cell_gain`.
        wrench_N: of a smooth wrench that no muscle pulls and no load cell reads: five components (moments over 3 cm)
            times six shapes of the pose, each of the thirty by itself (`filter.nuisances.turned`). It stands for all
            that the other fields leave out, as a scar or a cell that drifts with the pose (0.1, G).
        axes_mm: of each coordinate of where the encoders' axes begin, half way between the condyles: a few mm where
            somebody felt for these (G).
    """

    attachments: float = number(0.0, 0.3, "1")
    fossa: float = number(0.0, 0.2, "1")
    mass: float = number(0.0, 0.2, "1")
    centre_of_mass_x_mm: float = number(0.0, 20.0, "mm")
    centre_of_mass_y_mm: float = number(0.0, 20.0, "mm")
    centre_of_mass_z_mm: float = number(0.0, 20.0, "mm")
    head_tilt_deg: float = number(0.0, 20.0, "deg")
    closing_tone_N: float = number(0.0, 1.0, "N", record="closing_tone")
    mouthpiece_mm: float = number(0.0, 5.0, "mm")
    mouthpiece_deg: float = number(0.0, 5.0, "deg")
    cell_offset_N: float = number(0.0, 2.0, "N", record="cell_offset_force")
    cell_offset_N_m: float = number(0.0, 0.1, "N m", record="cell_offset_moment")
    damping: float = number(0.0, 0.2, "1")
    inertia: float = number(0.0, 0.2, "1")
    cell_deg: float = number(0.0, 5.0, "deg")
    wrench_N: float = number(0.0, 10.0, "N")
    axes_mm: float = number(0.0, 10.0, "mm")

    @property
    def exact(self) -> bool:
        """Whether all is known exactly."""
        return self == Knowledge()


IMAGED = Knowledge(
    attachments=0.1,
    fossa=0.1,
    mass=0.1,
    centre_of_mass_x_mm=4.0,
    centre_of_mass_y_mm=1.0,
    centre_of_mass_z_mm=6.0,
    head_tilt_deg=3.0,
    closing_tone_N=0.05,
    mouthpiece_mm=0.5,
    mouthpiece_deg=0.5,
    cell_offset_N=0.1,
    cell_offset_N_m=0.002,
    damping=0.2,
)
BENCH = replace(IMAGED, wrench_N=0.1, axes_mm=0.02)
LEVELS: Mapping[str, Knowledge] = MappingProxyType({"exact": Knowledge(), "imaged": IMAGED, "bench": BENCH})
"""All known exactly; a scan of the patient, an impression and a tared cell; these and what nobody thought of."""


def knowledge(source: str | Knowledge | Source | None) -> Knowledge:
    """A ``Knowledge`` from the name of a level, itself, a mapping of its fields or the path of a file."""
    if source is None:
        return LEVELS["exact"]
    if isinstance(source, str) and "." not in source and "/" not in source:
        if source not in LEVELS:
            raise not_among("knowledge", source, LEVELS, " (imaged: from a scan), a mapping or a file")
        return LEVELS[source]
    return instance_of(Knowledge, source, "knowledge")
