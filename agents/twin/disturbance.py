"""A wrench that lasts: an Ornstein-Uhlenbeck process beside what a reading tells about the parameters.

Readings y = A p + J d + e of parameters p and a wrench d, which decays by a from one to the next, are filtered as if p
were 0. With D the derivative of the filtered d by p, an innovation depends on p by A - J D, and so D follows it.
"""

from __future__ import annotations

import torch
from torch import Tensor


class Disturbance:
    """The filter of d (P, 6) in P worlds.

    Args:
        variance: (6,) of d at all times.
        decay: a.
        worlds: P.
        parameters: how many p has.
    """

    def __init__(self, variance: Tensor, decay: float, worlds: int, parameters: int) -> None:
        self._variance, self._decay = torch.diag(variance), decay
        self._covariance = self._variance.expand(worlds, -1, -1)
        self._by_parameters = variance.new_zeros(worlds, 6, parameters)

    def innovation_rows(self, columns: Tensor, J: Tensor, noise: Tensor) -> Tensor:
        """Whitened rows (P, 5, parameters) of a reading's innovation.

        Args:
            columns: (P, 5, parameters) A.
            J: (P, 5, 6).
            noise: (P, 5, 5) of e.
        """
        L = torch.linalg.cholesky(J @ self._covariance @ J.mT + noise)
        rows: Tensor = torch.linalg.solve_triangular(L, columns - J @ self._by_parameters, upper=False)
        gain = torch.linalg.solve_triangular(L, J @ self._covariance, upper=False)
        self._by_parameters = self._decay * (self._by_parameters + gain.mT @ rows)
        kept = self._covariance - gain.mT @ gain
        self._covariance = self._decay**2 * kept + (1.0 - self._decay**2) * self._variance
        return rows
