"""Means and shares of episodes with their confidence intervals."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy import stats

RESAMPLES = 10_000
METHOD = f"percentile bootstrap over episodes, {RESAMPLES} resamples, 95 %"
SHARE_METHOD = "Wilson score interval, 95 %"


class Estimate(NamedTuple):
    """A mean or share with its 95 % confidence interval."""

    mean: float
    low: float
    high: float

    def text(self, decimals: int = 1, signed: bool = False) -> str:
        """As tables print it: `26.1 [23.4, 28.9]`."""
        sign = "+" if signed else ""
        low, mean, high = (f"{x:{sign}.{decimals}f}" for x in (self.low, self.mean, self.high))
        return f"{mean} [{low}, {high}]"


def mean_estimate(values: ArrayLike) -> Estimate:
    """The mean of independent values; the same values give the same interval.

    The bootstrap, since strides are skewed and capped.

    Raises:
        ValueError: no values, or values that are not finite.
    """
    sample = np.asarray(values, np.float64)
    if sample.ndim != 1 or not sample.size or not np.isfinite(sample).all():
        raise ValueError(f"values must be a row of finite numbers, got {values!r}")
    mean = float(sample.mean())
    if np.ptp(sample) == 0:  # scipy wants two values, and complains of equal ones
        return Estimate(mean, mean, mean)
    found = stats.bootstrap(
        (sample,),
        np.mean,
        n_resamples=RESAMPLES,
        batch=max(1, 2_000_000 // sample.size),
        method="percentile",
        random_state=np.random.default_rng(0),
    ).confidence_interval
    return Estimate(mean, float(found.low), float(found.high))


def share_estimate(count: int, total: int) -> Estimate:
    """A share; its interval has a width even at none and at all.

    Raises:
        ValueError: no trials, or more successes than trials.
    """
    if not 0 <= count <= total or total < 1:
        raise ValueError(f"count must lie in [0, {total}] of at least one, got {count}")
    low, high = stats.binomtest(count, total).proportion_ci(0.95, "wilson")
    return Estimate(count / total, float(low), float(high))


def paired_difference(values: Any, reference: Any) -> Estimate:
    """The mean of `values − reference`, episode by episode.

    Raises:
        ValueError: as many values as references are needed.
    """
    first, second = np.asarray(values, np.float64), np.asarray(reference, np.float64)
    if first.shape != second.shape:
        raise ValueError(f"pairs need as many values, got {first.shape} and {second.shape}")
    return mean_estimate(first - second)
