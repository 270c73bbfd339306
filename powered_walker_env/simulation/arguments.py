"""Arguments of strides, checked: states, controls of any kind, walkers, heights, tolerance."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from powered_walker_env.model.checks import real_number
from powered_walker_env.model.mechanics.packing import pack, pack_all
from powered_walker_env.model.powering import (
    MOTOR,
    PASSIVE,
    AnyControl,
    Policy,
    Scheme,
    as_policy,
    numbers_for,
    scheme_named,
    scheme_of,
)
from powered_walker_env.model.walker import WalkerParams

TIGHTEST, LOOSEST = 1e-13, 1e-3  # bounds of rtol: rounding, and sense

Array = NDArray[np.float64]

LEVEL = np.zeros(1)  # one height for all; everybody's, not to be written to


class CheckedBatch(NamedTuple):
    """What `stride_batch` takes, checked, as the kernel takes it."""

    scheme: Scheme
    policy: Policy | None
    states: Array  # (N, 4)
    controls: Array  # (N, 2)
    rows: Array  # (N or 1, ROW) packed walkers


def check_batch(
    states: ArrayLike,
    controls: ArrayLike | AnyControl | Policy | None,
    params: WalkerParams | Sequence[WalkerParams],
    scheme: str | None = None,
) -> CheckedBatch:
    """The arguments of `stride_batch`.

    Raises:
        ValueError: wrong shapes, or a value out of its domain, naming the row.
    """
    start = _matrix("states", states, 4)
    count = len(start)
    walkers = (params,) if isinstance(params, WalkerParams) else tuple(params)
    if len(walkers) not in (1, count):
        raise ValueError(f"params must be one walker or {count}, got {len(walkers)}")
    control: Any = as_policy(controls, *start[:1]) if callable(controls) else controls
    powered = _scheme_for(control, scheme)
    for walker in walkers:
        if not isinstance(walker, WalkerParams):
            raise TypeError(f"params must be a WalkerParams or several, got {walker!r}")
        powered.check_walker(walker)
    rows = pack(walkers[0])[np.newaxis] if len(walkers) == 1 else pack_all(walkers)
    if _is_numbers(control):
        chosen = powered.rows(_numbers(control, powered, count))
    else:
        chosen = rows_of(control, start)
    return CheckedBatch(powered, control if callable(control) else None, start, chosen, rows)


def rows_of(control: AnyControl | Policy | None, states: Array) -> Array:
    """(N, 2) the kernel's rows of the controls of strides from states (N, 4), checked.

    Raises:
        ValueError: a policy's numbers of another shape, or outside their domain.
    """
    powered, numbers = scheme_of(control), numbers_for(control, states)
    powered.check(numbers)
    return powered.rows(numbers)


def _is_numbers(control: Any) -> bool:
    """Whether it is an array of numbers, rather than a control, a policy or None."""
    fields = hasattr(control, "__dataclass_fields__")
    return not (control is None or callable(control) or fields)


def _scheme_for(control: Any, name: str | None) -> Scheme:
    """What powers the walkers of a batch."""
    if _is_numbers(control):
        return MOTOR if name is None else scheme_named(name)
    own = scheme_of(control)
    if name is not None and scheme_named(name) is not own:
        given = "None, which is passive" if own is PASSIVE else f"one of scheme {own.name!r}"
        raise ValueError(
            f"controls must be of scheme {name!r}, got {given}; leave scheme out, or give its "
            "numbers"
        )
    return own


def check_rtol(rtol: float) -> float:
    """The tolerance as a float.

    Raises:
        ValueError: outside 1e-13 to 1e-3; TypeError: no number.
    """
    tolerance = real_number("rtol", rtol)
    if not TIGHTEST <= tolerance <= LOOSEST:
        raise ValueError(f"rtol must lie in [{TIGHTEST}, {LOOSEST}], got {rtol!r}")
    return tolerance


def _matrix(name: str, values: ArrayLike, columns: int) -> Array:
    """`values` as a contiguous (N, columns) array of finite floats."""
    matrix = np.ascontiguousarray(values, dtype=np.float64)
    if matrix.ndim != 2 or matrix.shape[1] != columns:
        raise ValueError(f"{name} must have shape (N, {columns}), got {matrix.shape}")
    finite = np.atleast_1d(np.isfinite(matrix).all(axis=1))
    _require_rows(finite, name, "be finite", matrix)
    return matrix


def _require_rows(good: NDArray[np.bool_], name: str, need: str, values: Array) -> None:
    if not good.all():
        row = int(np.argmin(good))
        raise ValueError(f"{name} must {need}, got {values[row].tolist()} in row {row}")


def _numbers(controls: ArrayLike, powered: Scheme, count: int) -> Array:
    """(N, k) the numbers of the controls, checked."""
    values = np.asarray(controls, dtype=np.float64)
    if values.ndim == 1:
        values = np.tile(values, (count, 1))
    values = _matrix("controls", values, len(powered.columns))
    if len(values) != count:
        raise ValueError(
            f"controls must have one row for each of {count} states, got {len(values)}"
        )
    powered.check(values)
    return values


def check_heights(step_height: ArrayLike, count: int) -> Array:
    """One height or N of them, (1,) or (N,).

    Raises:
        ValueError: another shape, or a height that is not finite.
    """
    given: Any = step_height
    if type(given) is float and given == 0.0:
        return LEVEL
    heights = np.atleast_1d(np.asarray(step_height, dtype=np.float64))
    if heights.shape not in ((1,), (count,)):
        raise ValueError(f"step_height must be one height or {count}, got shape {heights.shape}")
    _require_rows(np.atleast_1d(np.isfinite(heights)), "step_height", "be finite", heights)
    return np.ascontiguousarray(heights)
