"""A score's summary over the patients: a mapping that shows itself as a table."""

from __future__ import annotations

import math
from html import escape

_ROWS = {
    "patients": ("patients", "{:.0f}"),
    "worst_sd_median": ("worst sd, median", "{:.1%}"),
    "worst_sd_p90": ("worst sd, nine of ten patients below", "{:.1%}"),
    "time_to_0.1_median_s": ("all known to 10 % after, s, median", "{:.1f}"),
    "time_to_0.05_median_s": ("all known to 5 % after, s, median", "{:.1f}"),
    "rmse": ("root mean square error", "{:.1%}"),
    "identified": ("parameters identified", "{:.1f}"),
    "information_true": ("true information, nats", "{:.1f}"),
    "information_claimed": ("claimed information, nats", "{:.1f}"),
    "nees": ("NEES", "{:.1f}"),
    "inside_2_sigma": ("truth within two sds", "{:.0%}"),
    "discomfort_s": ("discomfort, s", "{:.3f}"),
    "violation_share": ("episodes that cross a hard limit", "{:.0%}"),
    "ringing_share": ("episodes in which the alarm rings", "{:.0%}"),
}
"""Key -> what a table calls it, and how it is written. Keys that are not here are in the mapping alone."""


class Summary(dict[str, float]):
    """Figures over the patients by name; printed, or shown in a notebook, a table of the main ones."""

    def __str__(self) -> str:
        rows = self._rows()
        width = max(len(words) for words, _ in rows)
        return "\n".join(f"{words:{width}s}  {value:>8s}" for words, value in rows)

    def _repr_html_(self) -> str:
        cells = (
            f"<tr><td style='text-align: left'>{escape(words)}</td><td>{value}</td></tr>"
            for words, value in self._rows()
        )
        return f"<table>{''.join(cells)}</table>"

    def _rows(self) -> list[tuple[str, str]]:
        return [(words, _written(self[key], form)) for key, (words, form) in _ROWS.items() if key in self]


def _written(value: float, form: str) -> str:
    if math.isnan(value):
        return "–"
    return form.format(value) if math.isfinite(value) else "never"
