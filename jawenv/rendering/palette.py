"""Every colour of the picture, and the two scales that carry meaning.

Knowledge runs from clay (only the prior) over sand and teal to deep blue (known to 1 %). Clay against blue
stays apart for all common forms of colour blindness. Saturated red is kept for crossed limits alone.
"""

from __future__ import annotations

import math

Colour = tuple[int, int, int]

PAGE: Colour = (243, 241, 236)
CARD: Colour = (255, 255, 255)
BORDER: Colour = (226, 222, 213)
GRID: Colour = (236, 233, 226)
TRACK: Colour = (238, 235, 229)
INK: Colour = (34, 42, 53)
SOFT_INK: Colour = (96, 104, 115)
FAINT_INK: Colour = (142, 148, 156)
ACCENT: Colour = (24, 92, 138)
SIDE_TRACE: Colour = (178, 132, 190)
SWING_TRACE: Colour = (214, 160, 100)

SKULL: Colour = (244, 240, 232)
SKULL_LINE: Colour = (222, 214, 199)
BONE_SHADOW: Colour = (158, 140, 112)
BONE_LIGHT: Colour = (252, 246, 231)
BONE_LINE: Colour = (112, 97, 74)
TOOTH_SHADOW: Colour = (176, 176, 172)
TOOTH_LIGHT: Colour = (255, 255, 252)
TOOTH_LINE: Colour = (146, 144, 136)
PLATE_SHADOW: Colour = (52, 66, 82)
PLATE_LIGHT: Colour = (128, 146, 166)
FOSSA: Colour = (122, 104, 78)

GOOD: Colour = (46, 139, 112)
WARN: Colour = (224, 155, 38)
ALARM: Colour = (204, 41, 48)

KNOWN_SD = 0.01
UNKNOWN_SD = 0.5
KNOWLEDGE: tuple[Colour, ...] = (
    (190, 94, 70),
    (214, 148, 88),
    (196, 184, 122),
    (92, 170, 158),
    (38, 122, 160),
    (18, 66, 118),
)

STIFFEST = 3.0
"""Times the stiffness limit at which the scale of stiffness ends; it begins at as small a fraction."""
STIFFNESS: tuple[Colour, ...] = (GOOD, (214, 200, 140), KNOWLEDGE[0])


def mix(first: Colour, second: Colour, share: float) -> Colour:
    """Blend two colours; `share` (0 to 1) is the second one's."""
    r, g, b = (round(a + (z - a) * share) for a, z in zip(first, second, strict=True))
    return (r, g, b)


def ramp(shadow: Colour, light: Colour, steps: int) -> list[Colour]:
    """Return `steps` colours from shadow to light."""
    return [mix(shadow, light, i / (steps - 1)) for i in range(steps)]


def knowledge(sd: float) -> Colour:
    """Colour of a standard deviation of a natural log, on a log scale from `UNKNOWN_SD` to `KNOWN_SD`."""
    share = math.log(UNKNOWN_SD / sd) / math.log(UNKNOWN_SD / KNOWN_SD)
    position = min(max(share, 0.0), 1.0) * (len(KNOWLEDGE) - 1)
    index = min(int(position), len(KNOWLEDGE) - 2)
    return mix(KNOWLEDGE[index], KNOWLEDGE[index + 1], position - index)


def stiffness(ratio: float) -> Colour:
    """Colour of a muscle's force in the closed jaw over the one from which it is stiff: green below, clay above 1."""
    share = 0.5 + 0.5 * math.log(max(ratio, 1e-9)) / math.log(STIFFEST)
    position = min(max(share, 0.0), 1.0) * (len(STIFFNESS) - 1)
    index = min(int(position), len(STIFFNESS) - 2)
    return mix(STIFFNESS[index], STIFFNESS[index + 1], position - index)


def comfort(used: float, hard: float) -> Colour:
    """Colour of a used fraction: green within the soft limit, amber beyond it, red beyond the hard limit."""
    if used > hard:
        return ALARM
    return WARN if used > 1 else GOOD
