"""Pseudo-arclength: follow a curve of solutions of m equations in m + 1 unknowns.

Predict along the tangent, the null vector of the Jacobian; correct by Newton on the
equations bordered by t·u = level, which stays regular at folds (Keller 1977; Kuznetsov,
Elements of Applied Bifurcation Theory, section 10.2; Govaerts, Numerical Methods for
Bifurcations of Dynamical Equilibria, 2000).

Why our own: Python's continuation packages are for flows and discretised equations
(PyCont-Lite, bice, AUTO-07p), or take maps as source text and are no longer kept up
(PyDSTool). None takes a map as a function with its exact Jacobian.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from enum import Enum
from typing import NamedTuple, Protocol

import numpy as np
from scipy.optimize import brentq

from powered_walker_env.model.checks import whole_number
from powered_walker_env.poincare.families import Bounds, Equations, Family, OffCurveError
from powered_walker_env.simulation.derivatives import STATE_SIZE
from powered_walker_env.simulation.strides import Array

CORRECTIONS = 10  # Newton steps of a corrector before the step is called a failure
CONVERGED = 1e-12  # Newton step that ends the corrector at once
SETTLED = 1e-8  # ... or one below this that rounding keeps from shrinking fourfold
ASIDE = 0.5  # a correction longer than this share of the step may have left the curve
TURN = 0.2  # rad, most that the tangent may turn in a step
FAVOURED_TURN = 0.1  # rad, that the step length aims at
LONGEST_STEP = 0.02  # default, in units where the bounds' width is 1
SMALLEST_STEP = 1e-7
MAX_POINTS = 1000  # default, in each direction
CLOSE = 0.1  # share of a step: passing the first point nearer than this closes the loop
GROWTH = 1.6  # of the step, at most
SMALL_TURN = 1e-3  # rad, below which the step grows at its fastest


class EndReason(Enum):
    """Why a branch or a boundary goes no further."""

    BOUND = "bound"  # a parameter reached its bound; the last point lies on it
    FALL = "fall"  # beyond the last point the walker falls
    SCUFF = "scuff"  # the clearance after mid-swing came down to its limit
    STEP_TOO_SMALL = "step too small"  # the corrector fails however short the step
    MAX_POINTS = "max points"
    CLOSED = "closed loop"  # back at the first point
    DOUBLING = "period doubling"  # a doubled branch begins or ends at its parent's doubling
    STANDING = "standing"  # the steps shrink to nothing, as a passive walker's on level ground
    RESONANCE = "resonance"  # a Neimark-Sacker curve ends where its pair becomes ±1


class CurveEnd(NamedTuple):
    """Where a curve ends and why, in words."""

    reason: EndReason
    detail: str


class Curve(Protocol):
    """Equations whose solutions form a curve."""

    def evaluate(self, u: Array, /) -> Equations:
        """The equations at u; `OffCurveError` where there are none."""


class Solution(NamedTuple):
    """A point of the curve."""

    u: Array  # (m + 1,)
    tangent: Array  # (m + 1,) unit
    equations: Equations


class Window(NamedTuple):
    """Where to follow the curve: bounds of the unknowns (±inf for none), and how far."""

    low: Array
    high: Array
    step: float = LONGEST_STEP
    max_points: int = MAX_POINTS


def check_step(step: float | None) -> float:
    """The longest step, as a share of the bounds' widths; the usual one if left out.

    Raises:
        ValueError: a step that makes no sense.
    """
    if not 0.0 < (longest := LONGEST_STEP if step is None else float(step)) <= 1.0:
        raise ValueError(f"step must lie in (0, 1], a share of the bounds' width, got {step!r}")
    return longest


def window_of(
    family: Family,
    bounds: Sequence[Bounds],
    step: float | None,
    max_points: int,
    *,
    unbounded: int = 0,
) -> Window:
    """The window of a family within bounds of its parameters; `unbounded` more unknowns follow.

    Raises:
        ValueError: a step or a number of points that makes no sense.
    """
    longest = check_step(step)
    most = whole_number("max_points", max_points, 1)
    scaled = np.array(bounds) / family.scales[:, np.newaxis]
    state, more = np.full(STATE_SIZE, np.inf), np.full(unbounded, np.inf)
    low, high = [-state, scaled[:, 0], -more], [state, scaled[:, 1], more]
    return Window(np.concatenate(low), np.concatenate(high), longest, most)


Stop = Callable[[Solution, Solution], tuple[CurveEnd, Solution | None] | None]


def tangent_of(jacobian: Array, along: Array) -> Array:
    """The unit null vector of the (m, m + 1) Jacobian that points with `along`."""
    tangent: Array = np.linalg.qr(jacobian.T, mode="complete")[0][:, -1]
    return -tangent if tangent @ along < 0 else tangent


def correct(curve: Curve, u: Array, border: Array, level: float, along: Array) -> Solution:
    """The solution near u with border·u = level, to rounding.

    Raises:
        OffCurveError: Newton does not converge, or leaves the walkers that walk.
    """
    last = np.inf
    for _ in range(CORRECTIONS):
        equations = curve.evaluate(u)
        matrix = np.vstack([equations.jacobian, border])
        defect = np.append(equations.residual, border @ u - level)
        try:
            change = np.linalg.solve(matrix, defect)
        except np.linalg.LinAlgError as error:
            raise OffCurveError("the bordered Jacobian is singular") from error
        size = float(np.linalg.norm(change))
        if size < CONVERGED or (size < SETTLED and size > 0.25 * last):
            return Solution(u, tangent_of(equations.jacobian, along), equations)
        u, last = u - change, size
    raise OffCurveError(f"the corrector did not converge in {CORRECTIONS} steps")


def follow(
    curve: Curve, start: Solution, window: Window, stop: Stop
) -> tuple[list[Solution], CurveEnd]:
    """The curve from `start` along its tangent, the start left out, and why it ends.

    Args:
        stop: looks at each step (from, to); returns None to go on, or the end of the
            curve with its last point.
    """
    points: list[Solution] = []
    here, step = start, 0.1 * window.step
    while len(points) < window.max_points:
        try:
            there, end = _advance(curve, here, step, window)
            turn = _checked_turn(here, there, step)
        except OffCurveError as problem:
            step *= 0.5
            if step < SMALLEST_STEP:
                reason = EndReason.FALL if problem.fell else EndReason.STEP_TOO_SMALL
                return points, CurveEnd(reason, str(problem))
            continue
        stopped = stop(here, there)
        if stopped is not None:
            end, last = stopped
            return (points if last is None else [*points, last]), end
        if end is not None:
            at_start = np.linalg.norm(there.u - here.u) < SMALLEST_STEP
            return (points if at_start else [*points, there]), end
        points.append(there)
        here = there
        growth = GROWTH if turn < SMALL_TURN else min(GROWTH, max(0.5, FAVOURED_TURN / turn))
        step = min(step * growth, window.step)
    return points, CurveEnd(EndReason.MAX_POINTS, f"{window.max_points} points")


def _advance(
    curve: Curve, here: Solution, step: float, window: Window
) -> tuple[Solution, CurveEnd | None]:
    predicted = here.u + step * here.tangent
    bound = _crossed(predicted, window)
    if bound is None:
        level = float(here.tangent @ predicted)
        there = correct(curve, predicted, here.tangent, level, here.tangent)
        bound = _crossed(there.u, window)
        if bound is None:
            return there, None
        predicted = there.u
    component, value = bound
    share = (value - here.u[component]) / (predicted[component] - here.u[component])
    border = np.eye(len(here.u))[component]
    guess = here.u + share * (predicted - here.u)
    there = correct(curve, guess, border, value, here.tangent)
    other = _crossed(there.u, window)
    if other is not None and other[0] != component:
        raise OffCurveError("two bounds are crossed in one step")
    return there, CurveEnd(EndReason.BOUND, "")


def _crossed(u: Array, window: Window) -> tuple[int, float] | None:
    """The first unknown beyond its bound, and the bound."""
    for component in np.flatnonzero((u < window.low) | (u > window.high)):
        low, high = window.low[component], window.high[component]
        return int(component), float(low if u[component] < low else high)
    return None


def _checked_turn(here: Solution, there: Solution, step: float) -> float:
    """The angle between the tangents, rad; `OffCurveError` if this may be another curve."""
    moved = there.u - here.u
    ahead = float(here.tangent @ moved)
    aside = float(np.linalg.norm(moved - ahead * here.tangent))
    turn = float(np.arccos(np.clip(here.tangent @ there.tangent, -1.0, 1.0)))
    if not 0.0 <= ahead <= 1.5 * step or aside > ASIDE * step or turn > TURN:
        raise OffCurveError("the curve turns faster than the step can follow")
    return turn


def passes(here: Solution, there: Solution, u: Array) -> bool:
    """Whether the step from here to there passes the point u."""
    chord = there.u - here.u
    share = float(chord @ (u - here.u) / (chord @ chord))
    aside = float(np.linalg.norm(u - here.u - share * chord))
    return 0.0 < share <= 1.0 and aside < CLOSE * float(np.linalg.norm(chord))


def locate(
    curve: Curve, here: Solution, there: Solution, test: Callable[[Solution], float]
) -> Solution:
    """The solution between two neighbours where `test` changes sign, to rounding (Brent)."""
    span = float(here.tangent @ (there.u - here.u))
    found = {0.0: here, span: there}

    def value(s: float) -> float:
        if s not in found:
            guess = _between(here, there, s / span)
            level = float(here.tangent @ here.u) + s
            found[s] = correct(curve, guess, here.tangent, level, here.tangent)
        return test(found[s])

    value(root := float(brentq(value, 0.0, span, xtol=1e-14, rtol=1e-14)))
    return found[root]


def _between(here: Solution, there: Solution, share: float) -> Array:
    """Cubic Hermite interpolation along the chord."""
    chord = there.u - here.u
    length = float(np.linalg.norm(chord))
    a, b = here.tangent * length - chord, chord - there.tangent * length
    inner: Array = here.u + share * chord + share * (1 - share) * ((1 - share) * a + share * b)
    return inner
