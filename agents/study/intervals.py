"""Interquartile means over seeds and environments, with stratified bootstrap intervals.

After Agarwal et al. (Deep reinforcement learning at the edge of the statistical precipice, NeurIPS
2021): the value of a run is its mean over the episodes, the aggregate the interquartile mean over
all runs, the interval that of a percentile bootstrap which draws runs within each environment (its
stratum). Episodes are drawn, too, the same for all that met the same pushes, so that a single
run, or a controller without training, has an interval as well.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import stats

from powered_walker_env.controllers import Estimate
from powered_walker_env.model.checks import whole_number

CUT = 0.25  # from either end: what an interquartile mean leaves out
RESAMPLES = 2000
METHOD = "interquartile mean over seeds, stratified percentile bootstrap, 95 %"


@dataclass(frozen=True, eq=False)
class Stratum:
    """The runs at one environment, and what they are scored by.

    Args:
        values: (runs, episodes).
        low, high: (episodes,) of the same episodes: what counts 0, and what counts 1; left
            out, values count as they are.

    Raises:
        ValueError: another shape, or values that are not finite.
    """

    values: ArrayLike
    low: ArrayLike | None = None
    high: ArrayLike | None = None

    def __post_init__(self) -> None:
        values = np.asarray(self.values, np.float64)
        if values.ndim != 2 or not values.size or not np.isfinite(values).all():
            raise ValueError(
                f"values must be finite numbers, (runs, episodes), got shape {values.shape}"
            )
        object.__setattr__(self, "values", values)
        if (self.low is None) != (self.high is None):
            raise ValueError("low and high must be given both or not at all")
        for name in ("low", "high"):
            given = getattr(self, name)
            if given is None:
                continue
            row = np.asarray(given, np.float64)
            if row.shape != values.shape[1:] or not np.isfinite(row).all():
                raise ValueError(
                    f"{name} must be {values.shape[1]} finite numbers, one for each episode, got "
                    f"shape {row.shape}"
                )
            object.__setattr__(self, name, row)

    def runs(self, rows: Any, weights: NDArray[np.float64]) -> NDArray[np.float64]:
        """The values of some runs, by the weights of the episodes."""
        found: NDArray[np.float64] = np.asarray(self.values)[rows] @ weights
        if self.low is None or self.high is None:
            return found
        low = float(np.asarray(self.low) @ weights)
        return (found - low) / (float(np.asarray(self.high) @ weights) - low)


def middle_mean(values: NDArray[np.float64]) -> float:
    """`scipy.stats.trim_mean` of a row by a quarter, without its preliminaries."""
    cut = int(CUT * len(values))
    return float(np.sort(values)[cut : len(values) - cut].mean())


def interquartile_mean(strata: Sequence[Stratum], resamples: int = RESAMPLES) -> Estimate:
    """The interquartile mean over the runs of all strata, with its 95 % interval.

    Args:
        strata: one for each environment, of equally many episodes.
        resamples: of the bootstrap; the same values give the same interval.

    Raises:
        ValueError: no strata, or of unequal episodes.
    """
    whole_number("resamples", resamples, 1)
    lengths = {np.shape(each.values)[1] for each in strata}
    if len(lengths) != 1:
        raise ValueError(f"strata must be of equally many episodes, got {sorted(lengths)}")
    (episodes,) = lengths
    counts = [len(np.asarray(each.values)) for each in strata]
    drawn = [k for k, count in enumerate(counts) if count > 1]  # one run is always that run

    def statistic(*rows: NDArray[np.intp]) -> float:
        of = dict(zip(drawn, rows, strict=False))
        among = rows[-1] if episodes > 1 else np.zeros(1, np.intp)
        weights = np.bincount(among, minlength=episodes) / episodes
        return middle_mean(
            np.concatenate([each.runs(of.get(k, [0]), weights) for k, each in enumerate(strata)])
        )

    samples = [np.arange(counts[k]) for k in drawn]
    samples += [np.arange(episodes)] if episodes > 1 else []
    value = statistic(*samples)
    if not samples:
        return Estimate(value, value, value)
    with np.errstate(divide="ignore", invalid="ignore"):
        found = stats.bootstrap(
            samples, statistic, n_resamples=resamples, vectorized=False, method="percentile",
            random_state=np.random.default_rng(0),
        ).bootstrap_distribution  # fmt: skip
    low, high = np.nanpercentile(found, [2.5, 97.5])
    return Estimate(value, float(low), float(high))
