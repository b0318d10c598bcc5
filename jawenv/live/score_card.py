"""The score of a drive as a PNG."""

from __future__ import annotations

import io
import math
import os
from collections.abc import Sequence

from jawenv.live.look import NOTICE
from jawenv.live.outcome import DriveOutcome
from jawenv.live.question import AnsweredMuscle
from jawenv.rendering import palette

_WIDTH, _MARGIN, _LINE = 720, 36, 30


def score_png(title: str, answer: Sequence[AnsweredMuscle], outcomes: Sequence[DriveOutcome]) -> bytes:
    """Answer and outcomes of a drive on one picture.

    Args:
        title: level and patient.
        answer: of the player; may be empty.
        outcomes: of the player and the rivals.

    Raises:
        MissingPackageError: pygame is not installed.
    """
    rows: list[Sequence[str]] = []
    if answer:
        rows += [("", "you say", "truth, N", "filter, N")]
        rows += [
            (
                row.muscle.replace("_", " "),
                f"{'' if row.right else 'wrong: '}{_word(row.said)}",
                f"{_word(row.stiff)}, {row.true_F_o_N:#.3g}",
                row.estimate,
            )
            for row in answer
        ]
        rows += [()]
    rows += [("", "all within 5 %", "worst sd", "discomfort")]
    rows += [
        (
            one.name.replace("_", " "),
            f"{one.time_to_s[1]:.1f} s" if math.isfinite(one.time_to_s[1]) else "never",
            f"{100 * one.worst_sd:.1f} %",
            f"{one.discomfort_s:.2f} s",
        )
        for one in outcomes
    ]
    right = f"{sum(row.right for row in answer)} of {len(answer)} right" if answer else "Score"
    return _drawn(right, title, rows)


def _drawn(heading: str, title: str, rows: Sequence[Sequence[str]]) -> bytes:
    from jawenv.base.extras import needs

    os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")
    with needs("a picture of the score", "pygame", "live"):
        import pygame

        from jawenv.rendering.canvas import Canvas
    size = (_WIDTH, 2 * _MARGIN + 70 + _LINE * (len(rows) + 1))
    canvas = Canvas(size, size)
    canvas.rect((12, 12, size[0] - 24, size[1] - 24), palette.CARD, 12, palette.BORDER)
    canvas.text(heading, (_MARGIN, _MARGIN + 12), 30, bold=True)
    canvas.text(title, (_MARGIN, _MARGIN + 46), 16, palette.SOFT_INK)
    ends = (_MARGIN, 360, 540, _WIDTH - _MARGIN)
    for i, row in enumerate(rows):
        for k, words in enumerate(row):
            head = row[0] == ""
            place = (ends[k], _MARGIN + 85 + _LINE * i)
            colour = palette.WARN if words.startswith("wrong") else palette.SOFT_INK if head else palette.INK
            canvas.text(words, place, 16, colour, anchor="right" if k else "left")
    canvas.text(f"jawenv live. {NOTICE}", (_MARGIN, size[1] - _MARGIN), 13, palette.SOFT_INK)
    file = io.BytesIO()
    pygame.image.save(canvas.finish(), file, "score.png")
    return file.getvalue()


def _word(stiff: bool) -> str:
    return "stiff" if stiff else "healthy"
