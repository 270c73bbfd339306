"""A linear-quadratic regulator of a gait: the simplest closed loop, within bounds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import scipy.linalg

from powered_walker_env.model.powering import ANGLE, MOTOR, scheme_of
from powered_walker_env.model.state import natural_units
from powered_walker_env.poincare.gaits import Gait
from powered_walker_env.simulation.strides import Array

Weights = float | Sequence[float] | Sequence[Sequence[float]] | Array
INSIDE = 1e-6  # rad, that an angle stays inside (0, 2π)


@dataclass(frozen=True, eq=False)
class Regulator:
    """u = u₀ + K (x − x₀), clipped to bounds: a policy of the stride map."""

    state: Array  # (4,) of the gait
    nominal: Array  # (k,) numbers of the control; of the motor: switch angle, stall torque
    gain: Array  # (k, 4)
    low: Array  # (k,) bounds of the control
    high: Array
    cost: Array = field(repr=False)  # (4, 4) of the deviations to come, from (x − x₀), quadratic
    scheme: str = MOTOR.name  # what the numbers control

    def __repr__(self) -> str:
        return f"Regulator({self.scheme} around {self.nominal.tolist()})"

    def __call__(self, states: Array) -> Array:
        """(N, k) controls."""
        controls: Array = self.nominal + (states - self.state) @ self.gain.T
        return np.clip(controls, self.low, self.high)

    def derivative(self, states: Array) -> Array:
        """(N, k, 4) of the controls by the states; zero where they are clipped."""
        wanted = self.nominal + (states - self.state) @ self.gain.T
        free = (wanted > self.low) & (wanted < self.high)
        derivative: Array = free[:, :, np.newaxis] * self.gain
        return derivative

    def costs(self, states: Array) -> Array:
        """(N,) sum over the strides to come of deviations and controls, as if linear."""
        away = states - self.state
        costs: Array = np.einsum("ni,ij,nj->n", away, self.cost, away)
        return costs


def regulate(
    gait: Gait,
    half_range: Sequence[float],
    action_cost: Weights = 0.1,
    state_cost: Weights = (1.0, 1.0, 1.0, 1.0),
) -> Regulator:
    """The regulator of least Σ x'ᵀ Q x' + aᵀ R a, x' in natural units and a in half ranges.

    Args:
        gait: of one stride under a constant control, stable or not.
        half_range: (k,) how far the numbers of the control (of the motor: switch angle,
            rad, and stall torque, N m) may go from the gait's own; a torque or impulse is
            kept above 0 and an angle inside (0, 2π).
        action_cost: R: a number, k weights or a (k, k) matrix, positive definite.
        state_cost: Q: a number, 4 weights (of stance and swing angle, stance and swing
            rate) or a (4, 4) matrix, not negative.

    Raises:
        ValueError: a gait of several strides or without a constant control; costs that will
            not do; no regulator.
    """
    if gait.period != 1 or gait.control is None or callable(gait.control):
        raise ValueError(
            "gait must have one stride and a constant control, got "
            f"period {gait.period} and control {gait.control!r}"
        )
    scheme = scheme_of(gait.control)
    reach = np.array(half_range, np.float64)
    if reach.shape != (len(scheme.numbers),) or not (reach > 0).all():
        raise ValueError(
            f"half_range must be {len(scheme.numbers)} positive numbers, one for each of "
            f"{', '.join(scheme.numbers)}, got {half_range!r}"
        )
    Q = _weights("state_cost", state_cost, 4, definite=False)
    R = _weights("action_cost", action_cost, len(reach), definite=True)
    units = natural_units(gait.params)
    nominal = np.array([getattr(gait.control, name) for name in scheme.numbers])
    A = gait.jacobian * units / units[:, np.newaxis]
    B = gait.control_jacobian * reach / units[:, np.newaxis]
    try:
        P = scipy.linalg.solve_discrete_are(A, B, Q, R)
    except np.linalg.LinAlgError as error:
        raise ValueError(f"gait has no regulator within half_range: {error}") from error
    K = -np.linalg.solve(R + B.T @ P @ B, B.T @ P @ A)
    angles = np.array(scheme.columns) == ANGLE
    least = 0.0 if scheme.positive else -np.inf
    return Regulator(
        state=np.array(gait.state),
        nominal=nominal,
        gain=reach[:, np.newaxis] * K / units,
        low=np.maximum(nominal - reach, np.where(angles, INSIDE, least)),
        high=np.minimum(nominal + reach, np.where(angles, 2 * np.pi - INSIDE, np.inf)),
        cost=P / np.outer(units, units),
        scheme=scheme.name,
    )


def _weights(name: str, value: Weights, size: int, *, definite: bool) -> Array:
    """A cost as a symmetric (size, size) matrix.

    Raises:
        ValueError: another shape, or a cost that rewards.
    """
    given = np.asarray(value, np.float64)
    if given.ndim < 2 and given.size in (1, size):
        given = np.diag(np.broadcast_to(given, (size,)))
    if given.shape != (size, size) or not np.isfinite(given).all() or (given != given.T).any():
        raise ValueError(
            f"{name} must be a number, {size} weights or a symmetric {size}x{size} matrix, "
            f"got {value!r}"
        )
    lowest = float(np.linalg.eigvalsh(given)[0])
    if lowest < 0 or (definite and lowest == 0):
        raise ValueError(
            f"{name} must {'be positive' if definite else 'not be negative'}, got {value!r}"
        )
    return given
