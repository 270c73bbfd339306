"""Disturbances: what the walker meets besides its own dynamics. Their levels: `levels.py`."""

from __future__ import annotations

import numbers
from dataclasses import dataclass
from typing import Any

import numpy as np

from powered_walker_env.model.knee import scaled
from powered_walker_env.model.quantities import Domain, quantities, quantity
from powered_walker_env.model.walker import WalkerParams
from powered_walker_env.simulation.strides import Array

# Columns of the normal draws of a stride.
PUSH, GROUND, TORQUE, SENSOR = slice(0, 2), 2, 3, slice(4, 8)
STEP_DRAWS = 8
EPISODE_DRAWS = 6  # normal draws of an episode: slope 1, parameters 4, one to spare
SPREAD_FIELDS = ("foot_length", "leg_mass", "leg_inertia", "no_load_speed")
STEEPEST = 1.5  # rad, of a slope drawn: short of a wall


def _deviation(unit: str, label: str, most: float) -> Any:
    """A field: a standard deviation of independent normal draws, 0 for none."""
    need = f"be a standard deviation in [0, {most:g}]"
    return quantity("σ", unit, label, Domain(0.0, most, "low high", need), 0.0)


@dataclass(frozen=True, kw_only=True)
class Disturbance:
    """Standard deviations of each kind of disturbance; 0 is none.

    The largest allowed are far beyond what any walker bears, and below what would leave the
    range of numbers: a draw may be 8.6 deviations.

    Raises:
        ValueError: a deviation that is no number, negative, or too large for its kind.
    """

    push: float = _deviation("rad/s", "both leg rates, after every heel strike", 100.0)
    ground: float = _deviation("leg lengths", "height of the ground, at every landing", 100.0)
    slope: float = _deviation("rad", "slope of the floor, once per episode", STEEPEST)
    torque: float = _deviation("of the strength", "strength of the control, every stride", 100.0)
    sensor: float = _deviation("observation", "all four numbers, at every observation", 100.0)
    parameters: float = _deviation("of each", "four parameters ¹, once per episode", 10.0)

    def __post_init__(self) -> None:
        for kind, each in quantities(self).items():
            value = getattr(self, kind)
            number = isinstance(value, numbers.Real) and not isinstance(value, bool)
            if not (number and each.domain.holds(float(value))):
                raise ValueError(f"disturbance {kind} must {each.domain.need}, got {value!r}")
            object.__setattr__(self, kind, float(value))

    def sizes(self, params: WalkerParams) -> Array:
        """(STEP_DRAWS,) standard deviations of the draws of a stride, SI units."""
        push, sensor = [self.push] * 2, [self.sensor] * 4
        return np.array([*push, self.ground * params.leg_length, self.torque, *sensor])


KINDS = tuple(quantities(Disturbance))


def episode_params(params: WalkerParams, disturbance: Disturbance, draws: Array) -> WalkerParams:
    """The walker of one episode: slope and parameter spread applied.

    With knees, mass and inertia are those of thigh and shank, each by the same factor.

    Args:
        draws: (EPISODE_DRAWS,) standard normal numbers.
    """
    changes: dict[str, Any] = {}
    if disturbance.slope > 0:
        slope = params.slope + disturbance.slope * draws[0]
        changes["slope"] = float(np.clip(slope, -STEEPEST, STEEPEST))
    if disturbance.parameters > 0:
        factors = np.exp(disturbance.parameters * draws[1:5])  # stays positive
        for field, factor in zip(SPREAD_FIELDS, factors.tolist(), strict=True):
            changes[field] = params.number(field) * factor
        if params.knee is not None:
            _, mass, inertia, _ = factors.tolist()
            changes |= scaled(params, mass, inertia)
    return params.replace(**changes) if changes else params
