"""Where studies start: on what is stable, not on whatever a search happens to find.

Beside a stable gait there often is an unstable one that Newton finds as readily (of a
passive walker the short gait of each pair); a study that starts there tells of falls where
the walker walks. So a study starts from a stable gait, followed along its branch to where
it is wanted; where the branch is unstable, the walker is walked on from where it is stable,
as the parameter changes: through doublings, to chaos.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np

from powered_walker_env.model.powering import CONTROL_NUMBERS, AnyControl, Policy
from powered_walker_env.model.state import PostStrikeState
from powered_walker_env.model.walker import WalkerParams
from powered_walker_env.poincare.branches.branch import Branch
from powered_walker_env.poincare.branches.continuation import continue_gait
from powered_walker_env.poincare.families import numbers_of, replaced, value_of
from powered_walker_env.poincare.gaits import Gait, GaitNotFoundError, find_gait
from powered_walker_env.poincare.maps import StrideMap
from powered_walker_env.poincare.search import FEW_STARTS, find_gaits
from powered_walker_env.poincare.tolerances import RAMP_RTOL
from powered_walker_env.simulation.derivatives import PARAMETERS
from powered_walker_env.simulation.strides import Array

ON_THE_WAY = 50  # strides walked at each value on the way to the next
WAY = 64  # values on the way from a gait to a range that lies apart from it
KICK = 1e-3  # of a state: off an unstable gait, on which it would stay for long


def stable_gait(
    params: WalkerParams,
    control: AnyControl | Policy | None,
    guess: PostStrikeState | Sequence[float] | None = None,
) -> Gait:
    """A stable gait of one stride, if one is found; else the least unstable.

    Args:
        params, control: the walker.
        guess: a post-strike state near the gait that is meant, tried first; then the gait
            of `find_gait` without a guess, then a short search by `find_gaits`.

    Raises:
        GaitNotFoundError: no gait at all.
    """
    found: list[Gait] = []
    problem = GaitNotFoundError("not tried")
    for start in [None] if guess is None else [guess, None]:
        try:
            found.append(find_gait(params, control, start))
        except GaitNotFoundError as error:
            problem = error
        else:
            if found[-1].stable:
                return found[-1]
    found += find_gaits(params, control, starts=FEW_STARTS)
    if not found:
        raise problem
    return min(found, key=lambda gait: gait.spectral_radius)


def changed(
    params: WalkerParams, control: AnyControl | Policy | None, parameter: str, value: float
) -> tuple[WalkerParams, AnyControl | Policy | None]:
    """The walker and its control with one number replaced.

    Raises:
        ValueError: not one of `PARAMETERS`, or a number of a control that is not constant.
    """
    if parameter not in (*PARAMETERS, *CONTROL_NUMBERS):
        raise ValueError(f"parameter must be one of {', '.join(PARAMETERS)}, got {parameter!r}")
    if hasattr(params, parameter):
        return params.replace(**{parameter: value}), control
    if parameter not in numbers_of(control):
        raise ValueError(
            f"parameter {parameter!r} is no number of a constant control, got control={control!r}; "
            "ramp a parameter of the walker instead"
        )
    return params, replaced(control, parameter, value)


def starts_along(
    params: WalkerParams,
    control: AnyControl | Policy | None,
    parameter: str,
    values: Array,
    state: PostStrikeState | Sequence[float] | None = None,
) -> Array:
    """(n, 4) at each value a state that something stable attracts; NaN where none was found.

    Args:
        params, control: the walker, with a gait at its own value of the parameter.
        parameter: one of `PARAMETERS`.
        values: (n,) ascending.
        state: near the gait that is meant, or any state that walks.
    """

    def walked(value: float, start: Array) -> Array:
        walker = StrideMap(*changed(params, control, parameter, value), RAMP_RTOL)
        return walker(start[np.newaxis], ON_THE_WAY)[0]

    own = value_of(params, control, parameter)
    starts, seed = np.full((len(values), 4), np.nan), None
    try:
        gait = stable_gait(params, control, state)
    except GaitNotFoundError:
        if state is None:
            return starts
        start = np.array(state, dtype=np.float64)
    else:
        start = (
            np.array(gait.state) if gait.stable else (1.0 + KICK) * np.array(state or gait.state)
        )
        low, high = min(own, values[0]), max(own, values[-1])
        if low < high:
            branch = continue_gait(gait, parameter, (low, high))
            starts, seed = _stable_on(branch, values), _nearest_stable(branch, values)
    if np.isnan(starts).all():
        value, last = seed or (own, start)
        first = int(np.argmin(abs(values - value)))
        for between in np.linspace(value, values[first], WAY + 1)[1:].tolist():
            last = walked(between, last)
        starts[first] = last
    for order in (range(len(values)), range(len(values) - 1, -1, -1)):
        for before, i in itertools.pairwise(order):
            if np.isnan(starts[i]).any() and np.isfinite(starts[before]).all():
                starts[i] = walked(float(values[i]), starts[before])
    return starts


def _stable_on(branch: Branch, values: Array) -> Array:
    """(n, 4) the stable gaits of a branch at these values; NaN where it has none."""
    found = np.full((len(values), 4), np.nan)
    for i, value in enumerate(values.tolist()):
        try:
            stable = [gait for gait in branch.at(value) if gait.stable]
        except GaitNotFoundError:
            continue
        if stable:
            found[i] = stable[0].state
    return found


def _nearest_stable(branch: Branch, values: Array) -> tuple[float, Array] | None:
    """The stable gait of a branch that is nearest to a range: its value and state."""
    if not branch.stable.any():
        return None
    rows = np.flatnonzero(branch.stable)
    inside = np.clip(branch.values[rows], values[0], values[-1])
    row = rows[np.argmin(abs(branch.values[rows] - inside))]
    return float(branch.values[row]), branch.states[row]
