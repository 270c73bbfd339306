"""`powered-walker branch`, `bifurcation`: along one parameter."""

from __future__ import annotations

import argparse
import itertools
from typing import Any

import numpy as np

from powered_walker_env.cli.long import add_longest_step, add_running
from powered_walker_env.cli.options import (
    add_command,
    add_range,
    add_walker,
    check_count,
    gait_of,
    parameter_of,
    range_around,
    walker_of,
)
from powered_walker_env.cli.output import Progress, Report, add_out, figures, unfinished
from powered_walker_env.poincare import (
    BifurcationDiagram,
    Branch,
    GaitNotFoundError,
    SpecialKind,
    bifurcation_diagram,
    continue_gait,
    switch_branch,
)
from powered_walker_env.poincare.branches.ramps import Ramp
from powered_walker_env.poincare.families import value_of
from powered_walker_env.poincare.regions.slices import COORDINATES

STEP = 0.005  # of a branch: fine enough for its lines to look like curves
RAMP = 0.01  # of a parameter's value: the range ramped through if none is given


def add_commands(commands: Any) -> None:
    """Add this family's commands."""
    branch = add_command(commands, "branch", _branch, "follow the gait along one parameter")
    add_walker(branch)
    add_range(branch)
    add_longest_step(branch, STEP)
    branch.add_argument(
        "--doubled", action=argparse.BooleanOptionalAction, default=True,
        help="follow the doubled gaits, too",
    )  # fmt: skip
    add_out(branch, tables=("-points.csv",))
    ramps = add_command(
        commands, "bifurcation", _bifurcation, "walk while one parameter is ramped up and down"
    )
    add_walker(ramps)
    add_range(ramps, RAMP)
    ramps.add_argument("--points", type=int, default=400, help="values (default %(default)s)")
    ramps.add_argument(
        "--transient", type=int, default=200, help="strides unseen at each (default %(default)s)"
    )
    ramps.add_argument("--keep", type=int, default=64, help="strides kept (default %(default)s)")
    ramps.add_argument(
        "--component", default=COORDINATES[0], choices=COORDINATES, metavar="NAME",
        help=f"drawn, one of {', '.join(COORDINATES)} (default %(default)s)",
    )  # fmt: skip
    add_running(ramps)
    add_out(ramps, resumable=True)


def _branch(options: argparse.Namespace) -> Report:
    options.parameter = parameter_of(options)
    gait = gait_of(options)
    value = value_of(gait.params, gait.control, options.parameter)
    bounds = range_around(options.bounds, value, options.around, options.parameter)
    branches = [continue_gait(gait, options.parameter, bounds, step=options.longest_step)]
    if options.doubled:
        branches += _doubled(branches[0], bounds, options.longest_step)
    title = f"Gaits of {options.preset}"
    return Report(
        "\n".join(_branch_text(b) for b in branches),
        {"branches": [_branch_data(b) for b in branches]},
        result=tuple(branches),
        draw=lambda: {"": figures().branch_figure(branches, title=title)},
    )


def _doubled(branch: Branch, bounds: tuple[float, float], step: float | None) -> list[Branch]:
    """The branches of doubled gaits that start where the branch loses its stability."""
    found = []
    for point in branch.of_kind(SpecialKind.PERIOD_DOUBLING):
        if point.limits_stability:
            try:
                found.append(switch_branch(point, bounds, step=step))
            except GaitNotFoundError:
                continue  # a degenerate doubling: the branch itself is still worth having
    return found


def _branch_text(branch: Branch) -> str:
    strides = "stride" if branch.period == 1 else "strides"
    lines = [
        f"gaits of {branch.period} {strides}: {len(branch)}, {branch.parameter} "
        f"{branch.values.min():.6g} to {branch.values.max():.6g}"
    ]
    for end, value in zip(branch.ends, (branch.values[0], branch.values[-1]), strict=True):
        detail = f" ({end.detail})" if end.detail else ""
        lines.append(f"  ends at {value:.6f}: {end.reason.value}{detail}")
    for point in branch.special_points:
        limit = ", a limit of stability" if point.limits_stability else ""
        lines.append(f"  {point.kind.value} at {point.value:.8f}{limit}")
    for low, high in branch.stable_ranges():
        lines.append(f"  stable from {low:.6f} to {high:.6f}")
    return "\n".join(lines)


def _branch_data(branch: Branch) -> dict[str, Any]:
    return {
        "parameter": branch.parameter,
        "period": branch.period,
        "values": branch.values.tolist(),
        "spectral_radius": branch.spectral_radius.tolist(),
        "stable": branch.stable.tolist(),
        "step_length_m": branch.step_length.tolist(),
        "duration_s": branch.duration.tolist(),
        "states": branch.states.tolist(),
        "special_points": [
            {"kind": p.kind.value, "value": p.value, "limits_stability": p.limits_stability}
            for p in branch.special_points
        ],
        "stable_ranges": [list(pair) for pair in branch.stable_ranges()],
        "ends": [{"reason": end.reason.value, "detail": end.detail} for end in branch.ends],
    }


def _bifurcation(options: argparse.Namespace) -> Report:
    for name, least in (("--points", 2), ("--transient", 0), ("--keep", 2)):
        check_count(name, getattr(options, name.strip("-")), least)
    check_count("--points times --keep", options.points * options.keep)
    options.parameter = parameter_of(options)
    params, control, state = walker_of(options)
    value = value_of(params, control, options.parameter)
    low, high = range_around(options.bounds, value, options.around, options.parameter)
    with Progress("bifurcation") as progress:
        diagram = bifurcation_diagram(
            params, control, options.parameter, np.linspace(low, high, options.points), state=state,
            transient=options.transient, keep=options.keep, backend=options.backend,
            address=options.address, jobs=options.jobs, progress=progress,
            checkpoint=unfinished(options),
        )  # fmt: skip
    title, component = f"Walks of {options.preset}, ramped", options.component
    return Report(
        _ramps_text(diagram), _ramps_data(diagram), result=diagram,
        draw=lambda: {
            "": figures().bifurcation_figure(diagram, component=component, title=title)
        },
    )  # fmt: skip


def _ramps_text(diagram: BifurcationDiagram) -> str:
    names = {-2: "no stable start found", -1: "falls", 0: "no period found"}
    lines = []
    for name, ramp in (("up", diagram.up), ("down", diagram.down)):
        lines.append(f"ramped {name} through {len(diagram.values)} values of {diagram.parameter}:")
        periods = diagram.periods(ramp)
        starts = [0, *(np.flatnonzero(np.diff(periods)) + 1).tolist(), len(periods)]
        for first, after in itertools.pairwise(starts):
            low, high = diagram.values[first], diagram.values[after - 1]
            period = int(periods[first])
            lines.append(f"  {low:.6g} to {high:.6g}: {names.get(period, f'period {period}')}")
    return "\n".join(lines)


def _ramps_data(diagram: BifurcationDiagram) -> dict[str, Any]:
    def of(ramp: Ramp) -> dict[str, Any]:
        return {
            "periods": diagram.periods(ramp).tolist(),
            "restarted": ramp.restarted.tolist(),
            "last_states": ramp.states[:, -1].tolist(),
        }

    return {
        "parameter": diagram.parameter,
        "values": diagram.values.tolist(),
        "up": of(diagram.up),
        "down": of(diagram.down),
    }
