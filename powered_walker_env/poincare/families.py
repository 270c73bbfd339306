"""Families of gaits: the fixed-point equation with some of the walker's parameters free.

Unknowns are scaled, u = (state / natural units, values / scales), so that arclength and
Newton steps mean the same for a leg's angle and for a stall torque of 700 N m.
"""

from __future__ import annotations

import dataclasses
import functools
import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from powered_walker_env.model.checks import plain, real_number, require
from powered_walker_env.model.phases import Outcome
from powered_walker_env.model.powering import CONTROL_NUMBERS, AnyControl, Policy, scheme_of
from powered_walker_env.model.state import natural_units
from powered_walker_env.model.walker import WalkerParams
from powered_walker_env.poincare.gaits import Gait, GaitNotFoundError
from powered_walker_env.poincare.maps import MapPoint, StrideMap
from powered_walker_env.simulation.derivatives import STATE_SIZE, WALKER_NUMBERS
from powered_walker_env.simulation.strides import Array

Bounds = tuple[float, float]  # (low, high) of a parameter


class OffCurveError(GaitNotFoundError):
    """The equations have no value here; `fell` says whether because the walker falls."""

    def __init__(self, message: str, *, fell: bool = False) -> None:
        super().__init__(message)
        self.fell = fell


class Equations(NamedTuple):
    """F(u) and its derivative; a curve of solutions has one more unknown than equations."""

    residual: Array  # (m,)
    jacobian: Array  # (m, m + 1)
    multipliers: NDArray[np.complex128]  # (4,) of the gait, largest first
    point: MapPoint  # the stride map there


@dataclass(frozen=True, eq=False)
class Family:
    """The gaits of one walker with the parameters `names` free.

    Raises:
        ValueError: a name that is no parameter, or none of this walker.
    """

    params: WalkerParams
    control: AnyControl | Policy | None
    names: tuple[str, ...]
    scales: Array  # (k,) units of the parameters
    period: int = 1

    def __post_init__(self) -> None:
        for name in self.names:
            check_parameter(name, self.control)

    @functools.cached_property
    def units(self) -> Array:
        """(4 + k,) of the unknowns."""
        return np.concatenate([natural_units(self.params), self.scales])

    def values(self, u: Array) -> Array:
        """(k,) the parameters in their own units."""
        values: Array = u[STATE_SIZE : STATE_SIZE + len(self.names)] * self.scales
        return values

    def state(self, u: Array) -> Array:
        """(4,) the post-strike state in its own units."""
        state: Array = u[:STATE_SIZE] * self.units[:STATE_SIZE]
        return state

    def unknowns(self, state: Sequence[float] | Array, values: Sequence[float] | Array) -> Array:
        """The scaled unknowns of a state and parameter values."""
        unknowns: Array = np.concatenate([np.asarray(state), np.asarray(values)]) / self.units
        return unknowns

    def current(self) -> Array:
        """(k,) the values of the parameters in the walker that the family was made from."""
        return np.array([value_of(self.params, self.control, name) for name in self.names])

    def walker(self, values: Array) -> tuple[WalkerParams, AnyControl | Policy | None]:
        """The walker and control with the free parameters at these values.

        Raises:
            ValueError: a value outside the parameter's domain.
        """
        params, control = self.params, self.control
        for name, value in zip(self.names, values.tolist(), strict=True):
            if name in CONTROL_NUMBERS:
                control = replaced(control, name, value)
            else:
                params = params.replace(**{name: value})
        return params, control

    def stride_map(self, values: Array) -> StrideMap:
        """The map with the free parameters at these values."""
        return StrideMap(*self.walker(values))

    def evaluate(self, u: Array) -> Equations:
        """x ↦ fⁿ(x; p) − x and its derivative, scaled.

        Raises:
            OffCurveError: the walker falls, or a parameter leaves its domain.
        """
        try:
            stride_map = self.stride_map(self.values(u))
        except ValueError as error:
            raise OffCurveError(str(error)) from error
        state = self.state(u)
        point = stride_map.differentiate(state, self.period, self.names)
        if point.outcome != Outcome.WALKED:
            raise OffCurveError(f"a stride ends with: {point.outcome.label}", fell=True)
        state_units = self.units[:STATE_SIZE]
        moved = np.concatenate([point.by_state, point.by_parameters], axis=1)
        jacobian = moved * self.units / state_units[:, np.newaxis]
        jacobian[:, :STATE_SIZE] -= np.eye(STATE_SIZE)
        residual = (point.state - state) / state_units
        return Equations(residual, jacobian, multipliers_of(point.by_state), point)


def multipliers_of(jacobian: Array) -> NDArray[np.complex128]:
    """The multipliers of a (4, 4) Jacobian, largest first."""
    multipliers = np.linalg.eigvals(jacobian).astype(complex)
    return multipliers[np.argsort(-abs(multipliers), kind="stable")]


def check_parameter(name: str, control: AnyControl | Policy | None) -> None:
    """Reject a name that this walker has no such parameter for.

    Raises:
        ValueError: with the names there are.
    """
    known = (*numbers_of(control), *WALKER_NUMBERS)
    if name in known:
        return
    if name not in CONTROL_NUMBERS:
        raise ValueError(f"parameter must be one of {', '.join(known)}, got {name!r}")
    walker = "a walker under a policy" if callable(control) else "this walker"
    raise ValueError(
        f"parameter must not be {name!r} for {walker}, whose control has no such constant; "
        f"choose one of {', '.join(known)}"
    )


def numbers_of(control: AnyControl | Policy | None) -> tuple[str, ...]:
    """Names of the numbers of a constant control."""
    return () if callable(control) else scheme_of(control).numbers


def replaced(
    control: AnyControl | Policy | None, name: str, value: float
) -> AnyControl | Policy | None:
    """A constant control with one number changed."""
    assert control is not None and not callable(control)
    return dataclasses.replace(control, **{name: value})


def value_of(params: WalkerParams, control: AnyControl | Policy | None, name: str) -> float:
    """The value of a parameter in a walker and its control."""
    return float(getattr(control, name) if name in CONTROL_NUMBERS else params.number(name))


def _pair(bounds: Bounds) -> Bounds:
    """A pair of numbers, the second above the first."""
    if isinstance(bounds, str) or not isinstance(bounds, Sequence | np.ndarray) or len(bounds) != 2:
        raise TypeError(f"bounds must be a pair (low, high), got {bounds!r}")
    low, high = (real_number("bounds", plain(value)) for value in bounds)
    require(low < high, "bounds", "be finite and rising", (low, high))
    return low, high


def family_within(
    gait: Gait, names: Sequence[str], bounds: Sequence[Bounds], period: int | None = None
) -> Family:
    """The family of a gait with parameters between bounds, whose widths are the scales.

    Raises:
        ValueError: bounds that do not hold the gait, or leave a parameter's domain.
        TypeError: something else than a gait and pairs of numbers.
    """
    if not isinstance(gait, Gait):
        raise TypeError(f"gait must be a Gait, got {gait!r}; find_gait finds one")
    if len(bounds) != len(names):
        raise ValueError(f"bounds must be (low, high) for each of {names!r}, got {bounds!r}")
    bounds = [_pair(each) for each in bounds]
    scales = np.array([high - low for low, high in bounds], dtype=np.float64)
    family = Family(gait.params, gait.control, tuple(names), scales, period or gait.period)
    for name, value, (low, high) in zip(names, family.current().tolist(), bounds, strict=True):
        if not low <= value <= high:
            raise ValueError(f"bounds must hold the gait's {name} = {value!r}, got {(low, high)!r}")
    for corner in itertools.product(*bounds):
        family.stride_map(np.array(corner, dtype=np.float64))  # raises outside the domain
    return family
