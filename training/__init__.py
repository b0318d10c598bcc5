"""Training of agents on jawenv from the command line: ``python -m training train apg``.

Run it from a clone of the project; this package is not part of the installed library. README.md beside this file
says what it can do, and what each file is for.

Outside of the clone's folder another distribution's package of this name comes first; ``PYTHONPATH=CLONE`` mends that.
"""
