"""Judging of maneuvers, agents and filters on simulated patients: ``python -m eval``.

Run it from a clone of the project; this package is not part of the installed library. A folder per job: `comparison`
(maneuvers and agents on the same patients), `studies` (the same as files, under many settings), `calibration` (whether
filters are honest), `thesis` (the results of Young 2016) and `report` (figures, tables, words and pages). Beside them
lies what these share: `cli` and `options` (commands), `settings` (on whom and how is played), `entries` (what is
played), `chunks` (work on all cores that goes on where it was interrupted), `cluster` (Ray), `tables` (files) and
`statistics` (intervals over patients).
"""
