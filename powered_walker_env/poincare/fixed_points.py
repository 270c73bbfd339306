"""Fixed points of the stride map by damped Newton, and whether one is a gait."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from powered_walker_env.model.phases import Outcome
from powered_walker_env.model.state import natural_units
from powered_walker_env.poincare.maps import StrideMap
from powered_walker_env.poincare.tolerances import (
    NEWTON_STEPS,
    RESIDUAL,
    SAME_STATE,
    SHORTEST_STRIDE,
)
from powered_walker_env.simulation.strides import Array

HALVINGS = 8  # of a Newton step that does not bring the residual down


def residuals_of(stride_map: StrideMap, states: Array, period: int) -> Array:
    """Distance of each state (N, 4) from its image, in natural units; inf after a fall."""
    moved = (stride_map(states, period) - states) / natural_units(stride_map.params)
    distance = np.linalg.norm(moved, axis=1)
    return np.where(np.isfinite(distance), distance, np.inf)


def relative_residuals(stride_map: StrideMap, states: Array, period: int) -> Array:
    """Distance of each state from its image over the length walked; inf after a fall.

    Over the length, or standing still on both legs would look like the best of gaits.
    """
    image, length = states, np.zeros(len(states))
    for _ in range(period):
        batch = stride_map.strides(image)
        image, length = batch.state, length + batch.step_length
    moved = np.linalg.norm((image - states) / natural_units(stride_map.params), axis=1)
    good = np.isfinite(moved) & (length > SHORTEST_STRIDE * stride_map.params.leg_length)
    return np.where(good, moved / np.where(good, length, 1.0), np.inf)


def newton(
    stride_map: StrideMap, state: Array, period: int, converged: float = RESIDUAL
) -> tuple[Array | None, str]:
    """A fixed point near `state` by damped Newton, or None and why not."""
    point, residual = stride_map.differentiate(state, period), np.inf
    if point.outcome == Outcome.WALKED:
        residual = float(np.linalg.norm((point.state - state) / natural_units(stride_map.params)))
    for _ in range(NEWTON_STEPS):
        if not np.isfinite(point.by_state).all():
            return None, f"a stride from {short(state)} ends with: {point.outcome.label}"
        change = np.linalg.lstsq(np.eye(4) - point.by_state, point.state - state, rcond=None)[0]
        trials = state + change * 0.5 ** np.arange(HALVINGS)[:, np.newaxis]
        residuals = residuals_of(stride_map, trials, period)
        better = np.flatnonzero(residuals < residual)
        if not len(better):
            break
        state, residual = trials[better[0]], float(residuals[better[0]])
        point = stride_map.differentiate(state, period)
    if residual <= converged:
        return state, ""
    return None, f"Newton stopped at a residual of {residual:.2g} near {short(state)}"


def refusal(stride_map: StrideMap, state: Array, period: int) -> str:
    """Why a fixed point over `period` strides is no gait of that least period; "" if it is."""
    units, length = natural_units(stride_map.params), stride_map.params.leg_length
    here, travelled, shorter = state, 0.0, 0
    for strides in range(1, period + 1):
        batch = stride_map.strides(here[np.newaxis])
        here, travelled = batch.state[0], travelled + float(batch.step_length[0])
        back = period % strides == 0 and np.linalg.norm((here - state) / units) < SAME_STATE
        if back and strides < period and not shorter:
            shorter = strides
    if not abs(travelled) > SHORTEST_STRIDE * length * period:
        return (
            f"near {short(state)} the walker stands on the spot: it comes back after "
            f"{travelled:.2g} m"
        )
    if shorter:
        return f"the gait near {short(state)} has period {shorter}"
    return ""


def short(state: Sequence[float] | Array) -> str:
    """A state as messages print it."""
    return "(" + ", ".join(f"{value:.4f}" for value in state) + ")"
