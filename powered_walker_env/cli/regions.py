"""`powered-walker boundary`, `basin`: regions of two parameters or two coordinates."""

from __future__ import annotations

import argparse
from collections import Counter
from typing import Any

from powered_walker_env.cli.options import (
    add_command,
    add_running,
    add_walker,
    gait_of,
    powered_by,
    range_around,
    walker_of,
)
from powered_walker_env.cli.output import (
    Progress,
    Report,
    add_out,
    check_out,
    figures,
    put_out,
    unfinished,
)
from powered_walker_env.model.phases import Outcome
from powered_walker_env.poincare import PARAMETERS, Gait
from powered_walker_env.poincare.branches.boundary import Boundary, stability_boundaries
from powered_walker_env.poincare.families import check_parameter, value_of
from powered_walker_env.poincare.regions.basins import FELL, Basin, basin
from powered_walker_env.poincare.regions.slices import COORDINATES, Slice, slice_through


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
    add_running(edge)
    add_out(edge, resumable=True)
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
    check_out(options)
    options.parameters = _parameters(options)
    gait = gait_of(options)
    first, second = options.parameters
    given = options.bounds or [None] * 4
    pairs = [None if pair[0] is None else pair for pair in (given[:2], given[2:])]
    values = [value_of(gait.params, gait.control, name) for name in (first, second)]
    bounds = tuple(range_around(p, v) for p, v in zip(pairs, values, strict=True))
    with Progress("boundary") as progress, unfinished(options) as folder:
        curves = stability_boundaries(
            gait, (first, second), (bounds[0], bounds[1]), step=options.step,
            backend=options.backend, address=options.address, jobs=options.jobs,
            progress=progress, checkpoint=folder,
        )  # fmt: skip
        text, data = "\n".join(map(_boundary_text, curves)), [*map(_edge, curves)]
        report = Report(text, {"boundaries": data})
        nominal = (values[0], values[1])
        title = f"Where the gait of {options.preset} loses its stability"
        return put_out(
            options,
            report,
            curves,
            lambda: figures().boundary_figure(curves, nominal=nominal, title=title),
        )


def _parameters(options: argparse.Namespace) -> list[str]:
    """The two parameters asked for, else the control, or what a passive walker lives by."""
    default = [*powered_by(options).numbers, "slope"][:2]
    names: list[str] = options.parameters or (default if default[1:] else ["com_across", "slope"])
    control = walker_of(options)[1]
    for name in names:
        check_parameter(name, control)
    return names


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
    check_out(options)
    gait = gait_of(options)
    grid = _slice(options, gait)
    with Progress("basin") as progress, unfinished(options) as folder:
        found = basin(
            gait.params, gait.control, grid, strides=options.strides,
            gaits=[gait] if gait.stable else [], backend=options.backend,
            address=options.address, jobs=options.jobs, progress=progress, checkpoint=folder,
        )  # fmt: skip
        report = Report(_basin_text(found), _basin_data(found))
        title = f"Starts of {options.preset}, in a slice through its gait"
        return put_out(options, report, found, lambda: figures().basin_figure(found, title=title))


def _slice(options: argparse.Namespace, gait: Gait) -> Slice:
    given = options.bounds
    ranges = None if given is None else (tuple(given[:2]), tuple(given[2:]))
    return slice_through(gait, tuple(options.axes), ranges, tuple(options.points))


def _basin_text(found: Basin) -> str:
    falls = Counter(Outcome(value) for value in found.outcome[found.attractor == FELL].tolist())
    lines = [
        f"starts                      {len(found.states)}",
        f"end on the gait             {100 * found.attracted_share:.2f} %",
        f"walk {found.limit:4d} strides or more   {100 * found.walking_share:.2f} %",
    ]
    for outcome, count in falls.most_common():
        lines.append(f"{outcome.label:27s} {100 * count / len(found.states):.2f} %")
    return "\n".join(lines)


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
