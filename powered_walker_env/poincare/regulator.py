"""A linear-quadratic regulator of a gait: the simplest closed loop, within bounds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import scipy.linalg

from powered_walker_env.params import Control
from powered_walker_env.poincare.gaits import Gait
from powered_walker_env.poincare.maps import control_row, natural_units
from powered_walker_env.stride import Array


@dataclass(frozen=True, eq=False)
class Regulator:
    """u = u₀ + K (x − x₀), clipped to bounds: a policy of the stride map."""

    state: Array  # (4,) of the gait
    nominal: Array  # (2,) switch angle, rad, and stall torque, N m
    gain: Array  # (2, 4)
    low: Array  # (2,) bounds of the control
    high: Array
    cost: Array = field(repr=False)  # (4, 4) of the deviations to come, from (x − x₀), quadratic

    def __call__(self, states: Array) -> Array:
        """(N, 2) controls."""
        controls: Array = self.nominal + (states - self.state) @ self.gain.T
        return np.clip(controls, self.low, self.high)

    def derivative(self, states: Array) -> Array:
        """(N, 2, 4) of the controls by the states; zero where they are clipped."""
        wanted = self.nominal + (states - self.state) @ self.gain.T
        free = (wanted > self.low) & (wanted < self.high)
        derivative: Array = free[:, :, np.newaxis] * self.gain
        return derivative

    def costs(self, states: Array) -> Array:
        """(N,) sum over the strides to come of deviations and controls, as if linear."""
        away = states - self.state
        costs: Array = np.einsum("ni,ij,nj->n", away, self.cost, away)
        return costs


def regulate(gait: Gait, half_range: Sequence[float], action_cost: float = 0.1) -> Regulator:
    """The regulator of least Σ |x'|² + r |a|², x' in natural units and a in half ranges.

    Args:
        gait: of one stride under a constant control, stable or not.
        half_range: (2,) how far switch angle, rad, and stall torque, N m, may go from
            the gait's own; the torque is kept above 0 and the angle inside (0, 2π).
        action_cost: r.

    Raises:
        ValueError: a gait of several strides or without a constant control; no regulator.
    """
    if gait.period != 1 or not isinstance(gait.control, Control):
        raise ValueError(
            "gait must have one stride and a constant control, got "
            f"period {gait.period} and control {gait.control!r}"
        )
    reach = np.array(half_range, np.float64)
    if reach.shape != (2,) or not (reach > 0).all():
        raise ValueError(f"half_range must be two positive numbers, got {half_range!r}")
    units, nominal = natural_units(gait.params), control_row(gait.control)
    A = gait.jacobian * units / units[:, np.newaxis]
    B = gait.control_jacobian * reach / units[:, np.newaxis]
    R = action_cost * np.eye(2)
    try:
        P = scipy.linalg.solve_discrete_are(A, B, np.eye(4), R)
    except np.linalg.LinAlgError as error:
        raise ValueError(f"gait has no regulator within half_range: {error}") from error
    K = -np.linalg.solve(R + B.T @ P @ B, B.T @ P @ A)
    edge = np.array([1e-6, 0.0]), np.array([2 * np.pi - 1e-6, np.inf])
    return Regulator(
        state=np.array(gait.state),
        nominal=nominal,
        gain=reach[:, np.newaxis] * K / units,
        low=np.maximum(nominal - reach, edge[0]),
        high=np.minimum(nominal + reach, edge[1]),
        cost=P / np.outer(units, units),
    )
