"""The table of muscle attachments: one row per muscle portion, right side, jaw closed."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from jawenv.anatomy.arrays import FrozenArrays
from jawenv.anatomy.quantities import Grade, load_quantities, read_data, to_si
from jawenv.base.errors import InputError
from jawenv.base.files import InputModel, Number, validate

__all__ = ["Attachment", "AttachmentRow", "attachment", "attachment_rows"]

Triple = tuple[Number, Number, Number]


class AttachmentRow(InputModel):
    """One row of the data file, as printed: the portion's two ends on the right side with their spread."""

    portion: str = Field(min_length=1)
    status: Literal["accepted", "rejected"]
    unit: Literal["mm"]
    origin: Triple
    origin_sd: Triple
    insertion: Triple
    insertion_sd: Triple
    source: str = Field(min_length=1)
    grade: Grade
    remark: str = ""


class _Table(InputModel):
    row: tuple[AttachmentRow, ...]


@dataclass(frozen=True, eq=False)
class Attachment(FrozenArrays):
    """The line of one muscle portion on one side."""

    origin_m: NDArray[np.float64]  # (3,) end on the skull
    insertion_m: NDArray[np.float64]  # (3,) end on the mandible, jaw closed
    origin_sd_m: NDArray[np.float64]  # (3,) sd between subjects of the end on the skull
    insertion_sd_m: NDArray[np.float64]  # (3,) the same of the end on the mandible
    strength_N: float  # largest active force, the portion's weight in a whole muscle


@cache
def attachment_rows() -> tuple[AttachmentRow, ...]:
    """Every row of the table, the rejected ones too (for documentation; models use `attachment`)."""
    return validate(_Table, read_data("attachments.toml"), "attachments.toml").row


def attachment(portion: str, side: str) -> Attachment:
    """The accepted line of a portion, mirrored for the left side."""
    if side not in ("left", "right"):
        raise InputError(f"side '{side}' is unknown; allowed: left, right")
    rows = {row.portion: row for row in attachment_rows() if row.status == "accepted"}
    if portion not in rows:
        raise InputError(f"muscle portion '{portion}' is unknown; allowed: {', '.join(rows)}")
    row = rows[portion]
    mirror = np.array([1.0, -1.0 if side == "left" else 1.0, 1.0])
    return Attachment(
        origin_m=mirror * to_si(list(row.origin), row.unit),
        insertion_m=mirror * to_si(list(row.insertion), row.unit),
        origin_sd_m=to_si(list(row.origin_sd), row.unit),
        insertion_sd_m=to_si(list(row.insertion_sd), row.unit),
        strength_N=float(load_quantities("strengths.toml")[portion].si()),
    )
