"""A linear-Gaussian estimation problem whose calibration is known exactly, recorded like an episode.

Patients are drawn from the prior, every measurement is linear in the log-parameters with Gaussian noise, and
the belief is the exact posterior (Kalman's). So the NEES is chi-squared with as many degrees of freedom as there
are parameters, 12 by default, and claimed equals true information on average. `shrink` multiplies the covariance
that is claimed: the NEES is then 12 / shrink.
"""

import numpy as np

from jawenv.playing.recording import Recording

MUSCLES = [
    f"{muscle}_{side}" for side in ("left", "right") for muscle in ("masseter", "temporalis", "medial_pterygoid")
]
PARAMETERS = tuple(f"log_{letter}/{muscle}" for muscle in MUSCLES for letter in ("F_o", "b"))
LIMITS = ("force", "opening", "side", "fore_aft", "condyle_fore_aft", "condyle_side", "speed", "tension")


def linear_gaussian(
    patients: int = 200,
    steps: int = 40,
    seed: int = 0,
    noise: float = 1.0,
    shrink: float = 1.0,
    hurt: float = 0.0,
    parameters: tuple[str, ...] = PARAMETERS,
) -> Recording:
    """Record `patients` exact estimations over `steps` of 0.5 s; odd patients bear the cost `hurt`."""
    rng = np.random.default_rng(seed)
    size = len(parameters)
    prior_mean, prior_sd = np.tile(np.log([1.2, 7.0]), size // 2), np.tile([0.5, 0.3], size // 2)
    truth = prior_mean + prior_sd * rng.standard_normal((patients, size))
    mean, cov = np.tile(prior_mean, (patients, 1)), np.tile(np.diag(prior_sd**2), (patients, 1, 1))
    means, covs = [mean], [cov]
    for _ in range(steps):
        row = rng.standard_normal((patients, 3, size))
        measured = np.einsum("nij,nj->ni", row, truth) + noise * rng.standard_normal((patients, 3))
        cross = cov @ row.transpose(0, 2, 1)
        gain = cross @ np.linalg.inv(row @ cross + noise**2 * np.eye(3))
        mean = mean + np.einsum("nji,ni->nj", gain, measured - np.einsum("nij,nj->ni", row, mean))
        cov = cov - gain @ cross.transpose(0, 2, 1)
        cov = 0.5 * (cov + cov.transpose(0, 2, 1))
        means.append(mean)
        covs.append(cov)
    exact = np.stack(covs, axis=1)
    claimed = exact.copy()
    claimed[:, 1:] *= shrink
    information = 0.5 * (2.0 * np.sum(np.log(prior_sd)) - np.linalg.slogdet(exact)[1])
    shape = (patients, steps + 1)
    cost = np.zeros(shape)
    cost[1::2, 1:] = hurt
    return Recording(
        time=0.5 * np.arange(steps + 1),
        belief_mean=np.stack(means, axis=1),
        belief_cov=claimed,
        truth=truth,
        prior_mean=prior_mean,
        prior_sd=prior_sd,
        bound_sd=np.sqrt(np.diagonal(exact, axis1=-2, axis2=-1)),
        information_claimed=information - 0.5 * size * np.log(shrink),
        information_true=information,
        information_bound=information,
        cost=cost,
        comfort=np.full((*shape, len(LIMITS)), 0.5),
        governor=np.full(shape, 0.25),
        violation=np.zeros(shape, dtype=bool),
        misfit=np.full(shape, 0.5),
        settled=np.ones(shape, dtype=bool),
        valid=np.ones(shape, dtype=bool),
        terminated=np.zeros(patients, dtype=bool),
        asked=np.ones(truth.shape, dtype=bool),
        parameter_names=parameters,
        comfort_names=LIMITS,
    )
