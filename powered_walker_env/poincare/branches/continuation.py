"""Continuation: gaits followed along one parameter, through folds, stable or not.

The thesis ramped the stall torque and watched where the walker went (section 8), which
shows stable gaits only. Here the fixed-point equation itself is followed by
pseudo-arclength (`arclength.py`, which says why it is our own), and the bifurcations on
the way are located (`special_points.py`). At a doubling, a branch of twice the period
starts along the eigenvector of the multiplier −1 (Kuznetsov, section 10.2.3).
"""

from __future__ import annotations

import numpy as np

from powered_walker_env.poincare.branches.arclength import (
    MAX_POINTS,
    CurveEnd,
    EndReason,
    Solution,
    Stop,
    correct,
    follow,
    locate,
    passes,
    tangent_of,
    window_of,
)
from powered_walker_env.poincare.branches.branch import Branch, branch_of, work_and_clearance
from powered_walker_env.poincare.branches.special_points import (
    SpecialKind,
    SpecialPoint,
    special_points,
)
from powered_walker_env.poincare.families import Bounds, Family, OffCurveError, family_within
from powered_walker_env.poincare.gaits import Gait
from powered_walker_env.poincare.tolerances import SHORTEST_STRIDE
from powered_walker_env.simulation.derivatives import STATE_SIZE
from powered_walker_env.simulation.strides import Array

AMPLITUDES = (1e-3, 3e-4, 3e-3)  # natural units, of the first doubled gait; tried in turn
CLEARANCE_SLACK = 1e-9  # leg lengths: a clean step's least clearance is 0 to rounding, at landing


def continue_gait(
    gait: Gait,
    parameter: str,
    bounds: Bounds,
    *,
    step: float | None = None,
    max_points: int = MAX_POINTS,
    least_clearance: float | None = None,
) -> Branch:
    """Follow a gait along a parameter, both ways, through folds, stable or not.

    Args:
        gait: where to start.
        parameter: any name of `PARAMETERS` (under a policy: none of the controls).
        bounds: of the parameter; the branch ends on them. Their distance is its unit of
            arclength, beside radians and √(g/L) for the state.
        step: longest arclength between two points; 0.02 if left out. Where the branch
            bends the steps are shorter.
        max_points: most points in each direction from the start.
        least_clearance: m; stop where the clearance after mid-swing comes down to this
            (0: where the walker scuffs). Left out, it is not looked at: the model allows
            scuffing.

    Returns:
        The branch, its special points located to rounding, and why each end is one.

    Raises:
        ValueError: an unknown parameter, bounds that do not hold the gait or leave the
            parameter's domain.
    """
    family = family_within(gait, [parameter], [bounds])
    return followed(family, gait, bounds, step, max_points, least_clearance)


def followed(
    family: Family,
    gait: Gait,
    bounds: Bounds,
    step: float | None,
    max_points: int,
    least_clearance: float | None,
) -> Branch:
    """The branch of a gait in a family with one parameter, both ways."""
    u = family.unknowns(gait.state, family.current())
    forward = np.eye(STATE_SIZE + 1)[-1]
    tangent = tangent_of(family.evaluate(u).jacobian, forward)
    start = correct(family, u, tangent, float(tangent @ u), forward)
    window = window_of(family, [bounds], step, max_points)
    stop = _stops(family, start, gait, least_clearance)
    ahead, end = follow(family, start, window, stop)
    if end.reason is EndReason.CLOSED:
        points, ends = [start, *ahead], (end, end)
    else:
        back, beginning = follow(family, start._replace(tangent=-start.tangent), window, stop)
        turned = [point._replace(tangent=-point.tangent) for point in reversed(back)]
        points, ends = [*turned, start, *ahead], (beginning, end)
    specials = special_points(family, points)
    return branch_of(family, gait.section, bounds, points, specials, ends)


def switch_branch(
    point: SpecialPoint,
    bounds: Bounds,
    *,
    step: float | None = None,
    max_points: int = MAX_POINTS,
    least_clearance: float | None = None,
) -> Branch:
    """The branch of twice the period that starts at a period doubling.

    The first gait is a little way off; the branch ends where it comes back to a doubling
    of its parent, or as `continue_gait` says.

    Raises:
        ValueError: a special point that is no doubling.
        GaitNotFoundError: no doubled gait nearby, as at a degenerate doubling.
    """
    if point.kind is not SpecialKind.PERIOD_DOUBLING:
        raise ValueError(
            f"point must be a period doubling to switch branches at, got a {point.kind.value}; "
            "continue the gait itself with continue_gait"
        )
    family = family_within(point.gait, [point.parameter], [bounds], 2 * point.period)
    start = _doubled(family, point)
    window = window_of(family, [bounds], step, max_points)
    ahead, end = follow(family, start, window, _stops(family, start, None, least_clearance))
    begin = CurveEnd(EndReason.DOUBLING, f"{point.parameter} = {point.value!r}")
    points = [start, *ahead]
    specials = special_points(family, points)
    return branch_of(family, point.gait.section, bounds, points, specials, (begin, end))


def _doubled(family: Family, point: SpecialPoint) -> Solution:
    """A gait of twice the period, a small way along the critical eigenvector."""
    u = family.unknowns(point.state, [point.value])
    units = family.units[:STATE_SIZE]
    scaled = point.gait.jacobian * units / units[:, np.newaxis]
    values, vectors = np.linalg.eig(scaled)
    direction = np.append(vectors[:, np.argmin(abs(values + 1.0))].real, 0.0)
    direction /= np.linalg.norm(direction)
    problem = OffCurveError("not tried")
    for amplitude in AMPLITUDES:
        level = float(direction @ u) + amplitude
        try:
            return correct(family, u + amplitude * direction, direction, level, direction)
        except OffCurveError as error:
            problem = error
    raise OffCurveError(
        f"no doubled gait near {point.parameter} = {point.value!r}: {problem}; "
        "the doubling may be degenerate"
    )


def _stops(
    family: Family, start: Solution, gait: Gait | None, least_clearance: float | None
) -> Stop:
    """What ends a branch besides bounds and falls."""
    value = family.values(start.u)
    states = [family.state(start.u)] if gait is None else gait.states
    shifts = [family.unknowns(state, value) for state in states]
    taken = 0

    def stop(here: Solution, there: Solution) -> tuple[CurveEnd, Solution | None] | None:
        nonlocal taken
        taken = 1 if here.u is start.u else taken + 1
        if taken > 3 and any(passes(here, there, u) for u in shifts):
            return CurveEnd(EndReason.CLOSED, "back at the first gait"), None
        if abs(there.equations.point.step_length) < SHORTEST_STRIDE * family.params.leg_length:
            return CurveEnd(EndReason.STANDING, "the steps shrink to nothing"), None
        if family.period % 2 == 0 and _half(family, here.u) @ _half(family, there.u) < 0.0:
            return CurveEnd(EndReason.DOUBLING, "the two halves of the cycle meet"), None
        return None if least_clearance is None else _scuff(family, here, there, least_clearance)

    return stop


def _half(family: Family, u: Array) -> Array:
    """From the first state of the cycle to the one half a period later, scaled."""
    state = family.state(u)
    stride_map = family.stride_map(family.values(u))
    later = stride_map(state[np.newaxis], family.period // 2)[0]
    half: Array = (later - state) / family.units[:STATE_SIZE]
    return half


def _scuff(
    family: Family, here: Solution, there: Solution, least: float
) -> tuple[CurveEnd, Solution | None] | None:
    slack = CLEARANCE_SLACK * family.params.leg_length

    def spare(solution: Solution) -> float:
        return work_and_clearance(family, solution.u)[1] - least + slack

    if spare(there) >= 0.0:
        return None
    end = CurveEnd(EndReason.SCUFF, f"clearance after mid-swing below {least} m")
    return end, locate(family, here, there, spare) if spare(here) > 0.0 else None
