"""The walker's equations once more, for other people's integrators and for counting flops.

Nothing here is shared with the package's kernels. With z = up + i·forward every vector is
a complex number (Camp 1997, Appendix B, in absolute angles: foot φ, stance leg α, swing
leg β); the swing is written out in real parts, so that floats, numba, symbolic
expressions and counting numbers can all go through the same lines. Conserving physics,
flat ground.
"""

from __future__ import annotations

import cmath
import functools
import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numba
import numpy as np
from numba.extending import register_jitable
from numpy.typing import NDArray

from powered_walker_env.model.powering import Control
from powered_walker_env.model.walker import CONSERVING, WalkerParams

Array = NDArray[np.float64]
Flow = Callable[[float, Array], Array]  # y' of scipy's solve_ivp
Guard = Callable[[float, Array], float]


class Constants(NamedTuple):
    """A walker under a control; symbols as in Camp 1997, Appendix A."""

    L: float  # m, ankle to hip
    D: float  # m, ankle to the centre of the foot
    R: float  # m, radius of the foot
    lock: float  # rad, ankle angle at the stop
    M: float  # kg, one leg
    I: float  # kg m², one leg about its centre of mass
    X: float  # m, centre of mass along the leg
    Y: float  # m, across it
    g_up: float  # m/s²
    g_forward: float  # m/s²
    stall: float  # N m
    damping: float  # 1/no-load speed, s/rad
    switch: float  # rad


class Equations(NamedTuple):
    """What an integrator needs for one stride."""

    swing: Flow  # foot locked: (α, β, α', β')
    switched: Guard  # its end, falling
    extension: Flow  # motor on: (φ, α, β, φ', α', β')
    landed: Guard  # its end, falling
    strike: Callable[[Array], Array]  # (6,) before to (4,) after


def constants(params: WalkerParams, control: Control) -> Constants:
    """The numbers in the equations.

    Raises:
        ValueError: a walker with the physics of the listing.
    """
    if params.physics != CONSERVING:
        raise ValueError(
            f"params.physics must be {CONSERVING!r} for a benchmark, got {params.physics!r}; "
            "the equations to compare with are those of the text"
        )
    return Constants(
        L=params.leg_length,
        D=params.foot_length,
        R=params.foot_radius,
        lock=params.locked_ankle_angle,
        M=params.leg_mass,
        I=params.leg_inertia,
        X=params.com_along,
        Y=params.com_across,
        g_up=params.gravity * math.cos(params.slope),
        g_forward=-params.gravity * math.sin(params.slope),
        stall=control.stall_torque,
        damping=1.0 / params.no_load_speed,
        switch=control.switch_angle,
    )


@register_jitable
def mass_and_load(c: Any, turns: Any, rates: Any) -> Any:
    """Mass matrix (00, 01, 02, 11, 12, 22) and load of gravity and rotation, (φ, α, β).

    Args:
        turns: cosine and sine of φ, α, β, one after another.
        rates: φ', α', β'.
    """
    cf, sf, ca, sa, cb, sb = turns
    df2, da2, db2 = rates[0] * rates[0], rates[1] * rates[1], rates[2] * rates[2]
    Fx, Fy = c.D * cf, c.D * sf  # ankle from the foot's centre, D e^{iφ}
    Px = c.R + Fx  # the same from the contact point: P = (Px, Fy)
    Ax, Ay = c.X * ca - c.Y * sa, c.X * sa + c.Y * ca
    Hx, Hy = c.L * ca, c.L * sa
    rest = c.L - c.X
    Bx, By = rest * cb + c.Y * sb, rest * sb - c.Y * cb
    Sx, Sy = Ax + Hx, Ay + Hy
    ax = c.g_up - Fx * df2  # what both legs feel
    ay = c.g_forward - Fy * df2
    pAx, pAy = ax - Ax * da2, ay - Ay * da2
    pBx, pBy = ax - Hx * da2 - Bx * db2, ay - Hy * da2 - By * db2
    tx, ty = pAx + pBx, pAy + pBy
    mass = (
        2.0 * c.M * (Px * Px + Fy * Fy),
        c.M * (Px * Sx + Fy * Sy),
        c.M * (Px * Bx + Fy * By),
        c.I + c.M * (c.X * c.X + c.Y * c.Y + c.L * c.L),
        c.M * (Hx * Bx + Hy * By),
        c.I + c.M * (rest * rest + c.Y * c.Y),
    )
    load = (
        c.M * (Px * ty - Fy * tx),
        c.M * (Ax * pAy - Ay * pAx + Hx * pBy - Hy * pBx),
        c.M * (Bx * pBy - By * pBx),
    )
    return mass, load


@register_jitable
def locked_accelerations(c: Any, turns: Any, rates: Any) -> Any:
    """α'' and β'' with the foot locked to the stance leg (φ' = α')."""
    (m00, m01, m02, m11, m12, m22), (b0, b1, b2) = mass_and_load(c, turns, rates)
    a, b, r = m00 + 2.0 * m01 + m11, m02 + m12, -(b0 + b1)
    share = b / a
    dd_swing = (-b2 - share * r) / (m22 - share * b)
    return (r - b * dd_swing) / a, dd_swing


@register_jitable
def free_accelerations(c: Any, turns: Any, rates: Any) -> Any:
    """φ'', α'' and β'' with the motor on: its torque falls with the ankle's speed."""
    (m00, m01, m02, m11, m12, m22), (b0, b1, b2) = mass_and_load(c, turns, rates)
    torque = c.stall * (1.0 + (rates[1] - rates[0]) * c.damping)
    r0, r1 = torque - b0, -torque - b1
    share1, share2 = m01 / m00, m02 / m00
    n11, n12, n22 = m11 - share1 * m01, m12 - share1 * m02, m22 - share2 * m02
    s1, s2 = r1 - share1 * r0, -b2 - share2 * r0
    share = n12 / n11
    z = (s2 - share * s1) / (n22 - share * n12)
    y = (s1 - n12 * z) / n11
    return (r0 - m01 * y - m02 * z) / m00, y, z


@register_jitable
def clearance(c: Any, turns: Any, turn_of_new_foot: Any) -> Any:
    """Height of the swing foot over flat ground, m, from cosines (the radius cancels)."""
    return c.D * (turns[0] + turn_of_new_foot) + c.L * (turns[2] + turns[4])


@register_jitable
def _turns(phi: float, alpha: float, beta: float) -> Any:
    return (
        math.cos(phi), math.sin(phi), math.cos(alpha), math.sin(alpha),
        math.cos(beta), math.sin(beta),
    )  # fmt: skip


@register_jitable
def _momenta(c: Any, angles: Any, rates: Any, about: complex, trailing_is_stance: bool) -> Any:
    """Angular momentum of the walker about a point of the floor, of one leg about the hip."""
    P = c.R + c.D * cmath.exp(1j * angles[0])  # ankle from the contact point
    A = (c.X + 1j * c.Y) * cmath.exp(1j * angles[1])
    H = c.L * cmath.exp(1j * angles[1])
    B = (c.L - c.X - 1j * c.Y) * cmath.exp(1j * angles[2])
    v_ankle = 1j * rates[0] * P
    v_a = v_ankle + 1j * rates[1] * A
    v_b = v_ankle + 1j * rates[1] * H + 1j * rates[2] * B
    whole = c.I * (rates[1] + rates[2])
    whole += c.M * ((P + A - about).conjugate() * v_a).imag
    whole += c.M * ((P + H + B - about).conjugate() * v_b).imag
    if trailing_is_stance:
        return whole, c.M * ((A - H).conjugate() * v_a).imag + c.I * rates[1]
    return whole, c.M * (B.conjugate() * v_b).imag + c.I * rates[2]


@functools.lru_cache(maxsize=8)  # of compiled functions
def equations(c: Constants, *, jitted: bool) -> Equations:
    """The functions of one stride with a walker's numbers in them, in Python or compiled."""
    compiled: Any = numba.njit(error_model="numpy") if jitted else lambda function: function

    def swing(_: float, y: Array) -> Array:
        turns = _turns(y[0] - c.lock, y[0], y[1])
        dda, ddb = locked_accelerations(c, turns, (y[2], y[2], y[3]))
        return np.array([y[2], y[3], dda, ddb])

    def switched(_: float, y: Array) -> float:
        return float(y[1] - y[0] - c.switch)

    def extension(_: float, y: Array) -> Array:
        turns = _turns(y[0], y[1], y[2])
        ddf, dda, ddb = free_accelerations(c, turns, (y[3], y[4], y[5]))
        return np.array([y[3], y[4], y[5], ddf, dda, ddb])

    def landed(_: float, y: Array) -> float:
        return float(clearance(c, _turns(y[0], y[1], y[2]), math.cos(y[2] - c.lock)))

    def strike(y: Array) -> Array:
        phi, alpha, beta = y[0], y[1], y[2]
        foot_to_foot = c.D * (math.sin(phi) + math.sin(beta - c.lock))
        foot_to_foot += c.L * (math.sin(alpha) + math.sin(beta))
        before = (y[3], y[4], y[5])
        whole, leg = _momenta(c, (phi, alpha, beta), before, 1j * foot_to_foot, True)
        a = beta - math.pi
        after = (a - c.lock, a, alpha + math.pi)
        w1, l1 = _momenta(c, after, (1.0, 1.0, 0.0), 0j, False)
        w2, l2 = _momenta(c, after, (0.0, 0.0, 1.0), 0j, False)
        determinant = w1 * l2 - w2 * l1
        rates = (whole * l2 - w2 * leg) / determinant, (w1 * leg - whole * l1) / determinant
        return np.array([a, alpha, rates[0], rates[1]])

    return Equations(*(compiled(f) for f in (swing, switched, extension, landed, strike)))
