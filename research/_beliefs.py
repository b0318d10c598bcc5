"""Common parts of the studies: beliefs against the truth, and tables whose rows are printed one by one."""

from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


class Beliefs(NamedTuple):
    """Beliefs about N patients against the truth."""

    nees: Array  # (N,) over the number of parameters
    error: Array  # (N, P)
    sd: Array  # (N, P)

    @classmethod
    def of(cls, mean: ArrayLike, cov: ArrayLike, truth: Array) -> Self:
        """Beliefs with mean (N, P) and covariance (N, P, P)."""
        error, cov = np.asarray(mean) - truth, np.asarray(cov)
        nees = np.einsum("...p,...pq,...q->...", error, np.linalg.inv(cov), error) / error.shape[-1]
        return cls(nees, error, np.sqrt(np.diagonal(cov, axis1=-2, axis2=-1)))


def head(*cells: object, texts: int = 1) -> None:
    """Print a table's head; its first columns hold texts."""
    row(*cells)
    print("|" + texts * "---|" + (len(cells) - texts) * "--:|", flush=True)


def row(*cells: Any) -> None:
    """Print a row of a table in Markdown."""
    print("| " + " | ".join(map(str, cells)) + " |", flush=True)
