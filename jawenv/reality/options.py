"""Effects beyond the thesis that act on the truth, and their strength."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri

from jawenv.anatomy.knowledge import Knowledge
from jawenv.base.files import instance_of
from jawenv.base.numeric_fields import NumericFields, number
from jawenv.kernels.records import record_dtype, record_zeros


class RealityRecord:
    """The effects, SI units."""

    reflex_gain: float
    reflex_latency: float
    reflex_lag: float
    guarding_gain: float
    guarding_onset: float
    creep_share: float
    creep_time: float
    creep_slow_share: float
    creep_slow_time: float
    straight_share: float
    swallow_force: float
    swallow_every: float
    articular_stiffness: float
    articular_onset: float
    articular_side_stiffness: float
    scar_stiffness: float
    other_muscles_force: float
    cell_bias_force: float
    cell_bias_moment: float
    play_position: float  # whole width of the dead band
    play_angle: float
    unmodelled_time: float
    lost_below: float  # standard normals below it lose a reading
    frozen_above: float  # above it repeat the last one


REALITY = record_dtype(RealityRecord)


@dataclass(frozen=True)
class Reality(NumericFields):
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
        guarding_gain: Muscles that are held against a stretch: stiffness that they add beyond ``guarding_onset``, with
            the reflex's lag, as a share of that of the closed jaw, F_o b / l_o. 0.5 to 2 for one who guards (G).
        guarding_onset: Strain above rest at which it begins: 0.1 is 7 mm of the default jaw's opening (G).
        creep_share: Share of the stretch above rest by which a muscle that is held long enough lengthens. Jaws of ten
            subjects that had been held 2 to 10 mm aside rested 0.7 to 1.8 mm off (Rugh et al. 1990, J Dent Res 69:470;
            M). Held 10 mm aside, a healthy jaw then rests 0.61 mm off for a share of 0.2 and 1.5 mm for 0.5, hence
            0.2 to 0.6 (D). The shift is about a third of the share, as only one side's muscles are stretched.
        creep_time_s: Time constant of that lengthening: the shift had no more to gain after 8 s, three of these (M/D).
        creep_slow_share, creep_slow_time_s: The same of a second element, which relaxes while a treatment lasts: 0.1 to
            0.3, 60 s (G: trismus is treated by minutes of stretch).
        straight_share: Share of each passive tension that follows a straight line in the muscle's length, through its
            tensions at l_o and at a strain of 0.2. 1 as in ArtiSynth's relaxed jaw (A); the filter's law has 0.
        swallow_N, swallow_every_s: Tension that each closing muscle adds for a second, as half a sine wave, and how
            often: people swallow once or twice a minute, at 30 to 60 s (M), the first time after half of that; 1 N (G).
        attachment_error: Errors of the filter's muscle attachments, in sds of the table of attachments: 1 when the
            filter knows the mean anatomy, 0.1 to 0.3 when it knows an image of the patient (M; the share G).
        fossa_error: Sd of the natural logs of the fossa's drop and spatial frequency; 0.1 spans with 2 sd about
            what published paths do, -30 to +20 % and -15 to +40 % (D).
        mass_error, inertia_error, damping_error: Relative sds of the mandible's mass, of its moments of inertia and of
            the damping of rotation and of sliding: 0.1, 0.1 and 0.2 (D, G, G; sources in `jawenv.Knowledge`).
        centre_of_mass_error_mm: Sd of each coordinate of its centre of mass: 1 to 6 mm (G).
        head_tilt_error_deg: Sd of the head's pitch: 3 degrees in a rest (G).
        closing_tone_error_N: Sd of the closers' tone, beside what the filter takes it for: 0.05 to 0.3 N (G).
        mouthpiece_error_mm: Sd of each coordinate of where mouthpiece and teeth are, seen from the condyles: 0.5 to 1
            mm (G).
        mouthpiece_error_deg: Sd of each angle in which it sits: 0.5 degrees (G).
        cell_error_deg: Sd of each angle between the axes of load cell and encoders: 0.2 to 1 degrees (G).
        articular_stiffness_N_m: Stiffness of the joint at the mouthpiece near the end of opening, reached at the end of
            the painless range. It rises towards the border of opening ('Craniomandibular stiffness toward maximum mouth
            opening in healthy subjects'; M), by how much in N/m was not found: 1000 to 5000, 2 to 10 N at the end of a
            painless range of 20 mm (G).
        articular_onset: Share of the painless range at which it begins (G).
        articular_side_stiffness_N_m: The same of ligaments and capsule aside, reached at the soft limit of side motion
            and begun at the same share of it: 500 to 3000 (G).
        scar_stiffness_N_m: Stiffness of a band of scar in the left cheek, slack until it is a tenth longer than with
            the jaw closed (`reality.joint`): 300 to 1500 (G).
        other_muscles_F_o_N: Passive tension with the jaw closed of each line of openers and lateral pterygoids: 0.1 to
            0.5 N, as the healthy closers' (G).
        cell_bias_N: Sd of the load cell's constant offset in an episode, each component of the force. Makers' accuracy
            of miniature cells is 0.05 to 0.25 % of 100 N with drift: 0.05 to 0.25 N (G).
        cell_bias_N_m: The same for the moments: 0.001 to 0.005 N m, those forces at 2 cm (G).
        encoder_play_mm: Width of the dead band (backlash) of each reading of position: 0.2 to 0.5 mm, linkage and
            mouthpiece on its gum (G).
        encoder_play_deg: The same for angles: 0.2 to 0.5 degrees, that play at 6 cm (G).
        unmodelled_time_s: Time constant of the memory of the unmodelled wrench, an Ornstein-Uhlenbeck process of the
            same sd; 0 for the one that the device has (G).
        lost_share: Share of the readings, of each encoder and each component of the load cell, that are lost (G).
        frozen_share: Share that repeat the last reading (G).
    """

    reflex_gain: float = number(0.0, 10.0, "1")
    reflex_latency_ms: float = number(9.0, 80.0, "ms")
    reflex_lag_ms: float = number(40.0, 1000.0, "ms", zero=False)
    guarding_gain: float = number(0.0, 10.0, "1")
    guarding_onset: float = number(0.1, 1.0, "1")
    creep_share: float = number(0.0, 0.9, "1")
    creep_time_s: float = number(2.7, 1e4, "s", zero=False)
    creep_slow_share: float = number(0.0, 0.9, "1")
    creep_slow_time_s: float = number(60.0, 1e4, "s", zero=False)
    straight_share: float = number(0.0, 1.0, "1")
    swallow_N: float = number(0.0, 20.0, "N", record="swallow_force")
    swallow_every_s: float = number(30.0, 1e4, "s", zero=False)
    attachment_error: float = number(0.0, 2.0, "1")
    fossa_error: float = number(0.0, 0.5, "1")
    mass_error: float = number(0.0, 0.2, "1")
    inertia_error: float = number(0.0, 0.2, "1")
    damping_error: float = number(0.0, 0.2, "1")
    centre_of_mass_error_mm: float = number(0.0, 20.0, "mm")
    head_tilt_error_deg: float = number(0.0, 20.0, "deg")
    closing_tone_error_N: float = number(0.0, 1.0, "N", record="closing_tone_error")
    mouthpiece_error_mm: float = number(0.0, 5.0, "mm", record="mouthpiece_error_place")
    mouthpiece_error_deg: float = number(0.0, 5.0, "deg", record="mouthpiece_error_angle")
    cell_error_deg: float = number(0.0, 5.0, "deg")
    articular_stiffness_N_m: float = number(0.0, 1e5, "N/m")
    articular_onset: float = number(0.8, 0.95, "1")
    articular_side_stiffness_N_m: float = number(0.0, 1e5, "N/m")
    scar_stiffness_N_m: float = number(0.0, 1e4, "N/m")
    other_muscles_F_o_N: float = number(0.0, 10.0, "N", record="other_muscles_force")
    cell_bias_N: float = number(0.0, 10.0, "N", record="cell_bias_force")
    cell_bias_N_m: float = number(0.0, 1.0, "N m", record="cell_bias_moment")
    encoder_play_mm: float = number(0.0, 10.0, "mm", record="play_position")
    encoder_play_deg: float = number(0.0, 10.0, "deg", record="play_angle")
    unmodelled_time_s: float = number(0.0, 100.0, "s")
    lost_share: float = number(0.0, 0.49, "1")
    frozen_share: float = number(0.0, 0.49, "1")

    @property
    def moves_geometry(self) -> bool:
        """Whether the true geometry differs from the filter's model."""
        return self.attachment_error > 0.0 or self.fossa_error > 0.0

    def untold(self) -> Knowledge:
        """Sds of body and mounting within which the truth is drawn, and of which the filter is not told."""
        sd = self.centre_of_mass_error_mm
        return Knowledge(
            mass=self.mass_error,
            inertia=self.inertia_error,
            damping=self.damping_error,
            centre_of_mass_x_mm=sd,
            centre_of_mass_y_mm=sd,
            centre_of_mass_z_mm=sd,
            head_tilt_deg=self.head_tilt_error_deg,
            closing_tone_N=self.closing_tone_error_N,
            mouthpiece_mm=self.mouthpiece_error_mm,
            mouthpiece_deg=self.mouthpiece_error_deg,
            cell_deg=self.cell_error_deg,
        )

    def records(self) -> NDArray[np.void]:
        """The options as an array of one record of dtype ``REALITY``, as the kernels read it, in SI units."""
        records = record_zeros(1, REALITY)
        self.fill(records)
        records["lost_below"] = ndtri(self.lost_share)
        records["frozen_above"] = -ndtri(self.frozen_share)
        return records


def check_reality(source: object) -> Reality:
    """The effects given as a ``Reality``, as a mapping of fields or as the path of a file; None is no effect."""
    return Reality() if source is None else instance_of(Reality, source, "reality")
