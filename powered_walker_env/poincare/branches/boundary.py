"""Stability boundaries: folds, doublings and Neimark–Sacker points followed in two parameters.

`critical.py` has the equations. A boundary is followed from a special point of a branch,
both ways; `stability_boundaries` follows those from every point where a gait's branch
loses its stability.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple, Unpack

import numpy as np
from numpy.typing import NDArray

from powered_walker_env.model.powering import AnyControl, Policy
from powered_walker_env.model.walker import WalkerParams
from powered_walker_env.poincare.branches.arclength import (
    MAX_POINTS,
    CurveEnd,
    EndReason,
    Solution,
    correct,
    follow,
    passes,
    tangent_of,
    window_of,
)
from powered_walker_env.poincare.branches.continuation import continue_gait
from powered_walker_env.poincare.branches.critical import Complex, Critical
from powered_walker_env.poincare.branches.special_points import CRITICAL, SpecialKind, SpecialPoint
from powered_walker_env.poincare.families import Bounds, Family, family_within, value_of
from powered_walker_env.poincare.gaits import Gait, GaitNotFoundError, describe
from powered_walker_env.poincare.work.pieces import RunOptions, run_pieces
from powered_walker_env.simulation.derivatives import STATE_SIZE
from powered_walker_env.simulation.strides import Array

BULGE = 0.05  # of a chord's length, that the curve may lie beside it: it turns 0.2 rad at most


@dataclass(frozen=True, eq=False)
class Boundary:
    """Where one multiplier is on the unit circle, as a curve in the plane of two parameters."""

    params: WalkerParams  # of the gait that the curve was started from
    control: AnyControl | Policy | None
    kind: SpecialKind
    parameters: tuple[str, str]
    period: int  # strides
    bounds: tuple[Bounds, Bounds]
    values: Array  # (n, 2) of the parameters
    states: Array = field(repr=False)  # (n, 4) post-strike
    multipliers: Complex = field(repr=False)  # (n, 4) largest first
    angle: Array = field(repr=False)  # (n,) rad, of the critical multiplier: 0, π or between
    ends: tuple[CurveEnd, CurveEnd]  # why it goes no further, before the first and after the last

    def __len__(self) -> int:
        """Number of points."""
        return len(self.values)

    @property
    def limits_stability(self) -> NDArray[np.bool_]:
        """(n,) whether every other multiplier is inside, so that this is the edge of stability."""
        critical = np.exp(1j * self.angle)[:, np.newaxis]
        distance = np.minimum(
            abs(self.multipliers - critical), abs(self.multipliers - critical.conj())
        )
        inside: NDArray[np.bool_] = ((abs(self.multipliers) < 1.0) | (distance < CRITICAL)).all(
            axis=1
        )
        return inside

    def gait(self, index: int) -> Gait:
        """The marginal gait at a point of the curve, post-strike section."""
        family = Family(self.params, self.control, self.parameters, np.ones(2), self.period)
        stride_map = family.stride_map(self.values[index])
        return describe(stride_map, self.states[index], "post-strike", self.period)


class HalfBoundary(NamedTuple):
    """A boundary one way from its special point, which is the first row."""

    values: Array  # the columns of `Boundary`
    states: Array
    multipliers: Complex
    angle: Array
    end: CurveEnd

    def turned(self) -> HalfBoundary:
        """From its end up to the special point, that left out."""
        back = slice(None, 0, -1)
        return HalfBoundary(
            self.values[back], self.states[back], self.multipliers[back], self.angle[back], self.end
        )


class _Way(NamedTuple):
    """A piece of work: a boundary to be followed one way."""

    point: SpecialPoint
    parameters: tuple[str, str]
    bounds: tuple[Bounds, Bounds]
    step: float | None
    max_points: int
    sense: float  # 1: the first parameter rises at first; −1: it falls


def continue_boundary(
    point: SpecialPoint,
    parameters: tuple[str, str],
    bounds: tuple[Bounds, Bounds],
    *,
    step: float | None = None,
    max_points: int = MAX_POINTS,
) -> Boundary:
    """Follow a fold, doubling or Neimark–Sacker point in two parameters, both ways.

    Args:
        point: from `Branch.special_points`.
        parameters: two names of `PARAMETERS`.
        bounds: (low, high) of each; their distances are the units of arclength.
        step: longest arclength between two points; 0.02 if left out.
        max_points: most points in each direction.

    Raises:
        ValueError: unknown or equal parameters, bounds that do not hold the point.
    """
    way = _Way(point, parameters, bounds, step, max_points, 1.0)
    ahead = half_boundary(way)
    closed = ahead.end.reason is EndReason.CLOSED
    return _joined(way, ahead, None if closed else half_boundary(way._replace(sense=-1.0)))


def stability_boundaries(
    gait: Gait,
    parameters: tuple[str, str],
    bounds: tuple[Bounds, Bounds],
    *,
    step: float | None = None,
    max_points: int = MAX_POINTS,
    **run: Unpack[RunOptions],
) -> tuple[Boundary, ...]:
    """The boundaries through all points at which a gait loses its stability in one parameter.

    Args:
        gait: whose branch along the second parameter has the points.
        run: where it runs, see `run_pieces`; each way from each point is a piece.
        The rest as in `continue_boundary`.

    Returns:
        The curves, each once though it may pass through several of the points.

    Raises:
        GaitNotFoundError: the branch has no such point; else as `continue_boundary`.
    """
    _check_different(parameters)
    family_within(gait, parameters, bounds)
    branch = continue_gait(gait, parameters[1], bounds[1])
    points = [point for point in branch.special_points if point.limits_stability]
    if not points:
        raise GaitNotFoundError(
            f"the gait's branch has no limit of stability for {parameters[1]} in "
            f"[{bounds[1][0]:g}, {bounds[1][1]:g}]; give wider bounds"
        )
    ways = [_Way(point, parameters, bounds, step, max_points, 1.0) for point in points]
    both = [way._replace(sense=sense) for way in ways for sense in (1.0, -1.0)]
    halves = run_pieces(half_boundary, both, **run)
    curves: list[Boundary] = []
    across = value_of(gait.params, gait.control, parameters[0])
    for way, ahead, back in zip(ways, halves[::2], halves[1::2], strict=True):
        start = np.array([across, way.point.value])
        if not any(_passes(curve, way.point.kind, start) for curve in curves):
            closed = ahead.end.reason is EndReason.CLOSED
            curves.append(_joined(way, ahead, None if closed else back))
    return tuple(curves)


def _check_different(parameters: tuple[str, str]) -> None:
    if len(parameters) != 2 or parameters[0] == parameters[1]:
        raise ValueError(f"parameters must be two different names, got {parameters!r}")


def half_boundary(way: _Way) -> HalfBoundary:
    """Follow a boundary one way."""
    point = way.point
    _check_different(way.parameters)
    family = family_within(point.gait, way.parameters, way.bounds)
    curve = Critical(family, point.kind)
    window = window_of(family, way.bounds, way.step, way.max_points, unbounded=int(curve.complex))
    u = family.unknowns(point.state, family.current())
    if curve.complex:
        u = np.append(u, np.angle(point.critical_multiplier))
    curve.renew_borders(family.evaluate(u[: STATE_SIZE + 2]), u)
    forward = np.eye(len(u))[STATE_SIZE]
    tangent = way.sense * tangent_of(curve.evaluate(u).jacobian, forward)
    start = correct(curve, u, tangent, float(tangent @ u), tangent)

    def stop(here: Solution, there: Solution) -> tuple[CurveEnd, Solution | None] | None:
        if curve.complex and not 0.0 < curve.angle(there.u) < np.pi:
            return CurveEnd(EndReason.RESONANCE, "the pair becomes real"), None
        if here.u is not start.u and passes(here, there, start.u):
            return CurveEnd(EndReason.CLOSED, "back at the first point"), start
        curve.renew_borders(family.evaluate(there.u[: STATE_SIZE + 2]), there.u)
        return None

    after, end = follow(curve, start, window, stop)
    points = [start, *after]
    return HalfBoundary(
        values=np.array([family.values(p.u) for p in points]),
        states=np.array([family.state(p.u) for p in points]),
        multipliers=np.array([p.equations.multipliers for p in points]),
        angle=np.array([curve.angle(p.u) for p in points]),
        end=end,
    )


def _joined(way: _Way, ahead: HalfBoundary, back: HalfBoundary | None) -> Boundary:
    """The two halves as one curve; of a closed one the first is all."""
    halves = [ahead] if back is None else [back.turned(), ahead]
    return Boundary(
        params=way.point.gait.params,
        control=way.point.gait.control,
        kind=way.point.kind,
        parameters=way.parameters,
        period=way.point.period,
        bounds=way.bounds,
        values=np.concatenate([half.values for half in halves]),
        states=np.concatenate([half.states for half in halves]),
        multipliers=np.concatenate([half.multipliers for half in halves]),
        angle=np.concatenate([half.angle for half in halves]),
        ends=(halves[0].end, ahead.end),
    )


def _passes(curve: Boundary, kind: SpecialKind, where: Array) -> bool:
    """Whether a curve already goes through a special point: curves may turn back."""
    widths = np.array([high - low for low, high in curve.bounds])
    corners = (curve.values - where) / widths
    steps = np.diff(corners, axis=0)
    lengths = np.maximum((steps**2).sum(axis=1), 1e-300)
    shares = np.clip(-(corners[:-1] * steps).sum(axis=1) / lengths, 0.0, 1.0)
    apart = np.linalg.norm(corners[:-1] + shares[:, np.newaxis] * steps, axis=1)
    return curve.kind is kind and bool((apart < BULGE * np.sqrt(lengths)).any())
