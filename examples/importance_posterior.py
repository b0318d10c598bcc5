"""Is the filter's belief the posterior? Importance samples of a hinge's two parameters, beside the filter.

    python examples/importance_posterior.py --patients 4

Patients are drawn of the cohort, the jaw is opened and closed in force control, and samples of the posterior are
weighted by prior times likelihood. For each patient it prints truth, posterior and the filter's belief, the effective
number of samples, and the divergence of the belief from the posterior (0: they are equal); last, the mean NEES per
parameter of both (1 is expected of a true posterior).
"""

import argparse
import sys

import numpy as np
from scipy.special import logsumexp
from scipy.stats import multivariate_normal, multivariate_t

import jawenv
from jawenv.ladder import model_named
from jawenv.recordings.record import Record
from jawenv.recordings.record_filter import TensionFilter

ENV = "jawenv/JawHinge-v3"
ROUNDS = 3  # each proposes from what the last has found


def importance_posterior(
    record: Record, mean: np.ndarray, cov: np.ndarray, samples: int, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray, float]:
    """Mean (p,) and covariance (p, p) of the posterior, and the effective number of samples.

    Adaptive importance sampling (Cappe et al. 2004, J. Comput. Graph. Stat. 13:907) with Student's t, whose tails are
    heavier than the posterior's, first about a rough ``mean`` and ``cov``.
    """
    for _ in range(ROUNDS):
        proposal = multivariate_t(mean, 2.0 * cov, df=5, seed=rng)
        theta = proposal.rvs(samples)
        prior = multivariate_normal(record.prior.mean, np.diag(record.prior.sd**2))
        log_weight = prior.logpdf(theta) + jawenv.log_likelihood(record, theta) - proposal.logpdf(theta)
        weight = np.exp(log_weight - logsumexp(log_weight))
        mean = weight @ theta
        cov = np.cov(theta.T, aweights=weight, ddof=0)
    return mean, cov, 1.0 / np.sum(weight**2)


def divergence(mean: np.ndarray, cov: np.ndarray, other_mean: np.ndarray, other_cov: np.ndarray) -> float:
    """Kullback and Leibler's of the first normal law from the second, nats."""
    ratio, error = np.linalg.solve(other_cov, cov), mean - other_mean
    distance = error @ np.linalg.solve(other_cov, error)
    return 0.5 * float(np.trace(ratio) - len(mean) + distance - np.linalg.slogdet(ratio)[1])


def nees(truth: np.ndarray, mean: np.ndarray, cov: np.ndarray) -> float:
    """Normalised estimation error squared, per parameter."""
    return float((truth - mean) @ np.linalg.solve(cov, truth - mean)) / len(truth)


def figures(mean: np.ndarray, cov: np.ndarray) -> str:
    """F_o and b with their sds in percent."""
    sd = 100.0 * np.sqrt(np.diag(cov))
    return "  ".join(f"{np.exp(value):7.3f} ± {error:5.2f} %" for value, error in zip(mean, sd, strict=True))


def main() -> None:
    """Read the command line, simulate, sample and print."""
    parser = argparse.ArgumentParser(description="Compare the filter's belief with an importance-sampled posterior.")
    parser.add_argument("--patients", type=int, default=4)
    parser.add_argument("--seconds", type=int, default=4)
    parser.add_argument("--samples", type=int, default=500, help="of a posterior; a round takes about 2 s")
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    for name, least in (("patients", 1), ("seconds", 1), ("samples", 50)):
        if getattr(given, name) < least:
            raise jawenv.InputError(f"{name} is {getattr(given, name)}; allowed: {least} or more")

    cohort = jawenv.cohort("trismus", model_named("hinge").muscles)
    theta = cohort.sample(given.patients, given.seed, accept=lambda rows: jawenv.treatable(rows, env_id=ENV))
    time = np.arange(1, 20 * given.seconds + 1) / 20
    actions = np.outer(0.5 * np.sin(0.5 * np.pi * time) ** 2, [1.0, 1.0, 0.0, 0.0])
    made = jawenv.simulate(theta, actions, given.seed, env_id=ENV, env_kwargs={"control": "force"})
    rng, worth = np.random.default_rng(given.seed), []
    print(f"{'':10}{'F_o, N':>19}{'b':>19}")
    for truth, record in zip(theta, made.records, strict=True):
        belief = TensionFilter().estimate(record)
        believed = belief.mean[-1], belief.cov[-1]
        mean, cov, effective = importance_posterior(record, *believed, given.samples, rng)
        print(f"truth     {'  '.join(f'{value:7.3f}{chr(32) * 10}' for value in np.exp(truth))}")
        print(f"posterior {figures(mean, cov)}  {effective:.0f} of {given.samples} samples")
        print(f"filter    {figures(*believed)}  {divergence(mean, cov, *believed):.3f} nats apart\n", flush=True)
        worth.append((nees(truth, mean, cov), nees(truth, *believed)))
    posterior, filtered = np.mean(worth, axis=0)
    print(f"NEES/2 of {given.patients} patients: posterior {posterior:.2f}, filter {filtered:.2f}")


if __name__ == "__main__":
    try:
        main()
    except jawenv.InputError as error:
        print(f"error: {error}", file=sys.stderr)
        sys.exit(2)
