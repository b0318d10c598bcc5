"""Studies that a paper can cite: ``python -m eval study FILE``.

A study is a file: what is played (`entries`), under which settings, on whom, by which metrics it is judged, and which
pairs are compared. `design` reads it, `cells` multiplies it out, `run` plays what is missing and keeps it, `estimates`
says what the patients tell about all patients, and `tables` writes that down. The files beside them come with the
project.
"""
