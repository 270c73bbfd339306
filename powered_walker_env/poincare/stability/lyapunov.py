"""The largest Lyapunov exponent of the stride map: do neighbouring walks part for good?

A tangent vector is carried along the orbit by the exact Jacobians and renormalised at
every stride (Benettin, Galgani, Giorgilli and Strelcyn 1980); the mean logarithm of its
growth is the exponent, per stride. On a stable gait of period n it is log(ρ)/n, ρ the
spectral radius; above zero the walk is chaotic.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from powered_walker_env.model.checks import whole_number
from powered_walker_env.model.phases import Outcome
from powered_walker_env.model.powering import AnyControl, Policy
from powered_walker_env.model.state import PostStrikeState, check_state, natural_units
from powered_walker_env.model.walker import WalkerParams
from powered_walker_env.poincare.maps import StrideMap
from powered_walker_env.poincare.tolerances import ORBIT_RTOL
from powered_walker_env.simulation.strides import Array


@dataclass(frozen=True, eq=False)
class LyapunovExponent:
    """The exponent of one orbit; NaN if the walker fell."""

    params: WalkerParams
    control: AnyControl | Policy | None
    start: PostStrikeState
    transient: int  # strides before the growth is counted
    seed: int
    rtol: float
    exponent: float  # per stride
    standard_error: float  # from the scatter of the blocks' means
    growth: Array = field(repr=False)  # (strides,) logarithms, stride by stride
    states: Array = field(repr=False)  # (strides, 4) of the orbit
    outcome: Outcome  # of the last stride

    def __repr__(self) -> str:
        return (
            f"LyapunovExponent({self.exponent:.4f} ± {self.standard_error:.4f} per stride, "
            f"{len(self.growth)} strides, {self.outcome.label})"
        )

    @property
    def chaotic(self) -> bool:
        """Whether the exponent is positive beyond three standard errors."""
        return self.exponent > 3.0 * self.standard_error


def lyapunov_exponent(
    params: WalkerParams,
    control: AnyControl | Policy | None,
    state: PostStrikeState | Sequence[float],
    *,
    strides: int = 2000,
    transient: int = 200,
    blocks: int = 20,
    seed: int = 0,
    rtol: float = ORBIT_RTOL,
) -> LyapunovExponent:
    """The largest Lyapunov exponent along the orbit from a state.

    Args:
        params, control: the walker; a policy makes it the exponent of the closed loop.
        state: where the orbit begins.
        strides: counted, after the transient.
        blocks: their means' scatter gives the standard error; make them much longer
            than the orbit's memory, or it comes out too small.
        seed: of the first tangent vector, which is soon forgotten.

    Raises:
        ValueError, TypeError: fewer than two strides for a block, or fewer than two blocks.
    """
    blocks = whole_number("blocks", blocks, 2)
    strides = whole_number("strides", strides, 2 * blocks)
    transient = whole_number("transient", transient, 0)
    stride_map, units = StrideMap(params, control, rtol), natural_units(params)
    start = check_state(state)
    x, tangent = np.array(start), np.random.default_rng(seed).normal(size=4)
    tangent /= np.linalg.norm(tangent)
    growth, states = np.full(strides, np.nan), np.full((strides, 4), np.nan)
    outcome = Outcome.WALKED
    for k in range(-transient, strides):
        point = stride_map.differentiate(x)
        x, outcome = point.state, point.outcome
        if outcome != Outcome.WALKED:
            break
        tangent = point.by_state @ (tangent * units) / units
        size = float(np.linalg.norm(tangent))
        tangent /= size
        if k >= 0:
            growth[k], states[k] = math.log(size), x
    error = _standard_error(growth, blocks)
    return LyapunovExponent(
        params, control, start, transient, seed, rtol, float(np.mean(growth)), error, growth,
        states, outcome,
    )  # fmt: skip


def _standard_error(growth: Array, blocks: int) -> float:
    """Of the mean: the standard deviation of the blocks' means over √blocks."""
    means = [float(np.mean(block)) for block in np.array_split(growth, blocks)]
    return float(np.std(means, ddof=1)) / math.sqrt(blocks)
