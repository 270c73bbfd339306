"""`powered-walker boundary`, `basin`: regions of two parameters or two coordinates."""

from __future__ import annotations

import argparse
import math
from collections import Counter
from typing import Any

import numpy as np

from powered_walker_env.cli.options import (
    add_command,
    add_running,
    add_walker,
    check_count,
    gait_of,
    powered_by,
    range_around,
    walker_of,
)
from powered_walker_env.cli.output import Progress, Report, add_out, figures, unfinished
from powered_walker_env.model.phases import Outcome
from powered_walker_env.poincare import (
    PARAMETERS,
    Basin,
    Boundary,
    Gait,
    GaitNotFoundError,
    Slice,
    SpecialPoint,
    basin,
    continue_boundary,
    continue_gait,
)
from powered_walker_env.poincare.families import check_parameter, value_of
from powered_walker_env.poincare.maps import natural_units
from powered_walker_env.poincare.regions.basins import FELL
from powered_walker_env.poincare.regions.slices import COORDINATES
from powered_walker_env.simulation.strides import Array
from powered_walker_env.tabular import aligned

SAME_CURVE = 1e-3  # of the bounds' widths: a special point this near to a curve lies on it
REACH = 0.1  # natural units to either side of the gait: the slice looked at if none is given


def add_commands(commands: Any) -> None:
    """Add this family's commands."""
    edge = add_command(
        commands, "boundary", _boundary, "map where the gait loses its stability in two parameters"
    )
    add_walker(edge)
    edge.add_argument(
        "--parameters", nargs=2, choices=PARAMETERS, metavar=("ACROSS", "UP"),
        help="(default: switch_angle stall_torque, or what else powers the walker; of a passive "
        "one, com_across slope)",
    )  # fmt: skip
    edge.add_argument(
        "--bounds", type=float, nargs=4, metavar=("LOW", "HIGH", "LOW", "HIGH"),
        help="of both; 5%% to either side of the walker's values if left out",
    )  # fmt: skip
    edge.add_argument("--step", type=float, help="longest step, as a share of the bounds' widths")
    add_out(edge)
    starts = add_command(
        commands, "basin", _basin, "what becomes of the walker from each start in a slice"
    )
    add_walker(starts)
    starts.add_argument(
        "--axes", nargs=2, choices=COORDINATES, default=["stance_angle", "stance_rate"],
        metavar=("ACROSS", "UP"),
        help=f"two of {', '.join(COORDINATES)} (default: stance_angle stance_rate)",
    )  # fmt: skip
    starts.add_argument(
        "--bounds", type=float, nargs=4, metavar=("LOW", "HIGH", "LOW", "HIGH"),
        help="of both, rad or rad/s; 0.1 (0.1 sqrt(g/L)) around the gait if left out",
    )  # fmt: skip
    starts.add_argument(
        "--points", type=int, nargs=2, default=[100, 100], metavar=("ACROSS", "UP"),
        help="of the grid (default: 100 100)",
    )  # fmt: skip
    starts.add_argument("--strides", type=int, default=100, help="at most (default %(default)s)")
    add_running(starts)
    add_out(starts, resumable=True)


def _boundary(options: argparse.Namespace) -> Report:
    options.parameters = _parameters(options)
    gait = gait_of(options)
    first, second = options.parameters
    given = options.bounds or [None] * 4
    pairs = [None if pair[0] is None else pair for pair in (given[:2], given[2:])]
    values = [value_of(gait.params, gait.control, name) for name in (first, second)]
    bounds = tuple(range_around(p, v) for p, v in zip(pairs, values, strict=True))
    points = _limits(gait, second, bounds[1])
    curves: list[Boundary] = []
    with Progress("boundary") as progress:
        for number, point in enumerate(points):
            progress(number, len(points), math.nan)
            start = np.array([values[0], point.value])
            if not any(_passes(curve, point, start) for curve in curves):
                curves.append(
                    continue_boundary(
                        point, (first, second), (bounds[0], bounds[1]), step=options.step
                    )
                )
    nominal = (values[0], values[1])
    title = f"Where the gait of {options.preset} loses its stability"
    return Report(
        "\n".join(map(_boundary_text, curves)),
        {"boundaries": [*map(_edge, curves)]},
        result=tuple(curves),
        draw=lambda: {"": figures().boundary_figure(curves, nominal=nominal, title=title)},
    )


def _parameters(options: argparse.Namespace) -> list[str]:
    """The two parameters asked for, else the control, or what a passive walker lives by."""
    default = [*powered_by(options).numbers, "slope"][:2]
    names: list[str] = options.parameters or (default if default[1:] else ["com_across", "slope"])
    control = walker_of(options)[1]
    for name in names:
        check_parameter(name, control)
    return names


def _limits(gait: Gait, parameter: str, bounds: tuple[float, float]) -> list[SpecialPoint]:
    """Where the gait's branch loses its stability along one parameter.

    Raises:
        GaitNotFoundError: nowhere.
    """
    branch = continue_gait(gait, parameter, bounds)
    points = [point for point in branch.special_points if point.limits_stability]
    if not points:
        raise GaitNotFoundError(
            f"the gait's branch has no limit of stability for {parameter} in "
            f"[{bounds[0]:g}, {bounds[1]:g}]; give wider --bounds"
        )
    return points


def _passes(curve: Boundary, point: SpecialPoint, where: Array) -> bool:
    """Whether a curve already goes through a special point: curves may turn back."""
    widths = np.array([high - low for low, high in curve.bounds])
    corners = (curve.values - where) / widths
    steps = np.diff(corners, axis=0)
    lengths = np.maximum((steps**2).sum(axis=1), 1e-300)
    shares = np.clip(-(corners[:-1] * steps).sum(axis=1) / lengths, 0.0, 1.0)
    nearest = np.linalg.norm(corners[:-1] + shares[:, np.newaxis] * steps, axis=1).min()
    return curve.kind is point.kind and float(nearest) < SAME_CURVE


def _boundary_text(curve: Boundary) -> str:
    low, high = curve.values.min(axis=0), curve.values.max(axis=0)
    across, up = curve.parameters
    ends = " and ".join(end.reason.value for end in curve.ends)
    return (
        f"{curve.kind.value}: {len(curve)} points, {int(curve.limits_stability.sum())} of them "
        f"edges of stability; {across} {low[0]:.6g} to {high[0]:.6g}, {up} {low[1]:.6g} to "
        f"{high[1]:.6g}; ends: {ends}"
    )


def _edge(curve: Boundary) -> dict[str, Any]:
    return {
        "kind": curve.kind.value,
        "parameters": list(curve.parameters),
        "values": curve.values.tolist(),
        "limits_stability": curve.limits_stability.tolist(),
        "critical_angle_rad": curve.angle.tolist(),
        "ends": [{"reason": end.reason.value, "detail": end.detail} for end in curve.ends],
    }


def _basin(options: argparse.Namespace) -> Report:
    check_count("--points, their product,", abs(math.prod(options.points)), least=0)
    gait = gait_of(options)
    grid = _slice(options, gait)
    with Progress("basin") as progress:
        found = basin(
            gait.params, gait.control, grid, strides=options.strides,
            gaits=[gait] if gait.stable else [], backend=options.backend,
            address=options.address, jobs=options.jobs, progress=progress,
            checkpoint=unfinished(options),
        )  # fmt: skip
    title = f"Starts of {options.preset}, in a slice through its gait"
    return Report(
        _basin_text(found), _basin_data(found), result=found,
        draw=lambda: {"": figures().basin_figure(found, title=title)},
    )  # fmt: skip


def _slice(options: argparse.Namespace, gait: Gait) -> Slice:
    columns = [COORDINATES.index(name) for name in options.axes]
    centre = [gait.state[column] for column in columns]
    reach = REACH * natural_units(gait.params)[columns]
    around = [(c - r, c + r) for c, r in zip(centre, reach.tolist(), strict=True)]
    given = options.bounds
    across, up = around if given is None else (tuple(given[:2]), tuple(given[2:]))
    return Slice(gait.state, tuple(options.axes), (across, up), tuple(options.points))


def _basin_text(found: Basin) -> str:
    falls = Counter(Outcome(value) for value in found.outcome[found.attractor == FELL].tolist())
    rows = [
        ("starts", str(len(found.states))),
        ("end on the gait", f"{100 * found.attracted_share:.2f} %"),
        (f"walk {found.limit} strides or more", f"{100 * found.walking_share:.2f} %"),
    ]
    for outcome, count in falls.most_common():
        rows.append((outcome.label, f"{100 * count / len(found.states):.2f} %"))
    return "\n".join(aligned(rows, left=2))


def _basin_data(found: Basin) -> dict[str, Any]:
    grid = found.grid
    assert grid is not None
    return {
        "axes": list(grid.axes),
        "ranges": [list(pair) for pair in grid.ranges],
        "points": list(grid.shape),
        "limit": found.limit,
        "attracted_share": found.attracted_share,
        "walking_share": found.walking_share,
        "attractor": found.picture("attractor").tolist(),
        "strides": found.picture("strides").tolist(),
    }
