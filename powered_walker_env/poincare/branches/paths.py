"""Continuation along a path of one's own: λ to a walker and its control.

Mass and length ratios move several fields at once. The derivative of the stride map along the
path is the exact one by every number of the walker and its control, times the path's own, which
is differenced (the path is cheap and smooth; strides are not differenced).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, fields
from typing import Any

import numpy as np

from powered_walker_env.model.checks import real_number
from powered_walker_env.model.phases import Outcome
from powered_walker_env.model.powering import AnyControl, Policy, scheme_of
from powered_walker_env.model.quantities import quantities
from powered_walker_env.model.walker import WalkerParams
from powered_walker_env.poincare.branches.arclength import MAX_POINTS
from powered_walker_env.poincare.branches.branch import Branch
from powered_walker_env.poincare.branches.continuation import followed
from powered_walker_env.poincare.families import (
    Bounds,
    Equations,
    Family,
    OffCurveError,
    multipliers_of,
    numbers_of,
)
from powered_walker_env.poincare.gaits import Gait
from powered_walker_env.poincare.maps import StrideMap
from powered_walker_env.simulation.derivatives import STATE_SIZE, WALKER_NUMBERS
from powered_walker_env.simulation.differences import BACKWARD, CENTRAL, FORWARD, differences
from powered_walker_env.simulation.strides import Array

PATH = "lambda"  # the name of what changes along it
DIFFERENCE = 1e-3  # of the bounds' width: step of the path's own differences

#: λ to a walker and its control (None: passive), of the same scheme all along.
Path = Callable[[float], tuple[WalkerParams, AnyControl | Policy | None]]


@dataclass(frozen=True, eq=False)
class PathFamily(Family):
    """The gaits along a path; its one unknown besides the state is λ."""

    path: Path = field(kw_only=True)
    bounds: Bounds = field(kw_only=True)
    value: float = field(kw_only=True)  # λ of the walker that the family was made from

    def __post_init__(self) -> None:
        """Names need no check: the path is the parameter."""

    def current(self) -> Array:
        """(1,) λ of the walker that the family was made from."""
        return np.array([self.value])

    def walker(self, values: Array) -> tuple[WalkerParams, AnyControl | Policy | None]:
        """The walker and control at λ (1,).

        Raises:
            ValueError: a path that leads elsewhere than to a walker of the same scheme.
        """
        return at_path(self.path, float(values[0]), self.control)

    def evaluate(self, u: Array) -> Equations:
        """As `Family.evaluate`."""
        value = self.values(u)
        try:
            stride_map = self.stride_map(value)
        except ValueError as error:
            raise OffCurveError(str(error)) from error
        slopes = self._slopes(value)
        moving = [name for name, slope in slopes.items() if slope != 0.0]
        state = self.state(u)
        point = stride_map.differentiate(state, self.period, moving)
        if point.outcome != Outcome.WALKED:
            raise OffCurveError(f"a stride ends with: {point.outcome.label}", fell=True)
        units = self.units[:STATE_SIZE]
        along = point.by_parameters @ np.array([slopes[name] for name in moving])
        jacobian = np.column_stack([point.by_state, along]) * self.units / units[:, np.newaxis]
        jacobian[:, :STATE_SIZE] -= np.eye(STATE_SIZE)
        residual = (point.state - state) / units
        return Equations(residual, jacobian, multipliers_of(point.by_state), point)

    def _slopes(self, value: Array) -> dict[str, float]:
        """The derivative of every number of walker and control by λ; one-sided at the bounds."""
        own = WALKER_NUMBERS if self.params.knee else tuple(quantities(WalkerParams))
        names = (*numbers_of(self.control), *own)

        def numbers(values: Array) -> Array:
            rows = []
            for each in values:
                params, control = self.walker(each)
                rows.append([_number(params, control, name) for name in names])
            return np.array(rows)

        step = DIFFERENCE * (self.bounds[1] - self.bounds[0])
        low, high = (abs(float(value[0]) - bound) for bound in self.bounds)
        near = min(low, high) < 2.0 * step
        stencil = CENTRAL if not near else FORWARD if low < high else BACKWARD
        found = differences(numbers, value[np.newaxis], step, stencil)[0, :, 0]
        scale = np.abs(numbers(value[np.newaxis])[0]) + 1.0
        found[np.abs(found) * step < 1e-13 * scale] = 0.0  # rounding
        return dict(zip(names, found.tolist(), strict=True))


@dataclass(frozen=True, eq=False)
class PathBranch(Branch):
    """A branch along a path; its values are λ."""

    path: Path = field(kw_only=True)

    def _stride_map(self, value: float) -> StrideMap:
        return StrideMap(*at_path(self.path, value, self.control))


def continue_path(
    path: Path,
    gait: Gait,
    bounds: Bounds,
    *,
    start: float | None = None,
    step: float | None = None,
    max_points: int = MAX_POINTS,
    least_clearance: float | None = None,
) -> PathBranch:
    """Follow a gait along a path of walkers and controls, both ways, through folds.

    Args:
        path: λ to (walker, control); smooth, the control of one scheme, its bounds included.
        gait: of the walker and control at `start`.
        bounds: of λ.
        start: λ of the gait; the lower bound if left out.
        The rest as in `continue_gait`.

    Raises:
        ValueError: bounds that do not rise or hold the start; a path that does not begin at
            the gait, leads to another scheme, or leaves a domain at its ends.
    """
    low, high = (real_number("bounds", value) for value in bounds)
    if not low < high:
        raise ValueError(f"bounds must rise, got {bounds!r}")
    first = low if start is None else real_number("start", start)
    if not low <= first <= high:
        raise ValueError(f"start must lie within the bounds {(low, high)!r}, got {first!r}")
    for value in (low, high):
        StrideMap(*at_path(path, value, gait.control))
    params, control = at_path(path, first, gait.control)
    if params != gait.params or control != gait.control:
        raise ValueError(
            f"gait must be of the walker and control at {PATH} = {first!r}, got one of another; "
            "find_gait(*path(start), ...) finds it"
        )
    family = PathFamily(
        params, control, (PATH,), np.array([high - low]), gait.period, path=path,
        bounds=(low, high), value=first,
    )  # fmt: skip
    branch = followed(family, gait, (low, high), step, max_points, least_clearance)
    return PathBranch(**{f.name: getattr(branch, f.name) for f in fields(branch)}, path=path)


def at_path(path: Path, value: float, like: Any) -> tuple[WalkerParams, AnyControl | Policy | None]:
    """What a path leads to.

    Raises:
        ValueError: no pair of a walker and a control, or one of another scheme.
    """
    found = path(value)
    good = isinstance(found, tuple) and len(found) == 2 and isinstance(found[0], WalkerParams)
    if not good or scheme_of(found[1]) is not scheme_of(like):
        raise ValueError(
            f"path must lead to (walker, control) with scheme {scheme_of(like).name!r}, got "
            f"{found!r} at {value!r}"
        )
    return found


def _number(params: WalkerParams, control: Any, name: str) -> float:
    return params.number(name) if name in WALKER_NUMBERS else float(getattr(control, name))
