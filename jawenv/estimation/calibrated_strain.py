"""A line's strain as regressors are made of it: its expectation, given the estimate.

Tensions are exp(b e) of the strain e, so that a jaw that trembles tells of b. Where the estimate trembles more than the
jaw, as with a load cell that is noisy beside the force that no model explains, most of that is error, and what
regressors owe to it would count as information that is not there: the regression dilution of errors in variables.
Regression calibration (Carroll et al. 2006, Measurement Error in Nonlinear Models, 2nd ed., chapter 4) puts the mean of
the true regressor, given the estimated one, in its place: mean + share (strain - mean), with share = 1 - D / V. V is
the variance of the estimated strain about its mean of late, D its covariance with its error (``noisy_input``). A jaw
that is moved has a V beside which D is nothing, and a share of one.
"""

from __future__ import annotations

from jawenv.compiled import njit

MEAN_OVER = 1.0  # s
LARGEST_OFFSET = 3.0  # sds; a strain that is farther off its mean moves, whatever V was


@njit
def calibrate(strain, shared, line, belief, dt):
    """Strain as regressors have it, and the share of its change that they have; moves mean and variance on by ``dt``.

    ``shared`` is the covariance D of the estimated strain with its error. A mean that is not a number begins anew.
    """
    offset = strain - belief.strain_mean[line]
    if not offset * offset >= 0.0:
        belief.strain_mean[line], belief.strain_variance[line], offset = strain, 0.0, 0.0
    new = min(1.0, dt / MEAN_OVER)
    belief.strain_mean[line] += new * offset
    belief.strain_variance[line] += new * (offset * offset - belief.strain_variance[line])
    variance = max(belief.strain_variance[line], offset * offset / (LARGEST_OFFSET * LARGEST_OFFSET))
    share = 1.0
    if shared > 0.0:
        share = 1.0 - shared / variance if variance > shared else 0.0
    return belief.strain_mean[line] + share * (strain - belief.strain_mean[line]), share
