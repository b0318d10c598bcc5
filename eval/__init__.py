"""Comparison of maneuvers and agents on the same patients: ``python -m eval compare``.

Run it from a clone of the project; this package is not part of the installed library. Order of the files,
from the outside in: `cli` (commands), `compare` (a study from start to end), `entries` (what is compared, and
under which settings it is played), `results` (tables per patient and over time, and their files),
`statistics` (intervals over patients and paired differences), `table` (the terminal), `figures` (matplotlib,
also for notebooks), `verdict` (what the figures say, in plain words) and `report` (one HTML file).
`calibrate` asks whether filters are honest: `filters` (their names), `beliefs` (rows per patient and time) and
`honesty` (what they say in sum). `pool` spreads tasks over all cores.
"""
