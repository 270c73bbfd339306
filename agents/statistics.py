"""Means with 95 % confidence intervals, by the bootstrap: strides are skewed and capped."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

RESAMPLES = 10_000
CONFIDENCE = 0.95
METHOD = f"percentile bootstrap over episodes, {RESAMPLES} resamples, 95 %"
SHARE_METHOD = "Wilson score interval, 95 %"
_Z = 1.959963984540054  # normal quantile of 0.975
_CHUNK = 2_000_000  # numbers drawn at once


class Estimate(NamedTuple):
    """A mean with its 95 % confidence interval."""

    mean: float
    low: float
    high: float

    def text(self, decimals: int = 1, signed: bool = False) -> str:
        """As tables print it: `26.1 [23.4, 28.9]`."""
        sign = "+" if signed else ""
        low, mean, high = (f"{x:{sign}.{decimals}f}" for x in (self.low, self.mean, self.high))
        return f"{mean} [{low}, {high}]"

    def to_dict(self) -> dict[str, float]:
        """For JSON."""
        return dict(self._asdict())


def mean_estimate(values: ArrayLike) -> Estimate:
    """The mean of independent values; the same values give the same interval.

    Raises:
        ValueError: no values, or values that are not finite.
    """
    sample = np.asarray(values, np.float64)
    if sample.ndim != 1 or not sample.size or not np.isfinite(sample).all():
        raise ValueError(f"values must be a row of finite numbers, got {values!r}")
    rng = np.random.default_rng(0)
    rows = max(1, _CHUNK // sample.size)
    means = np.concatenate(
        [
            sample[rng.integers(0, sample.size, (min(rows, RESAMPLES - done), sample.size))].mean(1)
            for done in range(0, RESAMPLES, rows)
        ]
    )
    tail = 50 * (1 - CONFIDENCE)
    low, high = np.percentile(means, [tail, 100 - tail]).tolist()
    return Estimate(float(sample.mean()), low, high)


def share_estimate(count: int, total: int) -> Estimate:
    """A share; its interval has a width even at none and at all.

    Raises:
        ValueError: no trials, or more successes than trials.
    """
    if not 0 <= count <= total or total < 1:
        raise ValueError(f"count must lie in [0, {total}] of at least one, got {count}")
    share, weight = count / total, _Z**2 / total
    centre = (share + weight / 2) / (1 + weight)
    half = math.sqrt(share * (1 - share) * weight + weight**2 / 4) / (1 + weight)
    return Estimate(share, max(0.0, centre - half), min(1.0, centre + half))


def paired_difference(values: Any, reference: Any) -> Estimate:
    """The mean of `values − reference`, episode by episode.

    Raises:
        ValueError: as many values as references are needed.
    """
    first, second = np.asarray(values, np.float64), np.asarray(reference, np.float64)
    if first.shape != second.shape:
        raise ValueError(f"pairs need as many values, got {first.shape} and {second.shape}")
    return mean_estimate(first - second)
