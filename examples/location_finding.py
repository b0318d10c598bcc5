"""Bounds on the expected information of random readings on location finding, a test problem of Bayesian design.

    python examples/location_finding.py --rollouts 512 --contrasts 200000

Two sources in the plane, 30 readings at random places (Foster et al. 2021, ICML, Proc. Mach. Learn. Res. 139:3384);
with these numbers in some minutes.
"""

import argparse

import numpy as np

import jawenv

BASE, SOFT, NOISE, READINGS = 0.1, 1e-4, 0.5, 30


def log_signal(sources, place):
    """(n,) of sources (n, 2, 2) at a place (2,)."""
    squared = ((sources - place) ** 2).sum(-1)
    return np.log(BASE + (1.0 / (SOFT + squared)).sum(-1))


def log_likelihoods(contrasts, rng):
    """(L + 1,) nats of an experiment's readings at its true sources, which are drawn, and at contrasts (L, 2, 2)."""
    everybody = np.concatenate([rng.normal(size=(1, 2, 2)), contrasts])
    total = np.zeros(len(everybody))
    for place in rng.normal(size=(READINGS, 2)):
        mean = log_signal(everybody, place)
        total -= 0.5 * ((mean[0] + NOISE * rng.normal() - mean) / NOISE) ** 2
    return total


def main():
    """Read the command line, and print both bounds with their standard errors."""
    parser = argparse.ArgumentParser(description="Bound the information of random readings.")
    parser.add_argument("--rollouts", type=int, default=256)
    parser.add_argument("--contrasts", type=int, default=100_000)
    given, rng = parser.parse_args(), np.random.default_rng(400_000)
    contrasts = rng.normal(size=(given.contrasts, 2, 2))
    values = np.array([log_likelihoods(contrasts, rng) for _ in range(given.rollouts)])
    for name, bound in zip(("lower", "upper"), jawenv.contrastive_bounds(values), strict=True):
        print(f"{name} bound, nats: {bound.mean():.3f} ± {bound.std(ddof=1) / np.sqrt(len(bound)):.3f}")


if __name__ == "__main__":
    main()
