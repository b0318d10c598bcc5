"""The metrics by which maneuvers and agents are judged, each defined once.

`precision` says how well the parameters are known, `calibration` whether that claim can be believed,
`diagnosis` whether it would have led to the right decision, and `score` computes all of them for a recording.
"""

from jawenv.metrics.calibration import (
    alarm_rings,
    alarm_word,
    claimed_information,
    covered,
    log_density,
    nees,
    nees_band,
    true_information,
)
from jawenv.metrics.diagnosis import BLOCKED_B, CONFIDENCE, STIFF_F_O_N, Diagnosis, diagnose, whole_muscles_per_line
from jawenv.metrics.precision import identified, rmse, rmse_over_bound, time_to, worst_sd
from jawenv.metrics.score import TARGETS, Score, score

__all__ = [
    "BLOCKED_B",
    "CONFIDENCE",
    "STIFF_F_O_N",
    "TARGETS",
    "Diagnosis",
    "Score",
    "alarm_rings",
    "alarm_word",
    "claimed_information",
    "covered",
    "diagnose",
    "identified",
    "log_density",
    "nees",
    "nees_band",
    "rmse",
    "rmse_over_bound",
    "score",
    "time_to",
    "true_information",
    "whole_muscles_per_line",
    "worst_sd",
]
