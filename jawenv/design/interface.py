"""The interface of a design environment (docs/inference.md)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol

from numpy.typing import ArrayLike

from jawenv.inference.settings import Array


class _Law(Protocol):
    """A distribution of p parameters."""

    def sample(self, n: int, seed: int) -> Array:
        """(n, p) draws, the same for the same seed."""

    def log_density(self, theta: ArrayLike) -> Array:
        """(n,) nats of parameters (n, p); -inf where nobody is."""


class DesignEnv(Protocol):
    """Parts of a design environment beside ``reset``, ``step`` and spaces of ``gymnasium.Env``.

    The ``info`` of ``reset`` and ``step`` has ``belief_mean`` (p,), ``belief_cov`` (p, p), ``truth`` (p,) and ``cost``,
    0 or more a second.
    """

    parameter_names: tuple[str, ...]
    """Names of the p parameters, in the order of all arrays."""
    prior: _Law
    """Law of the truth that ``reset`` draws."""

    def simulate(self, theta: ArrayLike, actions: ArrayLike, seed: int) -> Mapping[str, Any]:
        """Readings, arrays by name, of an experiment with parameters (p,) under K actions; the episode stays."""

    def log_likelihood(self, readings: Mapping[str, Any], theta: ArrayLike) -> Array | None:
        """(m,) nats of readings given parameters (m, p), up to a constant; None where there is no likelihood."""
