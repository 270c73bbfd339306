"""`powered-walker branch`, `bifurcation`, `reproduce`: along one parameter."""

from __future__ import annotations

import argparse
import itertools
from typing import Any

import numpy as np

from powered_walker_env.cli.options import (
    add_command,
    add_range,
    add_running,
    add_walker,
    gait_of,
    parameter_of,
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
from powered_walker_env.poincare.branches.branch import Branch
from powered_walker_env.poincare.branches.continuation import continue_gait, switch_branch
from powered_walker_env.poincare.branches.ramps import BifurcationDiagram, Ramp, bifurcation_diagram
from powered_walker_env.poincare.branches.special_points import SpecialKind
from powered_walker_env.poincare.families import value_of
from powered_walker_env.poincare.gaits import GaitNotFoundError
from powered_walker_env.poincare.regions.slices import COORDINATES

RAMP = 0.01  # of a parameter's value: the range ramped through if none is given


def add_commands(commands: Any) -> None:
    """Add this family's commands."""
    branch = add_command(commands, "branch", _branch, "follow the gait along one parameter")
    add_walker(branch)
    add_range(branch)
    branch.add_argument("--step", type=float, help="longest step, as a share of the bounds' width")
    branch.add_argument(
        "--doubled", action=argparse.BooleanOptionalAction, default=True,
        help="follow the doubled gaits, too",
    )  # fmt: skip
    add_out(branch)
    ramps = add_command(
        commands, "bifurcation", _bifurcation, "walk while one parameter is ramped up and down"
    )
    add_walker(ramps)
    add_range(ramps)
    ramps.add_argument("--points", type=int, default=100, help="values (default %(default)s)")
    ramps.add_argument(
        "--transient", type=int, default=100, help="strides unseen at each (default %(default)s)"
    )
    ramps.add_argument("--keep", type=int, default=32, help="strides kept (default %(default)s)")
    ramps.add_argument(
        "--component",
        default=COORDINATES[0],
        choices=COORDINATES,
        help="drawn (default %(default)s)",
    )
    add_running(ramps)
    add_out(ramps, resumable=True)
    again = add_command(
        commands,
        "reproduce",
        _reproduce,
        "redraw the thesis's figures 4, 5 and 6, and check its text",
    )
    again.add_argument("--out", default="reproduce", help="folder, made (default %(default)s)")
    again.add_argument("--overwrite", action="store_true", help="replace files that exist")


def _branch(options: argparse.Namespace) -> Report:
    check_out(options)
    options.parameter = parameter_of(options)
    gait = gait_of(options)
    value = value_of(gait.params, gait.control, options.parameter)
    bounds = range_around(options.bounds, value)
    branches = [continue_gait(gait, options.parameter, bounds, step=options.step)]
    if options.doubled:
        branches += _doubled(branches[0], bounds, options.step)
    report = Report(
        "\n".join(_branch_text(b) for b in branches),
        {"branches": [_branch_data(b) for b in branches]},
    )
    title = f"Gaits of {options.preset}"
    return put_out(
        options, report, tuple(branches), lambda: figures().branch_figure(branches, title=title)
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
    check_out(options)
    if options.points < 2:
        raise ValueError(f"--points must be at least 2, got {options.points!r}")
    options.parameter = parameter_of(options)
    params, control, state = walker_of(options)
    value = value_of(params, control, options.parameter)
    low, high = range_around(options.bounds, value)
    if options.bounds is None and value:
        low, high = value * (1 - RAMP), value * (1 + RAMP)
    with Progress("bifurcation") as progress, unfinished(options) as folder:
        diagram = bifurcation_diagram(
            params, control, options.parameter, np.linspace(low, high, options.points), state=state,
            transient=options.transient, keep=options.keep, backend=options.backend,
            address=options.address, jobs=options.jobs, progress=progress, checkpoint=folder,
        )  # fmt: skip
        report = Report(_ramps_text(diagram), _ramps_data(diagram))
        title = f"Walks of {options.preset}, ramped"
        return put_out(
            options,
            report,
            diagram,
            lambda: figures().bifurcation_figure(diagram, component=options.component, title=title),
        )


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


def _reproduce(options: argparse.Namespace) -> Report:
    figures()
    from powered_walker_env.literature.figures import report_text, reproduce

    with Progress("reproduce") as progress:
        report = reproduce(options.out, overwrite=options.overwrite, progress=progress)
    return Report(f"{report_text(report)}\nwritten: {options.out}", report)
