"""The walker with a free swing knee once more: Kane's method, point velocities, scipy.

Bodies of the thesis's description (`derivation.py`) with the swing leg in two: t (thigh) turned by
q3 from the stance leg, s (shank) by the knee's flexion q4 from the thigh; the ankle is locked.
The thigh is worked out here from leg and shank. Nothing comes from the package but the names of a
walker's parameters.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple

import numpy as np
import sympy as sp
from scipy.integrate import solve_ivp
from sympy.physics.mechanics import (
    KanesMethod,
    Point,
    ReferenceFrame,
    RigidBody,
    dynamicsymbols,
    inertia,
)

from powered_walker_env.model.powering.motor import Control
from powered_walker_env.model.state import PostStrikeState
from powered_walker_env.model.walker import WalkerParams
from tests.helpers import second_integrator as straight
from tests.helpers.derivation import STANCE_LEG as STANCE
from tests.helpers.derivation import Array, hip_spring, kinematics, locked_system

SYMBOLS = sp.symbols("L D R X Y M I g slope lock d m_t x_t y_t I_t m_s x_s y_s I_s")
HIP_TORQUE = sp.Symbol("tau_hip")


class Segments(NamedTuple):
    """Thigh and shank: length of the thigh; mass, place from the upper joint (along the link from
    hip to foot, and across it as the stance leg has it), inertia about the centre of mass."""

    d: float
    thigh: tuple[float, float, float, float]
    shank: tuple[float, float, float, float]


def segments(params: WalkerParams) -> Segments:
    """The swing leg in two."""
    knee = params.knee
    assert knee is not None
    length, M = params.leg_length, params.leg_mass
    m, mt = knee.shank_mass, M - knee.shank_mass
    leg = np.array([params.com_along, params.com_across])
    shank = np.array([knee.shank_com_along, knee.shank_com_across])
    thigh = (M * leg - m * shank) / mt
    spin = params.leg_inertia + M * leg @ leg - knee.shank_inertia - m * shank @ shank
    d = length - knee.shank_length
    return Segments(
        d,
        (mt, length - thigh[0], thigh[1], spin - mt * thigh @ thigh),
        (m, knee.shank_length - shank[0], shank[1], knee.shank_inertia),
    )


def values(params: WalkerParams) -> tuple[float, ...]:
    """The numbers for `SYMBOLS`."""
    p, split = params, segments(params)
    return (
        p.leg_length, p.foot_length, p.foot_radius, p.com_along, p.com_across, p.leg_mass,
        p.leg_inertia, p.gravity, p.slope, p.locked_ankle_angle, split.d, *split.thigh,
        *split.shank,
    )  # fmt: skip


@cache
def _kane() -> Callable[..., Any]:
    """Mass matrix and forcing of Fr + Fr* = 0 in the speeds (u1, u3, u4)."""
    L, D, R, X, Y, M, I, g, slope, lock, d, mt, xt, yt, It, ms, xs, ys, Is = SYMBOLS
    q1, q3, q4 = q = dynamicsymbols("q1 q3 q4")
    u1, u3, u4 = u = dynamicsymbols("u1 u3 u4")
    n = ReferenceFrame("n")
    f = n.orientnew("f", "Axis", [q1, n.z])
    a = f.orientnew("a", "Axis", [lock, f.z])
    t = a.orientnew("t", "Axis", [q3, a.z])
    s = t.orientnew("s", "Axis", [q4, t.z])
    for frame, rate in ((f, u1), (a, u1), (t, u1 + u3), (s, u1 + u3 + u4)):
        frame.set_ang_vel(n, rate * n.z)
    centre = Point("c")
    centre.set_vel(n, R * u1 * n.y)
    ankle = centre.locatenew("ankle", D * f.x)
    hip = ankle.locatenew("hip", L * a.x)
    knee = hip.locatenew("knee", d * t.x)
    com_a = ankle.locatenew("com_a", X * a.x + Y * a.y)
    com_t = hip.locatenew("com_t", xt * t.x - yt * t.y)
    com_s = knee.locatenew("com_s", xs * s.x - ys * s.y)
    for point, of, frame in (
        (ankle, centre, f), (hip, ankle, a), (knee, hip, t),
        (com_a, ankle, a), (com_t, hip, t), (com_s, knee, s),
    ):  # fmt: skip
        point.v2pt_theory(of, n, frame)
    bodies = [
        RigidBody(name, com, frame, mass, (inertia(frame, 0, 0, spin), com))
        for name, com, frame, mass, spin in (
            ("a", com_a, a, M, I), ("t", com_t, t, mt, It), ("s", com_s, s, ms, Is),
        )
    ]  # fmt: skip
    down = -g * (sp.cos(slope) * n.x - sp.sin(slope) * n.y)
    loads: list[Any] = [(com, mass * down) for com, mass in ((com_a, M), (com_t, mt), (com_s, ms))]
    loads += [(t, HIP_TORQUE * n.z), (a, -HIP_TORQUE * n.z)]
    rates = [angle.diff() - speed for angle, speed in zip(q, u, strict=True)]
    kane = KanesMethod(n, q_ind=list(q), u_ind=list(u), kd_eqs=rates)
    kane.kanes_equations(bodies, loads)
    arguments = [*q, *u, HIP_TORQUE, *SYMBOLS]
    return sp.lambdify(arguments, [kane.mass_matrix, kane.forcing], modules="numpy", cse=True)


def bent_system(q: Array, u: Array, params: WalkerParams, hip: float = 0.0) -> tuple[Array, Array]:
    """Kane's mass matrix (3×3) and forcing (3) in (u1, u3, u4); with the hip's spring."""
    torque = hip + hip_spring(q[1], params)
    matrix, forcing = _kane()(*q, *u, torque, *values(params))
    return np.asarray(matrix, float), np.asarray(forcing, float).ravel()


class Masses(NamedTuple):
    """The three bodies: places, velocities (n1, n2), rates; and the hip and the contact point."""

    place: Array  # (3, 2) stance leg, thigh, shank
    velocity: Array
    rate: Array  # (3,)
    hip: Array
    hip_velocity: Array
    contact: Array
    mass: Array
    spin: Array


def masses(q: Array, u: Array, params: WalkerParams) -> Masses:
    """Where the bodies are and how they move, from geometry alone; q = (q1, q3, q4)."""
    split, lock = segments(params), params.locked_ankle_angle
    stance = kinematics([q[0], lock, q[1]], [u[0], 0.0, u[1]], params)

    def placed(angle: float, rate: float, along: float, across: float) -> tuple[Array, Array]:
        cosine, sine = math.cos(angle), math.sin(angle)
        arm = np.array([along * cosine + across * sine, along * sine - across * cosine])
        return arm, rate * np.array([-arm[1], arm[0]])

    thigh, shank = q[0] + lock + q[1], q[0] + lock + q[1] + q[2]
    thigh_rate, shank_rate = u[0] + u[1], u[0] + u[1] + u[2]
    hip, hip_velocity = stance.position[2], stance.velocity[2]
    arm_t, turning_t = placed(thigh, thigh_rate, *split.thigh[1:3])
    arm_k, turning_k = placed(thigh, thigh_rate, split.d, 0.0)
    arm_s, turning_s = placed(shank, shank_rate, *split.shank[1:3])
    return Masses(
        np.array([stance.position[STANCE], hip + arm_t, hip + arm_k + arm_s]),
        np.array(
            [stance.velocity[STANCE], hip_velocity + turning_t,
             hip_velocity + turning_k + turning_s]
        ),
        np.array([u[0], thigh_rate, shank_rate]),
        hip,
        hip_velocity,
        np.array([0.0, params.foot_radius * q[0]]),
        np.array([params.leg_mass, split.thigh[0], split.shank[0]]),
        np.array([params.leg_inertia, split.thigh[3], split.shank[3]]),
    )  # fmt: skip


def momentum(about: Array, bodies: Masses, which: list[int]) -> float:
    """Angular momentum of some of the bodies about a point."""
    arm, velocity = bodies.place[which] - about, bodies.velocity[which]
    orbital = bodies.mass[which] * (arm[:, 0] * velocity[:, 1] - arm[:, 1] * velocity[:, 0])
    return float(np.sum(orbital + bodies.spin[which] * bodies.rate[which]))


def kept_at_knee_strike(q: Array, u: Array, params: WalkerParams) -> Array:
    """The walker's momentum about the contact point, the swing leg's about the hip."""
    bodies = masses(q, u, params)
    return np.array(
        [momentum(bodies.contact, bodies, [0, 1, 2]), momentum(bodies.hip, bodies, [1, 2])]
    )


def knee_strike(q: Array, u: Array, params: WalkerParams) -> Array:
    """(u1, u3, 0) that keep the two momenta."""
    columns = [kept_at_knee_strike(q, one, params) for one in np.eye(3)[:2]]
    u1, u3 = np.linalg.solve(np.column_stack(columns), kept_at_knee_strike(q, u, params))
    return np.array([u1, u3, 0.0])


def energy(q: Array, u: Array, params: WalkerParams) -> float:
    """Kinetic and potential energy, the hip spring's included."""
    bodies = masses(q, u, params)
    up = np.array([math.cos(params.slope), -math.sin(params.slope)])
    kinetic = 0.5 * np.sum(bodies.mass * np.sum(bodies.velocity**2, axis=1))
    kinetic += 0.5 * np.sum(bodies.spin * bodies.rate**2)
    potential = params.gravity * bodies.mass @ (bodies.place @ up)
    return float(kinetic + potential + 0.5 * params.hip_stiffness * (q[1] - math.pi) ** 2)


class KneedStride(NamedTuple):
    """A stride by the second integrator."""

    state: PostStrikeState
    struck: float  # s, knee strike
    landing: straight.Landing


def bent_swing(
    state: PostStrikeState, params: WalkerParams, flexing: float = 0.0
) -> tuple[float, Array, Array]:
    """The swing with a free knee until it strikes: time, (q1, q3, q4) and their rates.

    The swing leg of the state is its thigh; the knee begins to flex at `flexing` rad/s.
    """
    start = np.array([
        state.stance_angle - params.locked_ankle_angle,
        state.swing_angle + math.pi - state.stance_angle, 0.0,
        state.stance_rate, state.swing_rate - state.stance_rate, flexing,
    ])  # fmt: skip

    def flow(_: float, y: Array) -> Array:
        return np.concatenate([y[3:], np.linalg.solve(*bent_system(y[:3], y[3:], params))])

    def strike(t: float, y: Array) -> float:
        return 1.0 if t == 0.0 else float(y[2])

    strike.terminal, strike.direction = True, -1  # type: ignore[attr-defined]
    solution = solve_ivp(flow, (0.0, 10.0), start, events=strike, **straight.TOLERANCES)
    assert solution.status == 1, "the knee did not strike"
    y = solution.y[:, -1]
    return float(solution.t[-1]), y[:3], y[3:]


def stride_with_knees(
    state: PostStrikeState, control: Control | None, params: WalkerParams
) -> KneedStride:
    """A whole stride of a conserving walker with knees on flat ground, passive or with a motor."""
    t, q, u = bent_swing(state, params)
    u1, u3, _ = knee_strike(q, u, params)
    y = np.array([q[0], q[1], u1, u3])
    if control is None:
        landing = passive_landing(t, y, params)
    else:
        switched, y = straight.until_switch(t, y, control, params)
        landing = straight.extension(switched, y, control, params)
    return KneedStride(straight.strike(landing, params), t, landing)


def passive_landing(t: float, start: Array, params: WalkerParams) -> straight.Landing:
    """The straight swing until the foot falls through the floor ahead."""
    lock = params.locked_ankle_angle

    def flow(_: float, y: Array) -> Array:
        mass, force = locked_system([y[0], lock, y[1]], [y[2], 0.0, y[3]], params)
        return np.concatenate([y[2:], np.linalg.solve(mass, force)])

    def landing(_: float, y: Array) -> float:
        return straight.height(np.array([y[0], lock, y[1]]), params)

    landing.direction = -1  # type: ignore[attr-defined]
    solution = solve_ivp(flow, (t, t + 10.0), start, events=landing, **straight.TOLERANCES)
    for time, y in zip(solution.t_events[0], solution.y_events[0], strict=True):
        if y[1] < math.pi:
            q, u = np.array([y[0], lock, y[1]]), np.array([y[2], 0.0, y[3]])
            return straight.Landing(float(time), q, u)
    raise AssertionError("the swing foot did not land")
