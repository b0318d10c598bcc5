"""Judging of maneuvers, agents and filters on simulated patients: ``python -m eval``.

Run it from a clone of the project; this package is not part of the installed library. Its questions, a folder each:
`comparison` (maneuvers and agents on the same patients), `studies` (the same from files, under many settings),
`benchmark` (frozen tasks), `calibration` (honesty of filters), `patient` (a patient's page),
`thesis` (the results of Young 2016) and `episodes` (films, data sets, replays). They share `kept` (the engine: entries
and settings, and cells of them played in parts that survive an interrupt), `rows` (columns of a patient), `figures`
(intervals over patients, words, tables), `report` (drawings and pages) and `commands` (the command line).

Outside of the clone's folder another distribution's package of this name comes first; ``PYTHONPATH=CLONE`` mends that.
"""
