"""Bootstrap intervals: conclusions from the patients of a study on all patients.

Every interval is over patients (scipy.stats.bootstrap): bias-corrected and accelerated for means, percentile
for quantiles, whose acceleration a jackknife cannot estimate (Efron & Tibshirani 1993, chapters 11 and 14).
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

import numpy as np
import numpy.typing as npt
from scipy.stats import binomtest, bootstrap, t

from jawenv.metrics.intervals import CONFIDENCE as CONFIDENCE
from jawenv.metrics.intervals import RESAMPLES as RESAMPLES
from jawenv.metrics.intervals import UNKNOWN as UNKNOWN
from jawenv.metrics.intervals import Array as Array
from jawenv.metrics.intervals import Interval as Interval
from jawenv.metrics.intervals import mean as mean
from jawenv.metrics.intervals import over_patients


def mean_over_both(values: Array) -> Interval:
    """Mean over trainings and patients; both are resampled for its interval (Owen 2007, Ann Appl Stat 1:386).

    Args:
        values: (S, N) of S trainings, each on the same N patients.
    """
    estimate = float(values.mean())
    if min(values.shape) < 2 or not np.isfinite(estimate):
        return Interval(estimate, float("nan"), float("nan"))
    rng, (trainings, patients) = np.random.default_rng(0), values.shape
    rows = rng.multinomial(trainings, np.full(trainings, 1.0 / trainings), RESAMPLES) / trainings
    columns = rng.multinomial(patients, np.full(patients, 1.0 / patients), RESAMPLES) / patients
    resampled = np.einsum("rs,sn,rn->r", rows, values, columns, optimize=True)
    low, high = np.quantile(resampled, [(1.0 - CONFIDENCE) / 2.0, (1.0 + CONFIDENCE) / 2.0])
    return Interval(estimate, float(low), float(high))


def difference(values: Array, others: Array) -> Interval:
    """Mean of some patients less that of others, with the interval of two independent samples (Welch 1947).

    Args:
        values: (N,) one per patient.
        others: (M,) of other patients.
    """
    apart = float(values.mean() - others.mean())
    if min(len(values), len(others)) < 2:
        return Interval(apart, float("nan"), float("nan"))
    squares = np.array([sample.var(ddof=1) / len(sample) for sample in (values, others)])
    if not squares.any():
        return Interval(apart, apart, apart)
    freedom = squares.sum() ** 2 / (squares**2 / [len(values) - 1, len(others) - 1]).sum()
    half = float(np.sqrt(squares.sum()) * t.ppf((1.0 + CONFIDENCE) / 2.0, freedom))
    return Interval(apart, apart - half, apart + half)


def means_together(values: Array) -> list[Interval]:
    """Means over patients of several figures, with intervals that hold all true means at once with 95 %.

    All have the same width in standard errors: the quantile of the largest deviation of any resampled mean (bootstrap
    maximum; Romano & Wolf 2005, Econometrica 73:1237).

    Args:
        values: (N, K) K figures of N patients.
    """
    means = values.mean(axis=0) if len(values) else np.full(values.shape[1], np.nan)
    error = values.std(axis=0, ddof=1) / np.sqrt(len(values)) if len(values) > 1 else np.full_like(means, np.nan)
    if not np.isfinite(error).all():
        return [Interval(float(value), float("nan"), float("nan")) for value in means]
    varying = error > 0.0

    def furthest(rows: Array, axis: int = -1) -> Array:
        deviations = np.abs(values[rows.astype(np.intp)].mean(axis=-2) - means)[..., varying] / error[varying]
        largest: Array = deviations.max(axis=-1, initial=0.0)
        return largest

    drawn = bootstrap(
        (np.arange(len(values)),),
        furthest,
        n_resamples=RESAMPLES,
        batch=max(1, 4_000_000 // values.size),
        method="percentile",
        rng=np.random.default_rng(0),
    ).bootstrap_distribution
    half = np.quantile(drawn, CONFIDENCE) * error
    return [Interval(*map(float, ends)) for ends in zip(means, means - half, means + half, strict=True)]


def quantile(values: Array, share: float) -> Interval:
    """Quantile over patients, always one of the values, so that infinite ones ('never') may take part.

    Args:
        values: (N,) one per patient.
        share: 0.5 is the median.
    """
    values = np.asarray(values, dtype=np.float64)
    finite = values[np.isfinite(values)]
    largest = float(finite.max()) if len(finite) else 0.0
    # Resampling needs finite numbers: 'never' is any number beyond the largest, and is turned back at the
    # end.
    ranked = np.where(np.isfinite(values), values, largest + 1.0)

    def statistic(x: Array) -> Array:
        quantiles: Array = np.quantile(x[..., 0], share, axis=-1, method="inverted_cdf")
        return quantiles

    estimate = over_patients(statistic, ranked[:, None], "percentile")
    return Interval(*(np.inf if end > largest else end for end in (estimate.value, estimate.low, estimate.high)))


def rmse_over_bound(error: Array, bound_sd: Array) -> Interval:
    """Mean over the parameters of root mean squared error over bound, both taken over the patients.

    Args:
        error: (N, P).
        bound_sd: (N, P).
    """
    size = error.shape[1]

    def statistic(x: Array) -> Array:
        squares = np.mean(np.square(x), axis=-2)
        ratio: Array = np.sqrt(squares[..., :size] / squares[..., size:]).mean(axis=-1)
        return ratio

    return over_patients(statistic, np.hstack([error, bound_sd]), "BCa")


def share(hits: Sequence[bool] | npt.NDArray[np.bool_]) -> Interval:
    """Share of independent trials, with the interval of Wilson (1927); NaN of none."""
    hits = np.asarray(hits)
    return share_of(int(hits.sum()), len(hits)) if len(hits) else UNKNOWN


def better(values: Array, reference: Array, *, higher: bool) -> Array:
    """Whether a value is better than the reference's on the same patient: 1, or 0, or 1/2 where they are equal.

    Its mean is the probability of improvement (Agarwal et al. 2021, NeurIPS 34:29304), here of pairs.

    Args:
        values: (N,) one per patient; infinite ones may take part.
        reference: (N,) of the same patients in the same order.
        higher: whether a higher value is better.
    """
    values, reference = (values, reference) if higher else (reference, values)
    return np.where(values == reference, 0.5, (values > reference).astype(np.float64))


@cache
def share_of(count: int, number: int) -> Interval:
    """A share of patients, with Wilson's interval (1927, J Am Stat Assoc 22:209).

    Args:
        count: of those that have the property.
        number: of all, 1 or more.
    """
    ends = binomtest(count, number).proportion_ci(CONFIDENCE, "wilson")
    return Interval(count / number, float(ends.low), float(ends.high))
