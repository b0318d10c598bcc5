"""How a module of this folder says which library it is about."""

import pytest


def library(name: str) -> list[pytest.MarkDecorator]:
    """The marks of a module's tests: in the group, of the distribution ``name``."""
    return [pytest.mark.foreign, pytest.mark.library(name)]
