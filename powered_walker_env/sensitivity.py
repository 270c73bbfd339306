"""Derivatives of a stride, carried along with it.

The variational equations S' = (∂f/∂y) S + ∂f/∂p are stepped through the stages of every
accepted step, so that S is the derivative of the very walk that is taken. At an event
the saltation matrix corrects for the event's time moving: with the guard g and the flow
f⁻ before and f⁺ after, dt = −(∇g·S + ∂g/∂p)/ġ and S⁺ = S + (f⁻ − f⁺) dt (Leine and
Nijmeijer, Dynamics and Bifurcations of Non-Smooth Mechanical Systems, 2004, chapter 7);
a reset R gives ∂R/∂y (S + f⁻ dt) + ∂R/∂p.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from powered_walker_env.compilation import kernel
from powered_walker_env.integrator import DIMENSION, STAGE_WEIGHTS, STAGES, WEIGHTS
from powered_walker_env.physics.actuation import LOCKED, MOTOR, flow
from powered_walker_env.physics.ground import LANDING, SWITCH_ANGLE, clearance
from powered_walker_env.physics.heel_strike import momentum_matrix, new_contact, swapped
from powered_walker_env.physics.swing import mass_matrix, solve_free, solve_locked, vectors
from powered_walker_env.physics.tangents import (
    bias_tangent,
    mass_matrix_tangent,
    momenta_before_tangent,
    motor_torque_tangent,
    swing_foot_tangent,
    unpack_direction,
    vectors_tangent,
)

OUTPUTS = 6  # what a stride is differentiated of: α, s, α', β' after it, duration, step length


class Directions(NamedTuple):
    """What to differentiate by, one direction a row, and room to do it."""

    state: np.ndarray  # (n, 4) changes of the post-strike state at the start
    control: np.ndarray  # (n, 2) of switch angle and stall torque
    params: np.ndarray  # (n, 12) of the packed walker
    S: np.ndarray  # (n, 6) derivative of (φ, α, β and rates), now
    slopes: np.ndarray  # (n, 13, 6) of S at the stages
    derivative: np.ndarray  # (n, OUTPUTS) the result


@kernel
def begin(directions):
    """S at the start of a stride: both feet locked, φ = α − lock."""
    for k in range(directions.S.shape[0]):
        stance, swing, stance_rate, swing_rate = directions.state[k]
        S = directions.S[k]
        S[0], S[1], S[2] = stance - directions.params[k, 3], stance, swing
        S[3], S[4], S[5] = stance_rate, stance_rate, swing_rate


@kernel
def _flow_tangent(joints, torque, y, slope, at, matrix, t, control, change, c, d, out):
    """out = (∂f/∂y) t + ∂f/∂p: from M q'' + bias = force, M δq'' = δforce − δbias − δM q''.

    Args:
        y, slope: a state and its derivative; at, matrix: its vectors and mass matrix.
        t, change: the direction's state and stall torque; d: its walker.
    """
    moved = vectors_tangent(y, t, at[0], at[1], at[2], at[3], d)
    d11, d12, d13, d22, d23, d33 = mass_matrix_tangent(at, moved, c, d)
    b1, b2, b3 = bias_tangent(at, moved, (y[3], y[4], y[5]), (t[3], t[4], t[5]), c, d)
    tau = 0.0
    if torque == MOTOR:
        tau = motor_torque_tangent(y[4] - y[3], t[4] - t[3], control[1], change, c, d)
    q1, q2, q3 = slope[3], slope[4], slope[5]
    f1 = tau - b1 - d11 * q1 - d12 * q2 - d13 * q3
    f2 = -tau - b2 - d12 * q1 - d22 * q2 - d23 * q3
    f3 = -b3 - d13 * q1 - d23 * q2 - d33 * q3
    out[0], out[1], out[2] = t[3], t[4], t[5]
    if joints == LOCKED:
        ddalpha, ddbeta = solve_locked(matrix, f1, f2, f3)
        out[3], out[4], out[5] = ddalpha, ddalpha, ddbeta
    else:
        out[3], out[4], out[5] = solve_free(matrix, f1, f2, f3)


@kernel
def propagate(joints, torque, w, h, correction, fresh, control, row, c, directions):
    """Carry S over the step just taken: length h, then `correction` to first order.

    `fresh` says that the step begins a phase; later ones know their first slope.
    """
    t = np.empty(DIMENSION)
    for stage in range(STAGES + 1):
        if stage == 0 and not fresh:
            continue
        y = w.y if stage == 0 else (w.y_new if stage == STAGES else w.stages[stage])
        at = vectors(y[0], y[1], y[2], c)
        matrix = mass_matrix(at[0], at[1], at[2], at[3], c)
        weights = WEIGHTS if stage == STAGES else STAGE_WEIGHTS[stage]
        for k in range(directions.S.shape[0]):
            S, slopes = directions.S[k], directions.slopes[k]
            for i in range(DIMENSION):
                t[i] = 0.0
            for j in range(stage):
                if weights[j] != 0.0:
                    for i in range(DIMENSION):
                        t[i] += weights[j] * slopes[j, i]
            for i in range(DIMENSION):
                t[i] = S[i] + h * t[i]
            d = unpack_direction(row, directions.params[k], c)
            change = directions.control[k, 1]
            out = slopes[stage]
            _flow_tangent(
                joints, torque, y, w.slopes[stage], at, matrix, t, control, change, c, d, out
            )
            if stage == STAGES:
                for i in range(DIMENSION):
                    S[i] = t[i] + correction * out[i]
                    slopes[0, i] = out[i]


@kernel
def _event_shift(guard, y, S, switch_change, c, d):
    """How much the event's time moves along a direction: dt = −(∇g·S + ∂g/∂p)/ġ."""
    if guard == SWITCH_ANGLE:
        return -(S[2] - S[1] - switch_change) / (y[5] - y[4])
    if guard == LANDING:
        _, rate = clearance(y, c)
        return -swing_foot_tangent(y, S, c, d).real / rate
    return 0.0


@kernel
def _shift(guard, elapsed, before, y, k, row, c, directions):
    """Move S to the event, which moves too: S + f⁻ dt in place; dt is returned.

    An event that is there already at the start of its phase does not move.
    """
    S = directions.S[k]
    d = unpack_direction(row, directions.params[k], c)
    dt = 0.0
    if elapsed:
        dt = _event_shift(guard, y, S, directions.control[k, 0], c, d)
    for i in range(DIMENSION):
        S[i] += before[i] * dt
    return dt


@kernel
def pass_event(guard, elapsed, phases, y, control, row, c, directions):
    """The saltation at an event that leaves the state as it is.

    Args:
        phases: (joints, torque) before and after; elapsed: whether time has passed in
            the phase that ended.
    """
    before, after = np.empty(DIMENSION), np.empty(DIMENSION)
    (joints, torque), (next_joints, next_torque) = phases
    flow(joints, torque, y, control[1], c, before)
    flow(next_joints, next_torque, y, control[1], c, after)
    for k in range(directions.S.shape[0]):
        dt = _shift(guard, elapsed, before, y, k, row, c, directions)
        for i in range(DIMENSION):
            directions.S[k, i] -= after[i] * dt


@kernel
def _momentum_matrix_tangent(y, t, c, d):
    """Changes of `momentum_matrix`."""
    at = vectors(y[0], y[1], y[2], c)
    moved = vectors_tangent(y, t, at[0], at[1], at[2], at[3], d)
    d11, d12, d13, d22, d23, d33 = mass_matrix_tangent(at, moved, c, d)
    coupling = d13 + d23
    return d11 + 2.0 * d12 + d22 + coupling, coupling + d33, coupling, d33


@kernel
def pass_heel_strike(guard, phase, first_phi, y, struck, control, row, c, directions):
    """The result: derivatives of the post-strike state, the duration and the step length.

    Args:
        phase: (joints, torque) of the phase that ended.
        y, struck: (φ, α, β and rates) before and after the heel strike.
    """
    before = np.empty(DIMENSION)
    flow(phase[0], phase[1], y, control[1], c, before)
    at = vectors(y[0], y[1], y[2], c)
    contact = new_contact(y[0], y[1], y[2], c)
    new_phi, new_alpha, new_beta = swapped(y[2], y[1], c)
    landed = np.array([new_phi, new_alpha, new_beta, 0.0, 0.0, 0.0])
    where = y if c.as_published else landed
    a11, a12, a21, a22 = momentum_matrix(where[0], where[1], where[2], c)
    determinant = a11 * a22 - a12 * a21
    x1, x2 = struck[4], struck[5]
    for k in range(directions.S.shape[0]):
        d = unpack_direction(row, directions.params[k], c)
        dt = _shift(guard, True, before, y, k, row, c, directions)
        S = directions.S[k]
        moved = vectors_tangent(y, S, at[0], at[1], at[2], at[3], d)
        walker, trailing = momenta_before_tangent(y, S, at, moved, contact, c, d)
        turned_to = np.array([S[2] - d.lock, S[2], S[1]])
        d11, d12, d21, d22 = _momentum_matrix_tangent(
            where, S if c.as_published else turned_to, c, d
        )
        f1 = walker - d11 * x1 - d12 * x2
        f2 = trailing - d21 * x1 - d22 * x2
        result = directions.derivative[k]
        result[0], result[1] = S[2], S[1]
        result[2] = (f1 * a22 - a12 * f2) / determinant
        result[3] = (a11 * f2 - a21 * f1) / determinant
        result[4] = dt
        started = directions.state[k, 0] - directions.params[k, 3]
        rolled = d.R * (y[0] - first_phi) + c.R * (S[0] - started)
        result[5] = swing_foot_tangent(y, S, c, d).imag + rolled
