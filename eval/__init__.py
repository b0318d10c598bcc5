"""Judging of maneuvers, agents and filters on simulated patients: ``python -m eval``.

Run it from a clone of the project; this package is not part of the installed library. A folder per job: `comparison`
(maneuvers and agents on the same patients), `studies` (the same as files, under many settings), `benchmark` (frozen
tasks), `calibration` (whether filters are honest), `information` (expected information gain), `patient` (a patient's
page), `dataset` (episodes as data sets), `thesis` (the results of Young 2016) and `report` (figures, tables and pages).
Beside them lies what these share: `commands`, `settings` (on whom and how is played), `entries` (what is played),
`kept` (work in parts that goes on where it was interrupted), `words` and `statistics` (intervals over patients).
"""
