"""Stability boundaries: folds, doublings and Neimark–Sacker points followed in two parameters.

Unknowns: the state, two parameters and, for a complex pair, its angle θ. Equations: the
gait closes, and the critical multiplier is μ = 1, −1 or e^{iθ}, said by the scalar g of

    [A − μ  b] [v]   [0]        [A − μ  b]ᴴ [w]   [0]
    [ cᴴ    0] [g] = [1],       [ cᴴ    0]  [h] = [1],

which vanishes exactly where A − μ is singular and is smooth there (Govaerts, Numerical
Methods for Bifurcations of Dynamical Equilibria, 2000, chapter 4; Kuznetsov, section
10.3). Its derivative is −wᴴ (∂A/∂z) v, and ∂A/∂z v is the derivative of the exact
Jacobian ∂f/∂z along v: one central difference of it for v real, two for v complex.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from powered_walker_env.model.powering import AnyControl
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
from powered_walker_env.poincare.branches.special_points import CRITICAL, SpecialKind, SpecialPoint
from powered_walker_env.poincare.families import (
    STATE_SIZE,
    Bounds,
    Equations,
    Family,
    family_within,
)
from powered_walker_env.poincare.gaits import Gait, describe
from powered_walker_env.poincare.maps import Policy
from powered_walker_env.simulation.strides import Array

DIFFERENCE = 1e-4  # natural units: of the exact Jacobian, along the critical vector
Complex = NDArray[np.complex128]


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


class _Bordered(NamedTuple):
    """g, and the vectors of its derivative."""

    g: complex
    v: Complex  # (4,)
    w: Complex  # (4,)


class _Critical:
    """The defining system of one kind of boundary; its borders move along with the curve."""

    def __init__(self, family: Family, kind: SpecialKind) -> None:
        self.family = family
        self.kind = kind
        self.complex = kind is SpecialKind.NEIMARK_SACKER
        self.b: Complex = np.zeros(STATE_SIZE, complex)
        self.c: Complex = np.zeros(STATE_SIZE, complex)

    def angle(self, u: Array) -> float:
        """θ of the critical multiplier, rad."""
        if self.complex:
            return float(u[-1])
        return 0.0 if self.kind is SpecialKind.FOLD else math.pi

    def _matrix(self, equations: Equations, u: Array) -> Complex:
        multiplier = np.exp(1j * self.angle(u)) if self.complex else math.cos(self.angle(u))
        A = equations.jacobian[:, :STATE_SIZE] + np.eye(STATE_SIZE)
        matrix: Complex = A - multiplier * np.eye(STATE_SIZE, dtype=complex)
        return matrix

    def renew_borders(self, equations: Equations, u: Array) -> None:
        """Take the singular vectors here as borders."""
        left, _, right = np.linalg.svd(self._matrix(equations, u))
        self.b, self.c = left[:, -1], right[-1].conj()

    def _solve(self, matrix: Complex) -> _Bordered:
        bordered = np.zeros((STATE_SIZE + 1, STATE_SIZE + 1), complex)
        bordered[:-1, :-1], bordered[:-1, -1], bordered[-1, :-1] = matrix, self.b, self.c.conj()
        last = np.eye(STATE_SIZE + 1)[-1].astype(complex)
        v, w = np.linalg.solve(bordered, last), np.linalg.solve(bordered.conj().T, last)
        return _Bordered(complex(v[-1]), v[:-1], w[:-1])

    def evaluate(self, u: Array) -> Equations:
        """Fixed point and criticality; the Jacobian by (state, p₁, p₂[, θ])."""
        plain = u[: STATE_SIZE + 2]
        equations = self.family.evaluate(plain)
        bordered = self._solve(self._matrix(equations, u))
        gradient = -bordered.w.conj() @ self._bent(plain, bordered.v)
        jacobian = equations.jacobian
        if not self.complex:
            residual = np.append(equations.residual, bordered.g.real)
            return equations._replace(
                residual=residual, jacobian=np.vstack([jacobian, gradient.real])
            )
        turn = 1j * np.exp(1j * u[-1]) * (bordered.w.conj() @ bordered.v)
        gradient = np.append(gradient, turn)
        jacobian = np.hstack([jacobian, np.zeros((STATE_SIZE, 1))])
        return equations._replace(
            residual=np.concatenate([equations.residual, [bordered.g.real, bordered.g.imag]]),
            jacobian=np.vstack([jacobian, gradient.real, gradient.imag]),
        )

    def _bent(self, u: Array, v: Complex) -> Complex:
        """(4, 6) derivative of the map's exact Jacobian along v."""
        bent = np.zeros((STATE_SIZE, STATE_SIZE + 2), complex)
        for part, unit in ((v.real, 1.0), (v.imag, 1j)):
            length = float(np.linalg.norm(part))
            if length < DIFFERENCE:
                continue  # v is real
            step = np.append(part * (DIFFERENCE / length), [0.0, 0.0])
            change = (
                self.family.evaluate(u + step).jacobian - self.family.evaluate(u - step).jacobian
            )
            bent += unit * change * (0.5 * length / DIFFERENCE)
        return bent


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
    if parameters[0] == parameters[1]:
        raise ValueError(f"parameters must be two different names, got {parameters!r}")
    family = family_within(point.gait, parameters, bounds)
    curve = _Critical(family, point.kind)
    window = window_of(family, bounds, step, max_points, unbounded=int(curve.complex))
    u = family.unknowns(point.state, family.current())
    if curve.complex:
        u = np.append(u, np.angle(point.critical_multiplier))
    curve.renew_borders(family.evaluate(u[: STATE_SIZE + 2]), u)
    forward = np.eye(len(u))[STATE_SIZE]
    tangent = tangent_of(curve.evaluate(u).jacobian, forward)
    start = correct(curve, u, tangent, float(tangent @ u), forward)

    def stop(here: Solution, there: Solution) -> tuple[CurveEnd, Solution | None] | None:
        if curve.complex and not 0.0 < curve.angle(there.u) < math.pi:
            return CurveEnd(EndReason.RESONANCE, "the pair becomes real"), None
        if here.u is not start.u and passes(here, there, start.u):
            return CurveEnd(EndReason.CLOSED, "back at the first point"), start
        curve.renew_borders(family.evaluate(there.u[: STATE_SIZE + 2]), there.u)
        return None

    ahead, end = follow(curve, start, window, stop)
    back: list[Solution] = []
    beginning = end
    if end.reason is not EndReason.CLOSED:
        curve.renew_borders(family.evaluate(start.u[: STATE_SIZE + 2]), start.u)
        back, beginning = follow(curve, start._replace(tangent=-start.tangent), window, stop)
    points = [*reversed(back), start, *ahead]
    return Boundary(
        params=point.gait.params,
        control=point.gait.control,
        kind=point.kind,
        parameters=parameters,
        period=point.period,
        bounds=bounds,
        values=np.array([family.values(p.u) for p in points]),
        states=np.array([family.state(p.u) for p in points]),
        multipliers=np.array([p.equations.multipliers for p in points]),
        angle=np.array([curve.angle(p.u) for p in points]),
        ends=(beginning, end),
    )
