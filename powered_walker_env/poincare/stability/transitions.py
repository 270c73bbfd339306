"""Step-to-step transition times: how many strides a deviation from a gait lasts.

Two answers by the linear map, and one by walking. The slowest multiplier ρ gives the
long run, log(level)/log(ρ) strides; the norm of the products of Jacobians gives the
worst deviation, with the growth on the way (the stride map is far from normal: it may
grow a deviation fiftyfold before that dies out); simulated deviations show what is
typical.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from powered_walker_env.model.checks import real_number, require, whole_number
from powered_walker_env.model.state import natural_units
from powered_walker_env.poincare.gaits import Gait
from powered_walker_env.poincare.maps import StrideMap
from powered_walker_env.poincare.stability.robustness import require_stable
from powered_walker_env.simulation.strides import Array


@dataclass(frozen=True, eq=False)
class TransitionTimes:
    """How many strides a deviation from a gait takes to shrink to a share of its size."""

    gait: Gait
    levels: Array  # (k,) shares
    by_multiplier: Array  # (k,) log(level)/log(ρ): the slowest mode alone, in the long run
    worst: NDArray[np.int64]  # (k,) linear, the worst deviation, growth included; −1: too long
    growth: float  # the most that a small deviation grows on the way, natural units
    size: float  # of the deviations that were simulated, natural units
    seed: int
    simulated: NDArray[np.int64] = field(repr=False)  # (k, N) random deviations; −1: never

    def __repr__(self) -> str:
        shares = ", ".join(f"{level:.3g}" for level in self.levels)
        strides = ", ".join(f"{each:.3g}" for each in self.by_multiplier)
        return (
            f"TransitionTimes(to {shares} of its size in {strides} strides, worst "
            f"{self.worst.tolist()}, growth {self.growth:.3g})"
        )

    def seconds(self, strides: Array | NDArray[np.int64]) -> Array:
        """Strides as time."""
        return np.asarray(strides, np.float64) * (self.gait.duration / self.gait.period)


def transition_times(
    gait: Gait,
    levels: Sequence[float] = (math.exp(-1.0), 0.05),
    *,
    size: float = 1e-3,
    deviations: int = 64,
    limit: int = 200,
    seed: int = 0,
) -> TransitionTimes:
    """How many strides a deviation takes to shrink, by the multipliers and as walked.

    Args:
        gait: stable, of a constant control or a policy.
        levels: shares of the first deviation, in (0, 1); it counts when the deviation
            stays below from then on.
        size: of the deviations simulated, natural units (radians; rates over √(g/L)).
        deviations: how many, uniform on the sphere, seeded.
        limit: strides walked at most.

    Raises:
        ValueError, TypeError: an unstable gait, or an argument out of its domain.
    """
    require_stable(gait)
    deviations, limit = whole_number("deviations", deviations, 1), whole_number("limit", limit, 1)
    size = real_number("size", size)
    require(size > 0, "size", "be positive", size)
    shares = np.array(levels, np.float64)
    if shares.ndim != 1 or not len(shares) or (shares <= 0).any() or (shares >= 1).any():
        raise ValueError(f"levels must lie in (0, 1), got {levels!r}")
    rng, units = np.random.default_rng(seed), natural_units(gait.params)
    offsets = rng.normal(size=(deviations, 4))
    offsets *= size / np.linalg.norm(offsets, axis=1, keepdims=True)
    stride_map = StrideMap(gait.params, gait.control)
    states, moved = gait.states[0] + offsets * units, np.eye(4)
    linear, walked = [1.0], [np.ones(deviations)]
    for k in range(limit):
        by_state = stride_map.differentiate(gait.states[k % gait.period]).by_state
        moved = by_state * units / units[:, np.newaxis] @ moved
        linear.append(float(np.linalg.norm(moved, 2)))
        states = stride_map(states)
        away = (states - gait.states[(k + 1) % gait.period]) / units
        walked.append(np.linalg.norm(away, axis=1) / size)
    by_multiplier = gait.period * np.log(shares) / math.log(gait.spectral_radius)
    return TransitionTimes(
        gait,
        shares,
        by_multiplier,
        _settled(np.array(linear)[:, np.newaxis], shares)[:, 0],
        max(linear),
        size,
        seed,
        _settled(np.array(walked), shares),
    )


def _settled(sizes: Array, levels: Array) -> NDArray[np.int64]:
    """(k, N) first strides from which sizes (strides, N) stay at or below each level; or −1."""
    above = ~(sizes <= levels[:, np.newaxis, np.newaxis])  # NaN after a fall is above
    last = above.shape[1] - np.argmax(above[:, ::-1], axis=1)
    first = np.where(above.any(axis=1), last, 0)
    return np.where(first == above.shape[1], -1, first)
