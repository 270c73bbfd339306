"""`powered-walker boundary`, `basin`: regions of two parameters or two coordinates."""

from __future__ import annotations

import argparse
import math
from collections import Counter
from typing import Any

import numpy as np

from powered_walker_env.cli.long import add_longest_step, add_running
from powered_walker_env.cli.options import (
    MOST_STRIDES,
    add_command,
    add_walker,
    check_count,
    gait_of,
    powered_by,
    range_around,
    walker_of,
)
from powered_walker_env.cli.output import Progress, Report, add_out, figures, unfinished
from powered_walker_env.model.phases import Outcome
from powered_walker_env.model.state import natural_units
from powered_walker_env.poincare import (
    PARAMETERS,
    Basin,
    Boundary,
    Gait,
    GaitNotFoundError,
    Slice,
    basin,
    stability_boundaries,
)
from powered_walker_env.poincare.families import Bounds, check_parameter, value_of
from powered_walker_env.poincare.regions.basins import FELL
from powered_walker_env.poincare.regions.slices import COORDINATES, SLICES, slice_through
from powered_walker_env.simulation.strides import Array
from powered_walker_env.tabular import aligned

SLICED = "simplest"  # the walker of the planes of the literature
WIDER = (0.05, 0.2, 0.8, 3.0, 12.0)  # of the values: how far boundaries are looked for
REACHES = [0.01 * 2**k for k in range(8)]  # natural units around the gait: how far basins go
UNSTABLE_REACH = 0.1  # the same for a gait that nothing ends on
COARSE = 60  # starts across and up that a window is judged by
MARGIN = 0.15  # of the basin's box: left free around it


def add_commands(commands: Any) -> None:
    """Add this family's commands."""
    edge = add_command(
        commands, "boundary", _boundary, "map where the gait loses its stability in two parameters"
    )
    add_walker(edge)
    edge.add_argument(
        "--parameters", nargs=2, choices=PARAMETERS, metavar=("ACROSS", "UP"),
        help="(default: switch_angle stall_torque, or what else powers the walker; of a passive "
        "one, com_across slope, or with massless feet hip_stiffness slope)",
    )  # fmt: skip
    edge.add_argument(
        "--bounds", type=float, nargs=4, metavar=("LOW", "HIGH", "LOW", "HIGH"),
        help="of both; wide enough for the gait to lose its stability if left out",
    )  # fmt: skip
    add_longest_step(edge)
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
        "--slice", choices=SLICES, metavar="NAME",
        help=f"a plane of the literature, one of {', '.join(SLICES)}, with its own walker "
        f"({SLICED}), axes and bounds",
    )  # fmt: skip
    starts.add_argument(
        "--bounds", type=float, nargs=4, metavar=("LOW", "HIGH", "LOW", "HIGH"),
        help="of both, rad or rad/s; around the whole basin if left out",
    )  # fmt: skip
    starts.add_argument(
        "--points", type=int, nargs=2, default=[160, 160], metavar=("ACROSS", "UP"),
        help="of the grid (default: 160 160)",
    )  # fmt: skip
    starts.add_argument("--strides", type=int, default=100, help="at most (default %(default)s)")
    add_running(starts)
    add_out(starts, resumable=True)


def _boundary(options: argparse.Namespace) -> Report:
    options.parameters = _parameters(options)
    gait = gait_of(options)
    with Progress("boundary") as progress:
        curves = _curves(options, gait, progress)
    nominal = [value_of(gait.params, gait.control, name) for name in options.parameters]
    title = f"Where the gait of {options.preset} loses its stability"
    return Report(
        "\n".join(map(_boundary_text, curves)), {"boundaries": [*map(_edge, curves)]},
        result=curves,
        draw=lambda: {"": figures().boundary_figure(curves, nominal=nominal, title=title)},
    )  # fmt: skip


def _curves(options: argparse.Namespace, gait: Gait, progress: Progress) -> tuple[Boundary, ...]:
    """The boundaries within the bounds given, or the narrowest that have any."""
    first, second = options.parameters
    given = options.bounds
    pairs = (None, None) if given is None else (given[:2], given[2:])
    for around in WIDER if given is None else WIDER[:1]:
        across, up = (
            range_around(pair, value_of(gait.params, gait.control, name), around, name)
            for pair, name in zip(pairs, options.parameters, strict=True)
        )
        try:
            return stability_boundaries(
                gait, (first, second), (across, up), step=options.longest_step,
                backend=options.backend, address=options.address, jobs=options.jobs,
                progress=progress, checkpoint=unfinished(options),
            )  # fmt: skip
        except GaitNotFoundError as error:
            nowhere = error
    raise nowhere


def _parameters(options: argparse.Namespace) -> list[str]:
    """The two parameters asked for, else the control, or what a passive walker lives by."""
    default = [*powered_by(options).numbers, "slope"][:2]
    massless = walker_of(options)[0].massless_foot
    passive = ["hip_stiffness" if massless else "com_across", "slope"]
    names: list[str] = options.parameters or (default if default[1:] else passive)
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
    check_count("--points, their product,", abs(math.prod(options.points)), least=0)
    check_count("strides", options.strides, most=MOST_STRIDES)
    if options.slice and (on := SLICES[options.slice]((1, 1)).on):
        options.preset, options.set = SLICED, [f"slope={on.params.slope}"]
    gait = gait_of(options)
    grid = _slice(options, gait)
    with Progress("basin") as progress:
        found = basin(
            gait.params, gait.control, grid, strides=options.strides,
            gaits=[gait] if gait.stable else [], backend=options.backend,
            address=options.address, jobs=options.jobs, progress=progress,
            checkpoint=unfinished(options),
        )  # fmt: skip
    title = f"Starts of {options.preset}, in a plane through its gait"
    return Report(
        _basin_text(found), _basin_data(found), result=found,
        draw=lambda: {"": figures().basin_figure(found, title=title)},
    )  # fmt: skip


def _slice(options: argparse.Namespace, gait: Gait) -> Slice:
    points, given = tuple(options.points), options.bounds
    if options.slice:
        return SLICES[options.slice](points)
    if given is None:
        ranges = _window(options, gait)
    else:
        ranges = range_around(given[:2], 0.0), range_around(given[2:], 0.0)
    return slice_through(gait, tuple(options.axes), ranges, points)


def _window(options: argparse.Namespace, gait: Gait) -> tuple[Bounds, Bounds]:
    """A rectangle around the whole basin, found on a coarse grid.

    It grows from the gait until what ends there leaves its edge free, and is then drawn in.
    """
    columns = [COORDINATES.index(name) for name in options.axes]
    centre = np.array(slice_through(gait, tuple(options.axes)).base)[columns]
    units = natural_units(gait.params)[columns]
    for reach in REACHES if gait.stable else [UNSTABLE_REACH]:
        low, high = centre - reach * units, centre + reach * units
        grid = slice_through(gait, tuple(options.axes), _pairs(low, high), (COARSE, COARSE))
        found = basin(
            gait.params, gait.control, grid, strides=options.strides,
            gaits=[gait] if gait.stable else [], backend="threading",
        )  # fmt: skip
        ends = found.picture("attractor") >= 0
        if not (ends[[0, -1]].any() or ends[:, [0, -1]].any()):
            break
    if ends.any():
        inside = found.states[ends.ravel()][:, columns]
        least, most = inside.min(axis=0), inside.max(axis=0)
        room = MARGIN * (most - least) + (high - low) / (COARSE - 1)
        low, high = np.maximum(low, least - room), np.minimum(high, most + room)
    return _pairs(low, high)


def _pairs(low: Array, high: Array) -> tuple[Bounds, Bounds]:
    return (float(low[0]), float(high[0])), (float(low[1]), float(high[1]))


def _basin_text(found: Basin) -> str:
    falls = Counter(Outcome(value) for value in found.outcome[found.attractor == FELL].tolist())
    shares = {
        "end on the gait": found.attracted_share,
        f"walk {found.limit} strides or more": found.walking_share,
        **{outcome.label: count / len(found.states) for outcome, count in falls.most_common()},
    }
    rows = ((name, f"{100 * share:.2f} %") for name, share in shares.items())
    return "\n".join(aligned([("starts", str(len(found.states))), *rows], left=2))


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
