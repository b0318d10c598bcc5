"""Ranges of seeds, each for one purpose, so that nothing is judged by patients on whom it was chosen.

Patient i of a cohort is drawn, and its noise made, by ``seed + i``.
"""

from __future__ import annotations

REPORTS = (range(0, 5_000), range(20_000, 30_000))
"""Results: the defaults of the commands, and all tables of the documentation. Nothing is chosen on these."""
TUNING = range(5_000, 20_000)
"""Choices made by hand or by a search: of the filter, of maneuvers, of an agent's settings."""
VALIDATION = range(30_000, 40_000)
"""Choices made during a training: which of an agent's policies is the best."""
REPLAYS = range(35_000, 40_000)
"""The part of ``VALIDATION`` over which an agent's targets are averaged, to be replayed on others."""
FILTER_TUNING = range(40_000, 50_000)
"""Choices of the filter: which of its forms is the more honest."""
BENCHMARK = range(50_000, 60_000)
"""The tasks of the benchmark: nothing else is played on these."""
TRAINING = range(2**31, 2**32)
"""Patients that agents learn on."""
