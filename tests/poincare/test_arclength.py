"""The curve follower on curves that are known: a circle, and one that leaves its domain."""

from __future__ import annotations

import numpy as np
import pytest

from powered_walker_env.model.phases import Outcome
from powered_walker_env.poincare.branches.arclength import (
    CurveEnd,
    EndReason,
    Solution,
    Window,
    correct,
    follow,
    locate,
    passes,
    tangent_of,
)
from powered_walker_env.poincare.families import Equations, OffCurveError
from powered_walker_env.poincare.maps import MapPoint
from tests.helpers.derivation import Array

NOWHERE = MapPoint(
    np.empty(4), 0.0, 0.0, np.empty((4, 6)), np.empty(6), np.empty(6), Outcome.WALKED
)


class Circle:
    """x² + p² = 1, where x is above a floor."""

    def __init__(self, floor: float, fell: bool = True) -> None:
        self.floor, self.fell = floor, fell

    def evaluate(self, u: Array) -> Equations:
        if u[0] < self.floor:
            raise OffCurveError("below the floor", fell=self.fell)
        return Equations(np.array([u @ u - 1.0]), 2.0 * u[np.newaxis], np.ones(1, complex), NOWHERE)


def start_of(circle: Circle) -> Solution:
    u, along = np.array([1.0, 0.0]), np.array([0.0, 1.0])
    return Solution(u, tangent_of(circle.evaluate(u).jacobian, along), circle.evaluate(u))


def window(step: float = 0.05, reach: float = np.inf, points: int = 1000) -> Window:
    return Window(np.array([-np.inf, -reach]), np.array([np.inf, reach]), step, points)


def test_a_circle_is_followed_through_its_folds_until_it_closes() -> None:
    circle = Circle(floor=-2.0)
    start = start_of(circle)

    def stop(here: Solution, there: Solution) -> tuple[CurveEnd, Solution | None] | None:
        closed = here.u is not start.u and passes(here, there, start.u)
        return (CurveEnd(EndReason.CLOSED, ""), start) if closed else None

    points, end = follow(circle, start, window(), stop)
    assert end.reason is EndReason.CLOSED
    us = np.array([point.u for point in points])
    np.testing.assert_allclose(np.linalg.norm(us, axis=1), 1.0, atol=1e-12)
    assert len(points) == pytest.approx(2 * np.pi / 0.05, rel=0.1)
    turning = next(i for i in range(1, len(points)) if points[i].u[1] < points[i - 1].u[1])
    fold = locate(circle, points[turning - 2], points[turning], lambda s: float(s.tangent[1]))
    np.testing.assert_allclose(fold.u, [0.0, 1.0], atol=1e-12)


def test_a_curve_ends_on_its_bound() -> None:
    circle = Circle(floor=-2.0)
    points, end = follow(circle, start_of(circle), window(reach=0.5), lambda here, there: None)
    assert end.reason is EndReason.BOUND
    np.testing.assert_allclose(points[-1].u, [np.sqrt(0.75), 0.5], atol=1e-12)


@pytest.mark.parametrize(("fell", "reason"), [(True, "FALL"), (False, "STEP_TOO_SMALL")])
def test_a_curve_is_followed_to_the_edge_of_its_domain(fell: bool, reason: str) -> None:
    circle = Circle(floor=0.6, fell=fell)
    points, end = follow(circle, start_of(circle), window(), lambda here, there: None)
    assert end == CurveEnd(EndReason[reason], "below the floor")
    np.testing.assert_allclose(points[-1].u, [0.6, 0.8], atol=1e-5)


def test_the_corrector_says_why_it_fails() -> None:
    circle = Circle(floor=-2.0)
    across = np.array([1.0, 0.0])
    with pytest.raises(OffCurveError, match="did not converge"):
        correct(circle, np.array([2.0, 0.1]), across, 2.0, across)  # the line misses the circle
    with pytest.raises(OffCurveError, match="singular"):
        correct(circle, np.array([1.0, 0.0]), across, 1.0, across)
