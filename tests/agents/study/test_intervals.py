"""Interquartile means and their intervals against what is known."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy import stats

from agents.study.intervals import Stratum, interquartile_mean, middle_mean
from powered_walker_env.controllers import mean_estimate


@pytest.mark.parametrize("count", [1, 2, 3, 4, 5, 8, 20, 21])
def test_the_middle_mean_is_scipys(count: int) -> None:
    values = np.random.default_rng(count).normal(size=count)
    assert middle_mean(values) == pytest.approx(stats.trim_mean(values, 0.25), rel=1e-14)


def test_of_five_seeds_the_middle_three_count() -> None:
    values = np.array([[0.0], [1.0], [2.0], [6.0], [1000.0]])
    assert interquartile_mean([Stratum(values)]).mean == pytest.approx(3.0)


def test_one_run_has_the_interval_of_its_episodes() -> None:
    values = np.random.default_rng(0).exponential(size=300)
    ours, known = interquartile_mean([Stratum(values[np.newaxis])], 4000), mean_estimate(values)
    assert ours.mean == pytest.approx(known.mean)
    width = known.high - known.low
    assert ours.low == pytest.approx(known.low, abs=0.05 * width)
    assert ours.high == pytest.approx(known.high, abs=0.05 * width)


def test_equal_runs_leave_the_episodes_alone_and_a_single_value_nothing() -> None:
    row = np.random.default_rng(0).normal(size=50)
    one, five = (interquartile_mean([Stratum(np.tile(row, (n, 1)))], 2000) for n in (1, 5))
    assert five.mean == pytest.approx(one.mean)
    assert five.high - five.low == pytest.approx(one.high - one.low, rel=0.1)
    assert interquartile_mean([Stratum([[2.0]])]) == (2.0, 2.0, 2.0)


def test_intervals_cover_a_known_mean_about_as_often_as_they_say() -> None:
    """Two environments of ten seeds: runs differ by 1, episodes by 0.3."""
    rng, hits, tries = np.random.default_rng(1), 0, 150
    for _ in range(tries):
        strata = [
            Stratum(rng.normal(size=(10, 1)) + 0.3 * rng.normal(size=(10, 8)) + 5.0)
            for _ in range(2)
        ]
        found = interquartile_mean(strata, 300)
        hits += found.low <= 5.0 <= found.high
    # A percentile bootstrap of ten falls somewhat short of 95 %: 0.86 to 0.98 is four errors.
    assert 0.86 <= hits / tries <= 0.985


def test_runs_are_drawn_within_their_environment_only() -> None:
    """Two environments far apart: were runs drawn among all, the mean would vary by 25."""
    strata = [Stratum(np.full((5, 3), value) + np.arange(5)[:, np.newaxis]) for value in (0, 100)]
    found = interquartile_mean(strata)
    assert found.mean == pytest.approx(52.0)
    assert found.high - found.low < 6.0


def test_scores_are_those_of_the_drawn_episodes() -> None:
    rng = np.random.default_rng(2)
    low, high = rng.normal(1.0, 0.5, 200), rng.normal(9.0, 0.5, 200)
    worst, best = (interquartile_mean([Stratum([row], low, high)]) for row in (low, high))
    assert worst == (0.0, 0.0, 0.0) and best == (1.0, 1.0, 1.0)
    half = interquartile_mean([Stratum([0.5 * (low + high)], low, high)])
    assert half.low == pytest.approx(0.5) and half.high == pytest.approx(0.5)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (([1.0, 2.0],), r"values must be finite numbers, \(runs, episodes\), got shape \(2,\)"),
        (([[np.nan]],), "values must be finite numbers"),
        ((np.zeros((0, 3)),), "values must be finite numbers"),
        (([[1.0]], [0.0]), "low and high must be given both or not at all"),
        (([[1.0]], [0.0], [1.0, 2.0]), "high must be 1 finite numbers, one for each episode"),
    ],
)
def test_bad_values_are_refused(arguments: tuple[Any, ...], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        Stratum(*arguments)


def test_bad_strata_are_refused() -> None:
    with pytest.raises(ValueError, match=r"equally many episodes, got \[2, 3\]"):
        interquartile_mean([Stratum(np.ones((2, 2))), Stratum(np.ones((2, 3)))])
    with pytest.raises(ValueError, match=r"equally many episodes, got \[\]"):
        interquartile_mean([])
    with pytest.raises(ValueError, match="resamples"):
        interquartile_mean([Stratum([[1.0]])], 0)
