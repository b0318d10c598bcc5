"""What the settings of a search for maneuvers have in common: how they are checked and told."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from typing import Any, Self, get_args

from jawenv.errors import InputError, shown


class SearchSettings:
    """Base of frozen dataclasses."""

    @classmethod
    def of(cls, given: Mapping[str, Any]) -> Self:
        """From arguments of the fields' names, among others.

        Raises:
            InputError: a field has a value that is not allowed.
        """
        return cls(**{field.name: given[field.name] for field in fields(cls)})  # type: ignore[arg-type]

    def about(self) -> dict[str, Any]:
        """All fields."""
        return {field.name: getattr(self, field.name) for field in fields(self)}  # type: ignore[arg-type]

    def check_choices(self, **kinds: Any) -> None:
        """Make sure that fields are among the values of a ``Literal``.

        Raises:
            InputError: one is not.
        """
        for name, kind in kinds.items():
            if getattr(self, name) not in get_args(kind):
                allowed = ", ".join(get_args(kind))
                raise InputError(f"{name} is {shown(getattr(self, name))}; allowed: {allowed}")

    def check_least(self, **least: int) -> None:
        """Make sure that fields are not below a number.

        Raises:
            InputError: one is.
        """
        for name, number in least.items():
            if getattr(self, name) < number:
                raise InputError(f"{name} is {getattr(self, name)}; allowed: {number} or more")
