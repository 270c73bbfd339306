"""Cascades: one period doubling after another, to chaos (Feigenbaum 1978).

The gait of 2^k strides, born at the k-th doubling, is stable up to the next one. Near its
birth the branch bends on a scale that shrinks by Feigenbaum's α² = 6.26 each time, so it is
not followed: the walker is let walk where the gait is stable, until it has settled;
Newton makes a gait of that, and the next doubling is where a multiplier of the gait,
followed by its slope in the parameter, becomes −1. The intervals shrink by δ = 4.6692...,
which says where to look.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, field

import numpy as np
from scipy.optimize import brentq

from powered_walker_env.model.checks import whole_number
from powered_walker_env.model.state import natural_units
from powered_walker_env.poincare.branches.continuation import continue_gait, switch_branch
from powered_walker_env.poincare.branches.special_points import SpecialKind, SpecialPoint
from powered_walker_env.poincare.families import Bounds, Equations, Family, OffCurveError, value_of
from powered_walker_env.poincare.fixed_points import newton
from powered_walker_env.poincare.gaits import Gait, GaitNotFoundError, describe
from powered_walker_env.poincare.tolerances import SETTLING
from powered_walker_env.simulation.derivatives import STATE_SIZE
from powered_walker_env.simulation.strides import Array

DELTA = 4.669201609102991  # Feigenbaum's: the ratio of successive intervals tends to it
STABLE_PART = 0.45  # of an interval: about where the gait is most stable, so settles soonest
FIRST_STEP = 0.3  # of the expected interval, of the search for the next doubling
MAX_STEPS = 24
LOCATED = 1e-13  # of the parameter's value
APART = 1e-7  # natural units: nearer than this, the halves of a cycle are one


@dataclass(frozen=True, eq=False)
class Cascade:
    """Successive period doublings along one parameter."""

    parameter: str
    values: tuple[float, ...]  # where the gaits of 1, 2, 4 ... strides double
    gaits: tuple[Gait, ...] = field(repr=False)  # there: of 1, 2, 4 ... strides
    stopped: str  # why there are no more; empty if no more were asked for

    @property
    def ratios(self) -> tuple[float, ...]:
        """Each interval over the next; they tend to Feigenbaum's 4.6692."""
        widths = [b - a for a, b in itertools.pairwise(self.values)]
        return tuple(a / b for a, b in itertools.pairwise(widths))


def doubling_cascade(
    gait: Gait, parameter: str, bounds: Bounds, *, doublings: int = 6, step: float | None = None
) -> Cascade:
    """The doublings that follow one another from a gait's first loss of stability.

    Args:
        gait: a stable gait.
        parameter: any name of `PARAMETERS` that the walker has.
        bounds: of the parameter; they must hold the gait and the first two doublings.
        doublings: how many to look for; rounding ends a cascade after eight or so.
        step: of the first two branches, as in `continue_gait`.

    Raises:
        GaitNotFoundError: the gait's branch has no doubling that ends its stability.
        ValueError: bad arguments, as `continue_gait`.
    """
    doublings = whole_number("doublings", doublings, 1)
    points, stopped = _followed(gait, parameter, bounds, min(doublings, 2), step)
    if not points:
        raise GaitNotFoundError(f"{stopped}; give wider bounds, or a gait nearer to its doubling")
    values, gaits = [point.value for point in points], [point.gait for point in points]
    while len(values) < doublings and not stopped:
        try:
            value, found = _next(gait, parameter, values, gaits[-1])
        except OffCurveError as problem:
            stopped = str(problem)
        else:
            values.append(value)
            gaits.append(found)
    return Cascade(parameter, tuple(values), tuple(gaits), stopped)


def _followed(
    gait: Gait, parameter: str, bounds: Bounds, wanted: int, step: float | None
) -> tuple[list[SpecialPoint], str]:
    """The first doublings, along the branches themselves; and why there are fewer."""
    points: list[SpecialPoint] = []
    near = value_of(gait.params, gait.control, parameter)
    branch = continue_gait(gait, parameter, bounds, step=step)
    while True:
        ends = [p for p in branch.of_kind(SpecialKind.PERIOD_DOUBLING) if p.limits_stability]
        if not ends:
            return points, f"no doubling of {branch.period} strides between the bounds {bounds}"
        points.append(min(ends, key=lambda point: abs(point.value - near)))
        if len(points) == wanted:
            return points, ""
        near = points[-1].value
        try:
            branch = switch_branch(points[-1], bounds, step=step)
        except GaitNotFoundError as problem:
            return points, str(problem)


class _Tracker:
    """The gait of one period as the parameter moves, always from the last one found."""

    def __init__(self, gait: Gait, parameter: str, period: int) -> None:
        self.family = Family(gait.params, gait.control, (parameter,), np.ones(1), period)
        self.units = natural_units(gait.params)
        self.value, self.state, self.slope = math.nan, np.empty(0), np.zeros(STATE_SIZE)

    def settle(self, value: float, state: Array) -> None:
        """Walk at `value` until the motion repeats, then find its gait.

        Raises:
            OffCurveError: the walker falls, or settles on something else.
        """
        stride_map, period = self.family.stride_map(np.array([value])), self.family.period
        walked = stride_map(state[np.newaxis], SETTLING * period)[0]
        if not np.isfinite(walked).all():
            raise OffCurveError(f"the walker falls at {self.family.names[0]} = {value!r}")
        found, reason = newton(stride_map, walked, period)
        if found is None:
            raise OffCurveError(f"no gait of {period} strides at {value!r}: {reason}")
        later = stride_map(found[np.newaxis], period // 2)[0]
        if np.linalg.norm((later - found) / self.units) < APART:
            raise OffCurveError(f"the gait of {period} strides is not told from its half any more")
        self.value, self.state = value, found
        self._differentiate()

    def test(self, value: float) -> float:
        """det(A + 1) of the gait at `value`: zero at a doubling.

        Raises:
            OffCurveError: no gait is found there.
        """
        guess = self.state + self.slope * (value - self.value)
        found, reason = newton(self.family.stride_map(np.array([value])), guess, self.family.period)
        if found is None:
            raise OffCurveError(f"the gait is lost at {value!r}: {reason}")
        self.value, self.state = value, found
        return float(np.prod(self._differentiate().multipliers + 1.0).real)

    def _differentiate(self) -> Equations:
        equations = self.family.evaluate(self.family.unknowns(self.state, [self.value]))
        by_state = equations.jacobian[:, :STATE_SIZE]
        by_value = equations.jacobian[:, STATE_SIZE]
        self.slope = -np.linalg.solve(by_state, by_value) * self.units
        return equations

    def gait(self, section: str) -> Gait:
        """The gait as it stands."""
        stride_map = self.family.stride_map(np.array([self.value]))
        return describe(stride_map, self.state, section, self.family.period)


def _next(gait: Gait, parameter: str, values: list[float], last: Gait) -> tuple[float, Gait]:
    """The doubling after the last of `values`, expected δ times nearer than that was, and
    the gait there.

    Raises:
        OffCurveError: none is found.
    """
    expected = (values[-1] - values[-2]) / DELTA
    tracker = _Tracker(gait, parameter, 2 * last.period)
    start = values[-1] + STABLE_PART * expected
    tracker.settle(start, np.array(last.state) * (1.0 + 1e-4))
    low, below = start, tracker.test(start)
    for _ in range(MAX_STEPS):
        high = low + FIRST_STEP * expected
        above = tracker.test(high)
        if below * above <= 0.0:
            root = float(brentq(tracker.test, low, high, xtol=LOCATED * abs(high), rtol=1e-15 * 4))
            tracker.test(root)
            return root, tracker.gait(last.section)
        low, below = high, above
    raise OffCurveError(f"no doubling of {2 * last.period} strides up to {low!r}")
