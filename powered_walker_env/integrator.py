"""Runge–Kutta of order 8 with dense output of order 7, for one phase of the walker.

Dormand and Prince's method with the error estimates and the interpolant of Hairer,
Nørsett and Wanner, Solving Ordinary Differential Equations I, section II.10 (DOP853).
The coefficients are those that scipy ships. No allocation: the caller brings a
`Workspace`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.integrate import DOP853

from powered_walker_env.compilation import kernel
from powered_walker_env.physics.actuation import flow

DIMENSION = 6  # φ, α, β and their rates
STAGES = 12
STAGE_WEIGHTS = np.ascontiguousarray(DOP853.A)
WEIGHTS = np.ascontiguousarray(DOP853.B)
_E3 = np.ascontiguousarray(DOP853.E3)
_E5 = np.ascontiguousarray(DOP853.E5)
_A_EXTRA = np.ascontiguousarray(DOP853.A_EXTRA)
_D = np.ascontiguousarray(DOP853.D)
EXTRA_STAGES = len(_A_EXTRA)
POLYNOMIALS = len(_D) + 3  # terms of the interpolant

# Step-size control, as in Hairer's code.
SAFETY, SMALLEST_FACTOR, LARGEST_FACTOR, EXPONENT = 0.9, 0.2, 10.0, -1.0 / 8.0


class Workspace(NamedTuple):
    """The arrays that the integration of one stride works in."""

    y: np.ndarray  # (6,) state at the start of the step
    y_new: np.ndarray  # (6,) state at its end
    work: np.ndarray  # (6,) state of the interpolant
    stages: np.ndarray  # (12, 6) state at the stages
    slopes: np.ndarray  # (16, 6) y' at the stages; row 0 at the start, row 12 at the end
    dense: np.ndarray  # (7, 6) coefficients of the interpolant


@kernel
def workspace():
    """A fresh workspace."""
    return Workspace(
        np.zeros(DIMENSION),
        np.zeros(DIMENSION),
        np.zeros(DIMENSION),
        np.zeros((STAGES, DIMENSION)),
        np.zeros((STAGES + 1 + EXTRA_STAGES, DIMENSION)),
        np.zeros((POLYNOMIALS, DIMENSION)),
    )


@kernel
def _advance(y, h, weights, slopes, out):
    """out = y + h Σ weights·slopes."""
    for i in range(DIMENSION):
        out[i] = 0.0
    for j in range(len(weights)):
        weight = weights[j]
        if weight != 0.0:
            for i in range(DIMENSION):
                out[i] += weight * slopes[j, i]
    for i in range(DIMENSION):
        out[i] = y[i] + h * out[i]


@kernel
def start(joints, torque, w, stall_torque, c):
    """Set the first slope of a step that begins at w.y."""
    flow(joints, torque, w.y, stall_torque, c, w.slopes[0])


@kernel
def step(joints, torque, w, h, stall_torque, c):
    """One step of length h from w.y to w.y_new; needs w.slopes[0], fills the others."""
    for stage in range(1, STAGES):
        _advance(w.y, h, STAGE_WEIGHTS[stage, :stage], w.slopes, w.stages[stage])
        flow(joints, torque, w.stages[stage], stall_torque, c, w.slopes[stage])
    _advance(w.y, h, WEIGHTS, w.slopes, w.y_new)
    flow(joints, torque, w.y_new, stall_torque, c, w.slopes[STAGES])


@kernel
def error_norm(w, h, tolerance, rate_scale):
    """The step's estimated error over its tolerance: accept it up to 1.

    Angles are measured in radians and rates in √(g/L) (`rate_scale`), or by their own
    size where that is larger.
    """
    sum3, sum5 = 0.0, 0.0
    for i in range(DIMENSION):
        error3, error5 = 0.0, 0.0
        for j in range(STAGES + 1):
            error3 += _E3[j] * w.slopes[j, i]
            error5 += _E5[j] * w.slopes[j, i]
        natural = 1.0 if i < DIMENSION // 2 else rate_scale
        scale = tolerance * max(natural, abs(w.y[i]), abs(w.y_new[i]))
        sum3 += (error3 / scale) ** 2
        sum5 += (error5 / scale) ** 2
    if sum3 == 0.0 and sum5 == 0.0:
        return 0.0
    return abs(h) * sum5 / np.sqrt((sum5 + 0.01 * sum3) * DIMENSION)


@kernel
def step_factor(error):
    """How much longer the next step may be, from the error norm of this one."""
    if error == 0.0:
        return LARGEST_FACTOR
    return min(LARGEST_FACTOR, max(SMALLEST_FACTOR, SAFETY * error**EXPONENT))


@kernel
def prepare_dense(joints, torque, w, h, stall_torque, c):
    """Fill w.dense for the step just taken: three more slopes, then the coefficients."""
    for extra in range(EXTRA_STAGES):
        stage = STAGES + 1 + extra
        _advance(w.y, h, _A_EXTRA[extra, :stage], w.slopes, w.work)
        flow(joints, torque, w.work, stall_torque, c, w.slopes[stage])
    for i in range(DIMENSION):
        change = w.y_new[i] - w.y[i]
        first, last = w.slopes[0, i], w.slopes[STAGES, i]
        w.dense[0, i] = change
        w.dense[1, i] = h * first - change
        w.dense[2, i] = 2.0 * change - h * (last + first)
        for k in range(len(_D)):
            total = 0.0
            for j in range(STAGES + 1 + EXTRA_STAGES):
                total += _D[k, j] * w.slopes[j, i]
            w.dense[3 + k, i] = h * total


@kernel
def dense_state(w, fraction):
    """Write the interpolant at `fraction` of the step (0 to 1) into w.work."""
    for i in range(DIMENSION):
        value = 0.0
        for k in range(POLYNOMIALS - 1, -1, -1):
            value += w.dense[k, i]
            value *= fraction if k % 2 == 0 else 1.0 - fraction
        w.work[i] = w.y[i] + value
