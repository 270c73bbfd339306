"""The search for all gaits of a walker.

`find_gaits` covers the state space with an additive recurrence of low discrepancy (Roberts'
R₄), measures how far the map moves each state, and sends Newton off from the most promising
ones that lie apart.
"""

from __future__ import annotations

import functools
from typing import Unpack

import numpy as np

from powered_walker_env.model.checks import whole_number
from powered_walker_env.model.powering import AnyControl, Policy
from powered_walker_env.model.state import natural_units
from powered_walker_env.model.walker import WalkerParams
from powered_walker_env.poincare.fixed_points import newton, refusal, relative_residuals
from powered_walker_env.poincare.gaits import Gait, describe, natural_section
from powered_walker_env.poincare.maps import StrideMap
from powered_walker_env.poincare.tolerances import LONGEST_PERIOD, SAME_STATE, SEARCH_RTOL
from powered_walker_env.poincare.work.pieces import RunOptions, run_pieces
from powered_walker_env.simulation.strides import Array

# Where post-strike states are looked for, in natural units: stance angle, swing angle beyond
# its mirror image, both rates. Every gait known lies well inside.
LOWEST = np.array([-0.8, -0.3, 0.0, -0.6])
HIGHEST = np.array([0.1, 0.4, 1.0, 1.0])
SPREAD = 1.1673039782614187 ** -np.arange(1.0, 5.0)  # steps of R₄: powers of the root of x⁵ = x + 1
SEARCHES = 64  # Newton's, per 1024 starts
FEW_STARTS = 512  # of the short search behind other questions asked without a guess
BETWEEN = 0.06  # natural units, at least, from the start of one Newton search to another's
ROUGHLY = 1e-4  # natural units, within which a search has come to a cycle that is known


def find_gaits(
    params: WalkerParams,
    control: AnyControl | Policy | None,
    *,
    period: int = 1,
    starts: int = 4096,
    seed: int = 0,
    **run: Unpack[RunOptions],
) -> list[Gait]:
    """Every distinct gait that a seeded multistart finds, stable or not.

    Args:
        params: the walker.
        control: a constant control, None for a passive walker, or a policy.
        period: strides after which the gaits close for the first time, 1 to 1024.
        starts: states tried; more find rarer gaits.
        seed: of the starts. The same seed gives the same gaits.
        **run: how the starts are shared out, see `run_pieces`; threads if left out.

    Returns:
        The gaits by spectral radius, most stable first (section as in `find_gait`); empty if
        there are none. A cycle of several strides begins at its state with the stance leg
        furthest back.
    """
    period = whole_number("period", period, 1, LONGEST_PERIOD)
    starts = whole_number("starts", starts, 1)
    exact = StrideMap(params, control)
    section = natural_section(exact.scheme)
    rough = StrideMap(params, control, rtol=SEARCH_RTOL)
    options: RunOptions = {"backend": "threading", **run}
    work = functools.partial(_near, rough, period)
    cycles: list[Array] = []
    for near in run_pieces(work, list(_promising(rough, period, starts, seed)), **options):
        if near is None or _known(near, cycles, ROUGHLY, params):
            continue
        state, _ = newton(exact, near, period)
        if state is None:
            continue
        cycle = _cycle(exact, state, period)
        if cycle is not None and not _known(cycle[0], cycles, SAME_STATE, params):
            cycles.append(cycle)
    gaits = [describe(exact, cycle[0], section, period) for cycle in cycles]
    return sorted(gaits, key=lambda gait: (gait.spectral_radius, gait.state))


def _near(stride_map: StrideMap, period: int, start: Array) -> Array | None:
    """Roughly where Newton leads from a start, if to a fixed point."""
    return newton(stride_map, start, period, converged=100 * SEARCH_RTOL)[0]


def _promising(stride_map: StrideMap, period: int, starts: int, seed: int) -> Array:
    """Starts from which Newton is worth while: small residual, apart from one another."""
    units = natural_units(stride_map.params)
    offset = np.random.default_rng(seed).random(4)
    unit = (offset + np.arange(starts)[:, np.newaxis] * SPREAD) % 1.0
    scaled = LOWEST + (HIGHEST - LOWEST) * unit
    scaled[:, 1] -= scaled[:, 0]
    residuals = relative_residuals(stride_map, scaled * units, period)
    chosen: list[Array] = []
    most = max(SEARCHES, SEARCHES * starts // 1024)
    for i in np.argsort(residuals, kind="stable"):
        if len(chosen) == most or not np.isfinite(residuals[i]):
            break
        if all(np.linalg.norm(scaled[i] - other) > BETWEEN for other in chosen):
            chosen.append(scaled[i])
    return np.array(chosen).reshape(-1, 4) * units


def _cycle(stride_map: StrideMap, state: Array, period: int) -> Array | None:
    """The states of the cycle, (period, 4); None if it stands still or closes early."""
    if refusal(stride_map, state, period):
        return None
    states = [state]
    for _ in range(1, period):
        states.append(stride_map(states[-1][np.newaxis])[0])
    first = min(range(period), key=lambda i: float(states[i][0]))
    return np.roll(np.array(states), -first, axis=0)


def _known(state: Array, cycles: list[Array], near: float, params: WalkerParams) -> bool:
    """Whether the state belongs to one of the cycles."""
    units = natural_units(params)
    return any(np.linalg.norm((cycle - state) / units, axis=1).min() < near for cycle in cycles)
