"""Robustness near a gait: the gait sensitivity norm.

Linearised from stride to stride, with v the deviation of the post-strike state, e the
disturbances and g the gait indicators of a stride,

    v⁺ = A v + B e,    g = C v + D e,

the gait sensitivity norm (Hobbelen and Wisse 2007, IEEE T-RO 23, 1213–1224) is

    ‖∂g/∂e‖₂ = √( tr(DᵀD) + Σₖ tr(Bᵀ(Aᵏ)ᵀ CᵀC Aᵏ B) ),

the H₂ norm: also the standard deviation of g under white noise e of size 1. The sum is
BᵀWB with W the solution of W = AᵀWA + CᵀC. Along a gait of several strides the matrices
are periodic, and the norm is the mean square over the stride that is disturbed.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
import scipy.linalg

from powered_walker_env.model.mechanics.packing import pack
from powered_walker_env.model.state import PostStrikeState
from powered_walker_env.poincare.gaits import Gait
from powered_walker_env.poincare.maps import MapPoint, StrideMap
from powered_walker_env.simulation.derivatives import PARAMETERS, STATE_SIZE, parameters_of
from powered_walker_env.simulation.differences import BACKWARD, CENTRAL, FORWARD, differences
from powered_walker_env.simulation.strides import Array, run_batch

STATE_NAMES = PostStrikeState._fields
STEP_HEIGHT = "step_height"
#: What can be disturbed, for one stride: the state it begins from (a push at heel strike,
#: which a policy sees), a parameter (of the control: what a policy puts out), the ground.
DISTURBANCES = (*STATE_NAMES, *PARAMETERS, STEP_HEIGHT)
#: What can be watched: a stride's duration, length and speed, and the state it ends in.
INDICATORS = ("duration", "step_length", "speed", *STATE_NAMES)
HEIGHT_DIFFERENCE = 1e-4  # leg lengths, step of the differences by step height


@dataclass(frozen=True, eq=False)
class GaitSensitivity:
    """The linear response of a gait's indicators to disturbances, in units of their sizes."""

    gait: Gait
    disturbances: dict[str, float]  # name to size: 1 in B and D, SI units
    indicators: dict[str, float]  # name to the change that counts as 1
    A: Array = field(repr=False)  # (period, 4, 4), phase by phase
    B: Array = field(repr=False)  # (period, 4, m)
    C: Array = field(repr=False)  # (period, q, 4)
    D: Array = field(repr=False)  # (period, q, m)
    parts: Array  # (q, m) the norm of each indicator by each disturbance

    def __repr__(self) -> str:
        what, by = ", ".join(self.indicators), ", ".join(self.disturbances)
        return f"GaitSensitivity({self.norm:.4g}: {what} by {by})"

    @property
    def norm(self) -> float:
        """The gait sensitivity norm ‖∂g/∂e‖₂."""
        return float(np.linalg.norm(self.parts))

    def impulse_response(self, strides: int, phase: int = 0) -> Array:
        """(strides, q, m) indicators of the strides after disturbances in the first alone."""
        period, responses = len(self.A), [self.D[phase]]
        v = self.B[phase]
        for k in range(phase + 1, phase + strides):
            responses.append(self.C[k % period] @ v)
            v = self.A[k % period] @ v
        return np.array(responses)


def gait_sensitivity(
    gait: Gait,
    disturbances: Mapping[str, float] | None = None,
    indicators: Mapping[str, float] | None = None,
) -> GaitSensitivity:
    """The gait sensitivity norm of a stable gait, of an open or a closed loop.

    Args:
        gait: of a constant control or a policy.
        disturbances: names out of `DISTURBANCES` (of the walker's own control, no other)
            to sizes (SI units), independent of each other; a step of one leg length if left
            out: the ground rises there and stays. For pushes on both legs give
            {"stance_rate": σ, "swing_rate": σ}.
        indicators: names out of `INDICATORS` to the change that counts as 1 (SI units);
            a step's duration in units of √(L/g) if left out.

    Raises:
        ValueError: an unstable gait, whose response has no end; an unknown name.
    """
    require_stable(gait)
    params = gait.params
    causes = dict(disturbances or {STEP_HEIGHT: params.leg_length})
    effects = dict(indicators or {"duration": math.sqrt(params.leg_length / params.gravity)})
    stride_map = StrideMap(params, gait.control)
    known = (*STATE_NAMES, *parameters_of(stride_map.scheme), STEP_HEIGHT)
    _check_names("disturbances", causes, known)
    _check_names("indicators", effects, INDICATORS)
    phases = [_linearise(stride_map, state, causes, effects) for state in gait.states]
    A, B, C, D = (np.array(matrices) for matrices in zip(*phases, strict=True))
    parts = [_norms(A, B, C[:, [row]], D[:, [row]]) for row in range(len(effects))]
    return GaitSensitivity(gait, causes, effects, A, B, C, D, np.array(parts))


def _check_names(what: str, given: Mapping[str, float], known: Sequence[str]) -> None:
    for name, size in given.items():
        if name not in known:
            raise ValueError(f"{what} must be out of {', '.join(known)}, got {name!r}")
        if not (math.isfinite(size) and size > 0):
            raise ValueError(f"{what} need positive sizes, got {size!r} for {name!r}")


def require_stable(gait: Gait) -> None:
    if not gait.stable:
        raise ValueError(
            "gait must be stable: deviations from this one never die out, its spectral radius "
            f"is {gait.spectral_radius:.4f}; close a loop around it, or choose another"
        )


def _linearise(
    stride_map: StrideMap, state: Array, causes: Mapping[str, float], effects: Mapping[str, float]
) -> tuple[Array, Array, Array, Array]:
    """A, B, C, D of the stride from one point of the gait."""
    names = [name for name in causes if name not in (*STATE_NAMES, STEP_HEIGHT)]
    point = stride_map.differentiate(state, by=names)
    by_state = _with_speed(_rows(point)[:, :STATE_SIZE], point)
    columns = []
    for name, size in causes.items():
        if name in STATE_NAMES:
            column = by_state[:, STATE_NAMES.index(name)]
        elif name == STEP_HEIGHT:
            column = _with_speed(_by_step_height(stride_map, state)[:, np.newaxis], point)[:, 0]
        else:
            place = STATE_SIZE + point.controls + names.index(name)
            column = _with_speed(_rows(point)[:, [place]], point)[:, 0]
        columns.append(column * size)
    by_cause = np.array(columns).T
    chosen = [INDICATORS.index(name) for name in effects]
    scales = np.array(list(effects.values()))[:, np.newaxis]
    return (
        by_state[3:],
        by_cause[3:],
        by_state[chosen] / scales,
        by_cause[chosen] / scales,
    )


def _rows(point: MapPoint) -> Array:
    """Derivatives of duration, step length and state, (6, n)."""
    return np.vstack([point.duration_by, point.step_length_by, point.by])


def _with_speed(rows: Array, point: MapPoint) -> Array:
    """The same with the speed's after them, in the order of INDICATORS: v = length/duration."""
    speed = (rows[1] - point.step_length / point.duration * rows[0]) / point.duration
    return np.vstack([rows[:2], speed, rows[2:]])


def _by_step_height(stride_map: StrideMap, state: Array) -> Array:
    """(6,) derivatives of duration, length and state: fourth-order differences of strides.

    One-sided where steps to one side make another stride: the gait on round feet scuffs
    as its legs pass, so that the least step down is met there and then.
    """
    step = HEIGHT_DIFFERENCE * stride_map.params.leg_length
    row = pack(stride_map.params)[np.newaxis]

    def onto(heights: Array) -> Array:
        states = np.tile(state, (len(heights), 1))
        controls = stride_map.controls(states)
        batch = run_batch(stride_map.cycle, states, controls, row, heights[:, 0], stride_map.rtol)
        return np.column_stack([batch.duration, batch.step_length, batch.state])

    for stencil in (CENTRAL, FORWARD, BACKWARD):
        found = differences(onto, np.zeros((1, 1)), step, stencil)[0, :, 0]
        if np.isfinite(found).all():  # else a walker falls
            return found
    raise ValueError(
        f"{STEP_HEIGHT} must leave the walker walking at {step:g} m, but it falls on steps up and "
        "down alike; leave this disturbance out"
    )


def _norms(A: Array, B: Array, C: Array, D: Array) -> Array:
    """(m,) norms of one indicator by each disturbance, root mean square over the phases."""
    period = len(A)
    through, energy = np.eye(4), np.zeros((4, 4))
    for k in range(period):
        energy += through.T @ C[k].T @ C[k] @ through
        through = A[k] @ through
    W = scipy.linalg.solve_discrete_lyapunov(through.T, energy)  # of the strides from phase 0 on
    squares = np.zeros(B.shape[2])
    for k in reversed(range(period)):
        squares += np.sum(D[k] ** 2, axis=0) + np.einsum("im,ij,jm->m", B[k], W, B[k])
        W = A[k].T @ W @ A[k] + C[k].T @ C[k]
    return np.sqrt(squares / period)
