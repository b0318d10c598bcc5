"""Judging of maneuvers, agents and filters on simulated patients: ``python -m eval``.

Run it from a clone of the project; this package is not part of the installed library. One command, one module or
folder: `comparison` (maneuvers and agents on the same patients), `studies` (the same from files, under many settings),
`benchmark` (frozen tasks), `calibration` (honesty of filters), `information` (expected information gain), `patient` (a
patient's page, accuracy of diagnoses), `dataset` (episodes as data sets), `film`, `replays` (averaged targets) and
`thesis` (the results of Young 2016). `report` makes the page of a comparison. They share `commands` and `cli` (command
line), `settings` (patients and world), `entries` (players), `kept` (the engine: cells played in parts that survive an
interrupt), `rows` (columns of a patient), `statistics` (intervals over patients), `tables` and `words`.
"""
