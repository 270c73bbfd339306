"""A region around a stable gait that no stride leaves: who enters it has converged.

With A the Jacobian of the map over the gait's period and ρ < γ < 1 (ρ its spectral
radius), the matrix P of (A/γ)ᵀ P (A/γ) − P = −1 makes V(x) = √(x'ᵀ P x') (x' the
deviation in natural units) a norm in which the linear map contracts by γ. The
nonlinear map is then sampled on shells V = r of growing r; the region is V ≤ r/2 for
the last r up to which every sample came back with a smaller V by a margin. That is a
check by samples, not a proof.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from powered_walker_env.model.state import natural_units
from powered_walker_env.poincare.gaits import Gait
from powered_walker_env.poincare.maps import StrideMap
from powered_walker_env.poincare.tolerances import SEARCH_RTOL
from powered_walker_env.simulation.strides import Array

SHELL_SAMPLES = 512
SHELL_GROWTH = 2.0
SMALLEST, LARGEST = 1e-5, 1.0  # radii of shells, natural units
SAFETY = 0.5  # of the radius that the samples allow


@dataclass(frozen=True, eq=False)
class Trap:
    """Ellipsoids around the points of one stable gait."""

    states: Array  # (period, 4) post-strike states
    factors: Array  # (period, 4, 4): V(x) = |factor @ (x − state)|
    radii: Array  # (period,) of V
    contraction: float  # worst V(after the period)/V(before) over the samples within
    samples: int  # strides of the check

    def __repr__(self) -> str:
        return f"Trap({len(self.radii)} ellipsoids, contraction {self.contraction:.3g})"

    def holds(self, states: Array) -> NDArray[np.bool_]:
        """(N,) whether each state (N, 4) is inside one of the ellipsoids."""
        inside = np.zeros(len(states), np.bool_)
        for point, factor, radius in zip(self.states, self.factors, self.radii, strict=True):
            inside |= np.linalg.norm((states - point) @ factor.T, axis=1) <= radius
        return inside


def trap_around(gait: Gait, seed: int = 0) -> Trap:
    """The sampled trapping region of a stable gait.

    Raises:
        ValueError: an unstable gait, or one that attracts nothing that can be seen.
    """
    if not gait.stable:
        raise ValueError(
            "gait must be stable to attract anything, got one of spectral radius "
            f"{gait.spectral_radius:.4f}"
        )
    stride_map = StrideMap(gait.params, gait.control, SEARCH_RTOL)
    found = [
        _ellipsoid(stride_map, point, gait.period, gait.spectral_radius, seed)
        for point in gait.states
    ]
    factors, radii, ratios = zip(*found, strict=True)
    samples = SHELL_SAMPLES * len(_shells()) * gait.period
    return Trap(gait.states, np.array(factors), np.array(radii), max(ratios), samples)


def traps_of(gaits: Sequence[Gait]) -> tuple[Trap, ...]:
    """One region for each gait of a list."""
    return tuple(trap_around(gait) for gait in gaits)


def _shells() -> Array:
    number = int(np.log(LARGEST / SMALLEST) / np.log(SHELL_GROWTH)) + 1
    radii: Array = SMALLEST * SHELL_GROWTH ** np.arange(number, dtype=np.float64)
    return radii


def _ellipsoid(
    stride_map: StrideMap, point: Array, period: int, radius: float, seed: int
) -> tuple[Array, float, float]:
    """(factor, radius, worst ratio) of the region around one point of the cycle."""
    units, target = natural_units(stride_map.params), 0.5 * (1.0 + radius)
    by_state = stride_map.differentiate(point, period).by_state * units / units[:, np.newaxis]
    matrix = scipy.linalg.solve_discrete_lyapunov(by_state.T / target, np.eye(4))
    factor = np.linalg.cholesky(matrix).T / units
    sphere = np.random.default_rng(seed).normal(size=(SHELL_SAMPLES, 4))
    sphere /= np.linalg.norm(sphere, axis=1, keepdims=True)
    offsets = np.linalg.solve(factor, sphere.T).T  # V = 1
    allowed, last, worst = 0.5 * (1.0 + target), 0.0, 0.0
    for r in _shells():
        after = stride_map(point + r * offsets, period) - point
        ratio = float(np.max(np.linalg.norm(after @ factor.T, axis=1))) / r
        if not ratio <= allowed:  # a fall is NaN
            break
        last, worst = float(r), max(worst, ratio)
    if last == 0.0:
        raise ValueError(
            f"gait must attract a region of natural units beyond {SMALLEST:g}, got one that "
            f"does not contract there; its spectral radius is {radius:.6f}"
        )
    return factor, SAFETY * last, worst
