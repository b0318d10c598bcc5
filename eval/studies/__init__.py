"""Studies that a paper can cite: ``python -m eval study FILE``.

A study is a file: what is played (`entries`), under which settings, on whom, by which metrics it is judged, and which
pairs are compared. `design` reads it, `grid` multiplies it out, `cells` plays what is missing and keeps it, as it does
for every other question of ``eval``, `estimates` says what the patients tell about all patients, and `tables` writes
that down. The files beside them come with the project.
"""
