"""The fields of a cohort as a mapping or a file holds them."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from jawenv.base.files import InputModel, Number, Text

__all__ = ["CohortFields"]

Positive = Annotated[Number, Field(gt=0)]


class StiffnessFields(InputModel):
    """The fields of `Stiffness`."""

    F_o_N: Positive
    F_o_sd: Positive
    b: Positive
    b_sd: Positive


class GroupFields(InputModel):
    """Stiffness of every whole muscle on each side."""

    left: StiffnessFields
    right: StiffnessFields


class CohortFields(InputModel):
    """Equally likely groups, and what tables call the cohort."""

    name: Text = Field(default="cohort", min_length=1)
    description: Text = ""
    basis: str = ""
    groups: list[GroupFields] = Field(min_length=1)
