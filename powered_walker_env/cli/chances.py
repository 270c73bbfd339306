"""`powered-walker passage`, `viability`: walkers disturbed at every step, and what saves them."""

from __future__ import annotations

import argparse
from typing import Any

from powered_walker_env.cli.options import (
    MOST_STRIDES,
    add_command,
    add_walker,
    check_count,
    gait_of,
)
from powered_walker_env.cli.output import Progress, Report, add_out, figures
from powered_walker_env.model.powering import ANGLE, scheme_of
from powered_walker_env.poincare import StepNoise, capture, first_passage, largest_push
from powered_walker_env.tabular import aligned

PUSH_SHARE = 0.5  # of the largest single push survived: the noise if none is asked for
ANGLE_REACH, STRENGTH_REACH = 0.15, 0.3  # rad, and share of the strength, that controls may go
NODES = 60  # along each axis of a passage's or a kernel's grid, at most


def add_commands(commands: Any) -> None:
    """Add this family's commands."""
    _add_passage(commands)
    _add_viability(commands)


def _add_passage(commands: Any) -> None:
    parser = add_command(
        commands, "passage", _passage,
        "how long the walker walks until it falls, disturbed at every step",
    )  # fmt: skip
    add_walker(parser)
    parser.add_argument(
        "--push", type=float, default=0.0,
        help="standard deviation, rad/s, on both leg rates (if nothing disturbs: half of the "
        "largest single push that the gait survives)",
    )  # fmt: skip
    parser.add_argument(
        "--step-height", type=float, default=0.0,
        help="standard deviation, m, of the rise of each step",
    )  # fmt: skip
    parser.add_argument(
        "--strength", type=float, default=0.0, help="standard deviation, share of the strength"
    )
    parser.add_argument(
        "--nodes", type=int, default=24, help="of the grid, along each axis (default %(default)s)"
    )
    parser.add_argument(
        "--walks", type=int, default=4000, help="simulated beside it (default %(default)s)"
    )
    parser.add_argument("--seed", type=int, default=0, help="of these (default %(default)s)")
    add_out(parser)


def _add_viability(commands: Any) -> None:
    parser = add_command(
        commands, "viability", _viability,
        "which states any control within bounds can keep from falling",
    )  # fmt: skip
    add_walker(parser)
    parser.add_argument(
        "--half-range", type=float, nargs="+", metavar="VALUE",
        help=f"how far each number of the control may go (default: {ANGLE_REACH} rad of an "
        f"angle, {STRENGTH_REACH:.0%}% of a strength)",
    )  # fmt: skip
    parser.add_argument(
        "--push", type=float, default=0.0, help="bound of pushes at every heel strike, rad/s"
    )
    parser.add_argument(
        "--strides", type=int, default=20, help="looked ahead (default %(default)s)"
    )
    parser.add_argument(
        "--nodes", type=int, default=20, help="of the grid, along each axis (default %(default)s)"
    )
    parser.add_argument(
        "--controls", type=int, default=9, help="values of each number (default %(default)s)"
    )
    add_out(parser)


def _passage(options: argparse.Namespace) -> Report:
    check_count("--nodes", options.nodes, 6, NODES)
    check_count("--walks", options.walks, 100)
    gait = gait_of(options)
    noise = StepNoise(options.push, options.step_height, options.strength)
    if noise == StepNoise():
        single = largest_push(gait.params, gait.control, gait.state)
        noise = StepNoise(push=PUSH_SHARE * min(single.up, -single.down))
    with Progress("passage") as progress:
        found = first_passage(
            gait.params, gait.control, noise, gait.state, shape=options.nodes,
            walks=options.walks, seed=options.seed, progress=progress,
        )  # fmt: skip
    mean, error = found.walks.mean
    rows = [
        ("disturbed by", f"push {noise.push:.4g} rad/s, step {noise.step_height:.4g} m, "
         f"strength {noise.strength:.4g}"),
        ("second eigenvalue", f"{found.second_eigenvalue:.5f} ± {found.eigenvalue_error:.1g}"),
        ("mean first passage, strides", f"{found.mean_first_passage:.5g}"),
        ("mean strides from the gait", f"{found.mean_strides:.5g} ± {found.strides_error:.1g}"),
        (f"as simulated, of at most {found.walks.limit}", f"{mean:.5g} ± {error:.2g}"),
    ]  # fmt: skip
    data = {
        "noise": vars(noise), "second_eigenvalue": found.second_eigenvalue,
        "second_eigenvalue_error": found.eigenvalue_error,
        "mean_first_passage": found.mean_first_passage, "mean_strides": found.mean_strides,
        "simulated_mean_strides": mean, "simulated_standard_error": error,
        "survival_on_grid": found.survival.tolist(),
    }  # fmt: skip
    title = f"How long {options.preset} walks, disturbed at every step"
    return Report(
        "\n".join(aligned(rows, left=2)), data, result=found,
        draw=lambda: {"": figures().passage_figure(found, title=title)},
    )  # fmt: skip


def _viability(options: argparse.Namespace) -> Report:
    check_count("--nodes", options.nodes, 4, NODES)
    check_count("--controls", options.controls, 2, 99)
    check_count("--strides", options.strides, most=MOST_STRIDES)
    gait = gait_of(options)
    scheme = scheme_of(gait.control)
    half = options.half_range or [
        ANGLE_REACH if column == ANGLE else STRENGTH_REACH * abs(getattr(gait.control, name))
        for name, column in zip(scheme.numbers, scheme.columns, strict=True)
    ]
    with Progress("viability") as progress:
        found = capture(
            gait, half, strides=options.strides, counts=options.controls, shape=options.nodes,
            push=options.push, progress=progress,
        )  # fmt: skip
    saved, possible = found.bounds
    rows = [
        ("section", str(found.grid.section)),
        (f"saved for {found.strides} strides", f"{100 * saved:.2f} %"),
        ("lost", f"{100 * (1 - possible):.2f} %"),
        ("left open by the grid", f"{100 * (possible - saved):.2f} %"),
        ("viable pairs of state and control", f"{100 * found.viability_measure:.2f} %"),
    ]
    data = {
        "half_range": list(half), "saved": saved, "possible": possible,
        "viability_measure": found.viability_measure,
    }  # fmt: skip
    title = f"What any control saves of {options.preset}"
    return Report(
        "\n".join(aligned(rows, left=2)), data, result=found,
        draw=lambda: {"": figures().viability_figure(found, title=title)},
    )  # fmt: skip
