"""Which effects beyond the thesis act on the truth, and how strongly."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from math import radians
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri

from jawenv.checks import real_number
from jawenv.errors import InputError, shown
from jawenv.files import instance_of, read_into
from jawenv.kernels.records import record_dtype, record_zeros

REALITY = record_dtype(
    [
        ("reflex_gain", "f8"),
        ("reflex_latency", "f8"),
        ("reflex_lag", "f8"),
        ("creep_share", "f8"),
        ("creep_time", "f8"),
        ("articular_stiffness", "f8"),
        ("articular_onset", "f8"),
        ("cell_bias_force", "f8"),
        ("cell_bias_moment", "f8"),
        ("play_position", "f8"),  # whole width of the dead band
        ("play_angle", "f8"),
        ("lost_below", "f8"),  # standard normals below it lose a reading
        ("frozen_above", "f8"),  # above it repeat the last one
    ],
)

# Lowest and highest value of each field, and whether the lowest is itself allowed.
ALLOWED = {
    "reflex_gain": (0.0, 10.0, True),
    "reflex_latency_ms": (0.0, 80.0, True),
    "reflex_lag_ms": (0.0, 1000.0, False),
    "creep_share": (0.0, 0.9, True),
    "creep_time_s": (0.0, 1e4, False),
    "attachment_error": (0.0, 2.0, True),
    "fossa_error": (0.0, 0.5, True),
    "articular_stiffness_N_m": (0.0, 1e5, True),
    "articular_onset": (0.0, 0.95, True),
    "cell_bias_N": (0.0, 10.0, True),
    "cell_bias_N_m": (0.0, 1.0, True),
    "encoder_play_mm": (0.0, 10.0, True),
    "encoder_play_deg": (0.0, 10.0, True),
    "lost_share": (0.0, 0.49, True),
    "frozen_share": (0.0, 0.49, True),
}


@dataclass(frozen=True)
class Reality:
    """Strengths of the effects, 0 (off) by default, and the constants that shape them.

    Grade M: measured, A: assumption of a published model, D: derived by computation, G: guess.

    Attributes:
        reflex_gain: Jaw-stretch reflex: stiffness that it adds in a stretch that is quick against ``reflex_lag_ms``, as
            a share of the passive one. 0 for a relaxed patient, whose reflexes are seldom and small (Miles et al. 2004,
            Hum Mov Sci 23:337); 0.5 to 1 for one who guards (G: no gain in N per mm was found).
        reflex_latency_ms: From stretch to the muscle's excitation, rounded to the control's tick, at least one. 8.9 ms
            after taps on the chin of ten subjects, 42 and 69 ms for the later responses ('Short- and long-latency
            responses in human masseter muscle evoked by chin taps'; M).
        reflex_lag_ms: Time constant from excitation to tension and back (G).
        creep_share: Share of the stretch above rest by which a muscle that is held long enough lengthens. Jaws of ten
            subjects that had been held 2 to 10 mm aside rested 0.7 to 1.8 mm off (Rugh et al. 1990, J Dent Res 69:470;
            M). Held 10 mm aside, the default jaw then rests 0.65 mm off for a share of 0.2 and 1.6 mm for 0.5, hence
            0.2 to 0.55 (D). The shift is about a third of the share, as only one side's muscles are stretched.
        creep_time_s: Time constant of that lengthening: the shift had no more to gain after 8 s, three of these (M/D).
        attachment_error: Errors of the filter's muscle attachments, in sds of the table of attachments: 1 when the
            filter knows the mean anatomy, 0.1 to 0.3 when it knows an image of the patient (M; the share G).
        fossa_error: Sd of the natural logs of the fossa's drop and spatial frequency; 0.1 spans with 2 sd about
            what published paths do, -30 to +20 % and -15 to +40 % (D).
        articular_stiffness_N_m: Stiffness of the joint at the mouthpiece near the end of opening, reached at the end of
            the painless range. It rises towards the border of opening ('Craniomandibular stiffness toward maximum mouth
            opening in healthy subjects'; M), by how much in N/m was not found: 1000 to 5000, 2 to 10 N at the end of a
            painless range of 20 mm (G).
        articular_onset: Share of the painless range at which it begins (G).
        cell_bias_N: Sd of the load cell's constant offset in an episode, each component of the force. Makers' accuracy
            of miniature cells is 0.05 to 0.25 % of 100 N with drift: 0.05 to 0.25 N (G).
        cell_bias_N_m: The same for the moments: 0.001 to 0.005 N m, those forces at 2 cm (G).
        encoder_play_mm: Width of the dead band (backlash) of each reading of position: 0.2 to 0.5 mm, linkage and
            mouthpiece on its gum (G).
        encoder_play_deg: The same for angles: 0.2 to 0.5 degrees, that play at 6 cm (G).
        lost_share: Share of the readings, of each encoder and each component of the load cell, that are lost (G).
        frozen_share: Share that repeat the last reading (G).
    """

    reflex_gain: float = 0.0
    reflex_latency_ms: float = 9.0
    reflex_lag_ms: float = 40.0
    creep_share: float = 0.0
    creep_time_s: float = 2.7
    attachment_error: float = 0.0
    fossa_error: float = 0.0
    articular_stiffness_N_m: float = 0.0
    articular_onset: float = 0.8
    cell_bias_N: float = 0.0
    cell_bias_N_m: float = 0.0
    encoder_play_mm: float = 0.0
    encoder_play_deg: float = 0.0
    lost_share: float = 0.0
    frozen_share: float = 0.0

    def __post_init__(self) -> None:
        """Check every field.

        Raises:
            InputError: a field is not a finite number or out of its range.
        """
        for name, (low, high, closed) in ALLOWED.items():
            value = getattr(self, name)
            number = real_number(value)
            if number is None or not low <= number <= high or (number == low and not closed):
                more = f"{low:g} or more" if closed else f"more than {low:g}"
                allowed = f"a finite number, {more}, at most {high:g}"
                raise InputError(f"reality.{name} is {shown(value)}; allowed: {allowed}")
            object.__setattr__(self, name, number)

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> Self:
        """The effects that a mapping names; the others are off.

        Raises:
            InputError: an unknown field, or a value that is not allowed.
        """
        for name in data:
            if name not in ALLOWED:
                raise InputError(f"reality.{name} is not a field of Reality; allowed: {', '.join(ALLOWED)}")
        return cls(**data)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Self:
        """The effects that a JSON, TOML or YAML file names.

        Raises:
            InputError: one line that names the file and what is wrong with it.
        """
        return read_into(path, cls.from_dict)

    def records(self) -> NDArray[np.void]:
        """The options as an array of one record of dtype ``REALITY``, as the kernels read it, in SI units."""
        records = record_zeros(1, REALITY)
        reality = records[0]
        reality["reflex_gain"] = self.reflex_gain
        reality["reflex_latency"] = self.reflex_latency_ms / 1e3
        reality["reflex_lag"] = self.reflex_lag_ms / 1e3
        reality["creep_share"] = self.creep_share
        reality["creep_time"] = self.creep_time_s
        reality["articular_stiffness"] = self.articular_stiffness_N_m
        reality["articular_onset"] = self.articular_onset
        reality["cell_bias_force"] = self.cell_bias_N
        reality["cell_bias_moment"] = self.cell_bias_N_m
        reality["play_position"] = self.encoder_play_mm / 1e3
        reality["play_angle"] = radians(self.encoder_play_deg)
        reality["lost_below"] = ndtri(self.lost_share)
        reality["frozen_above"] = -ndtri(self.frozen_share)
        return records


def check_reality(given: object) -> Reality:
    """The effects given as a ``Reality``, as a mapping of fields or as the path of a file; None is no effect.

    Raises:
        InputError: none of these, an unknown field, a value that is not allowed, or a file that cannot be read.
    """
    return Reality() if given is None else instance_of(Reality, given, "reality")
