"""The walker once more, by Kane's method (Camp 1997, Appendix B), to test the kernels against.

The thesis's own description, given to sympy: bodies f (foot, massless), a (stance leg)
and b (swing leg), turned by the relative angles q1, q2, q3 about n3, with n1 up from
the floor and n2 forward; contact point o, foot centre c, ankle and hip; v_o = R q1' n2.
Nothing here comes from the package but the names of a walker's parameters.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple

import numpy as np
import sympy as sp
from numpy.typing import ArrayLike, NDArray
from sympy.physics.mechanics import (
    KanesMethod,
    Point,
    ReferenceFrame,
    RigidBody,
    dynamicsymbols,
    inertia,
)

from powered_walker_env.model.walker import WalkerParams

Array = NDArray[np.float64]

L, D, R, X, Y, M, I, G, SLOPE, LOCK, K = PARAMETERS = sp.symbols(
    "L D R X Y M I g slope q2lock k_hip"
)
TORQUE, HIP_TORQUE = sp.symbols("tau tau_hip")  # on foot and swing leg; back on the stance leg
TO_RELATIVE = np.array([[1.0, 0, 0], [-1, 1, 0], [0, -1, 1]])  # (q1, q2, q3) from (φ, α, β)
TO_ABSOLUTE = np.tril(np.ones((3, 3)))


def values(params: WalkerParams) -> tuple[float, ...]:
    """The numbers for `PARAMETERS`."""
    p = params
    leg = (p.leg_length, p.foot_length, p.foot_radius, p.com_along, p.com_across)
    weight = (p.leg_mass, p.leg_inertia, p.gravity, p.slope)
    return (*leg, *weight, p.locked_ankle_angle, p.hip_stiffness)


def _function(arguments: list[Any], expressions: Any) -> Callable[..., Any]:
    return sp.lambdify([*arguments, *PARAMETERS], expressions, modules="numpy", cse=True)


@cache
def _kane(locked: bool) -> Callable[..., Any]:
    """Mass matrix and right-hand side of Fr + Fr* = 0 in the speeds (u1, u2, u3) or (u1, u3)."""
    q1, q2, q3 = dynamicsymbols("q1:4")
    u1, u2, u3 = dynamicsymbols("u1:4")
    if locked:
        q2, u2 = sp.Symbol("q2"), sp.S.Zero
    n = ReferenceFrame("n")
    f = n.orientnew("f", "Axis", [q1, n.z])
    a = f.orientnew("a", "Axis", [q2, f.z])
    b = a.orientnew("b", "Axis", [q3, a.z])
    f.set_ang_vel(n, u1 * n.z)
    a.set_ang_vel(n, (u1 + u2) * n.z)
    b.set_ang_vel(n, (u1 + u2 + u3) * n.z)

    centre = Point("c")
    centre.set_vel(n, R * u1 * n.y)  # v_o, and the constant R n1 from o to c
    ankle = centre.locatenew("ankle", D * f.x)
    hip = ankle.locatenew("hip", L * a.x)
    com_a = ankle.locatenew("com_a", X * a.x + Y * a.y)
    com_b = hip.locatenew("com_b", (L - X) * b.x - Y * b.y)
    ankle.v2pt_theory(centre, n, f)
    hip.v2pt_theory(ankle, n, a)
    com_a.v2pt_theory(ankle, n, a)
    com_b.v2pt_theory(hip, n, b)
    legs = [
        RigidBody("a", com_a, a, M, (inertia(a, 0, 0, I), com_a)),
        RigidBody("b", com_b, b, M, (inertia(b, 0, 0, I), com_b)),
    ]

    weight = -M * G * (sp.cos(SLOPE) * n.x - sp.sin(SLOPE) * n.y)  # downhill is forward
    loads = [(com_a, weight), (com_b, weight), (f, TORQUE * n.z), (b, HIP_TORQUE * n.z)]
    loads += [(a, -(TORQUE + HIP_TORQUE) * n.z)]
    angles, speeds = ([q1, q3], [u1, u3]) if locked else ([q1, q2, q3], [u1, u2, u3])
    rates = [q.diff() - u for q, u in zip(angles, speeds, strict=True)]
    kane = KanesMethod(n, q_ind=angles, u_ind=speeds, kd_eqs=rates)
    kane.kanes_equations(legs, loads)
    torques = [TORQUE, HIP_TORQUE]
    return _function([q1, q2, q3, *speeds, *torques], [kane.mass_matrix, kane.forcing])


def hip_spring(q3: float, params: WalkerParams) -> float:
    """Torque on the swing leg of a spring that is slack with the legs side by side, q3 = π."""
    return float(params.hip_stiffness * (math.pi - q3))


def powered_system(
    q: ArrayLike, u: ArrayLike, torque: float, params: WalkerParams, hip: float = 0.0
) -> tuple[Array, Array]:
    """Kane's mass matrix (3×3) and forcing (3) in powered mode: matrix · u' = forcing.

    The hip's torque is `hip`, N m on the swing leg, and its spring's.
    """
    q = np.asarray(q)
    torques = torque, hip + hip_spring(q[2], params)
    matrix, forcing = _kane(False)(*q, *np.asarray(u), *torques, *values(params))
    return np.asarray(matrix), np.asarray(forcing).ravel()


def locked_system(
    q: ArrayLike, u: ArrayLike, params: WalkerParams, hip: float = 0.0
) -> tuple[Array, Array]:
    """The same with q2 held, in the speeds (u1, u3); `u` holds all three."""
    q, (u1, _, u3) = np.asarray(q), np.asarray(u)
    torques = 0.0, hip + hip_spring(q[2], params)
    matrix, forcing = _kane(True)(*q, u1, u3, *torques, *values(params))
    return np.asarray(matrix), np.asarray(forcing).ravel()


@cache
def _points() -> tuple[Callable[..., Any], Callable[..., Any]]:
    """Positions of the points in (n1, n2), their velocities; energies and gradient of the sum."""
    q1, q2, q3, u1, u2, u3 = state = sp.symbols("q1:4 u1:4")

    def flat(points: list[Any]) -> list[Any]:
        return [coordinate for point in points for coordinate in point]

    def turned(angle: Any, along: Any, across: Any = 0) -> Any:
        cosine, sine = sp.cos(angle), sp.sin(angle)
        return sp.Matrix([along * cosine - across * sine, along * sine + across * cosine])

    stance, swing = q1 + q2, q1 + q2 + q3
    centre = sp.Matrix([R, R * q1])  # rolling: the contact point has gone R q1 forward
    ankle = centre + turned(q1, D)
    hip = ankle + turned(stance, L)
    swing_ankle = hip + turned(swing, L)
    swing_centre = swing_ankle + turned(swing - LOCK, D)
    com_a = ankle + turned(stance, X, Y)
    com_b = hip + turned(swing, L - X, -Y)
    points = [centre, ankle, hip, swing_ankle, swing_centre, com_a, com_b]
    angles, speeds = sp.Matrix(state[:3]), sp.Matrix(state[3:])
    velocities = [point.jacobian(angles) * speeds for point in points]

    square = sum((v.T * v)[0] for v in velocities[-2:])
    kinetic = M * square / 2 + I * ((u1 + u2) ** 2 + (u1 + u2 + u3) ** 2) / 2
    up = sp.Matrix([sp.cos(SLOPE), -sp.sin(SLOPE)])
    potential = M * G * (up.T * (com_a + com_b))[0] + K * (q3 - sp.pi) ** 2 / 2
    gradient = [sp.diff(kinetic + potential, symbol) for symbol in state]
    moving = _function(list(state), [flat(points), flat(velocities)])
    return moving, _function(list(state), [kinetic, potential, gradient])


class Kinematics(NamedTuple):
    """Points of the walker as rows (n1, n2) from where the contact point is at q1 = 0.

    Rows: foot centre, ankle, hip, swing ankle, swing foot's centre, centres of mass of
    the stance and the swing leg.
    """

    position: Array
    velocity: Array


CENTRE, ANKLE, HIP, SWING_ANKLE, SWING_CENTRE, STANCE_LEG, SWING_LEG = range(7)


def kinematics(q: ArrayLike, u: ArrayLike, params: WalkerParams) -> Kinematics:
    """Positions and velocities of the points, from geometry alone; (7, 2, n) of n states (3, n)."""
    moving, many = _points()[0], np.shape(q)[1:]
    both = moving(*np.asarray(q), *np.asarray(u), *values(params))
    if many:  # some coordinates do not depend on the state
        both = [[np.broadcast_to(x, many) for x in each] for each in both]
    position, velocity = (np.reshape(each, (7, 2, *many)) for each in both)
    return Kinematics(position, velocity)


class Energies(NamedTuple):
    """Kinetic and potential energy, and the gradient of their sum over (q1..q3, u1..u3)."""

    kinetic: float
    potential: float
    gradient: Array


def energies(q: ArrayLike, u: ArrayLike, params: WalkerParams) -> Energies:
    """Σ ½M|v|² + ½Iω², and Σ M g·(height) with the hip spring's ½k(q3 − π)²."""
    result = _points()[1](*np.asarray(q), *np.asarray(u), *values(params))
    return Energies(result[0], result[1], np.asarray(result[2]))
