"""The equations of a stability boundary: a gait with a multiplier on the unit circle.

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
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from powered_walker_env.poincare.branches.special_points import SpecialKind
from powered_walker_env.poincare.families import Equations, Family
from powered_walker_env.simulation.derivatives import STATE_SIZE
from powered_walker_env.simulation.strides import Array

DIFFERENCE = 1e-4  # natural units: of the exact Jacobian, along the critical vector
Complex = NDArray[np.complex128]


class _Bordered(NamedTuple):
    """g, and the vectors of its derivative."""

    g: complex
    v: Complex  # (4,)
    w: Complex  # (4,)


class Critical:
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
