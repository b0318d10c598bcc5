"""The load cell's amplifier: it passes the parabola that fits a tick's force best.

A brake or an end stop changes its force several times within a tick. Instantaneous samples would be aliased: three of
them miss its mean over a tick by up to a tenth (Simpson's rule), and the filter would attribute the difference to the
muscles. The amplifier therefore averages. The three samples, at start, middle and end, are those of the least-squares
parabola, which has the force's mean and first two moments.
"""

from __future__ import annotations

from jawenv.kernels.compiled import njit


@njit
def clear_moments(samples):
    """Set the moments of a new tick to zero."""
    samples[:, :] = 0.0


@njit
def add_moments(samples, wrench, share, time):
    """Add the wrench of a ``share`` of the tick, which lies at ``time``, from -1 at its start to 1 at its end.

    Until ``take_samples``, the rows of ``samples`` (3, 6) are the force's parts along Legendre's polynomials 1, x and
    (3 x^2 - 1)/2.
    """
    first, second = 3.0 * share * time, 2.5 * share * (3.0 * time * time - 1.0)
    for k in range(6):
        samples[0, k] += share * wrench[k]
        samples[1, k] += first * wrench[k]
        samples[2, k] += second * wrench[k]


@njit
def take_samples(samples):
    """Samples of the parabola at start, middle and end of the tick."""
    for k in range(6):
        mean, rise, bend = samples[0, k], samples[1, k], samples[2, k]
        samples[0, k], samples[1, k], samples[2, k] = mean - rise + bend, mean - 0.5 * bend, mean + rise + bend
