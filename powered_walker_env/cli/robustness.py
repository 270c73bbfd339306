"""`powered-walker sensitivity`, `lyapunov`, `volume`, `largest`, `passage`, `viability`."""

from __future__ import annotations

import argparse
from typing import Any

import numpy as np

from powered_walker_env.cli.options import (
    MOST_STRIDES,
    add_command,
    add_running,
    add_walker,
    check_count,
    gait_of,
)
from powered_walker_env.cli.output import Progress, Report, add_out, figures, unfinished
from powered_walker_env.model.powering import ANGLE, scheme_of
from powered_walker_env.model.state import natural_units
from powered_walker_env.poincare import (
    StepNoise,
    basin_volume,
    capture,
    first_passage,
    gait_sensitivity,
    largest_push,
    largest_step,
    lyapunov_exponent,
)
from powered_walker_env.poincare.stability.robustness import INDICATORS
from powered_walker_env.poincare.stability.robustness import STEP_HEIGHT as HEIGHT
from powered_walker_env.tabular import aligned

PUSH_SHARE = 0.5  # of the largest single push survived: the noise if none is asked for
ANGLE_REACH, STRENGTH_REACH = 0.15, 0.3  # rad, and share of the strength, that controls may go
NODES = 60  # along each axis of a passage's or a kernel's grid, at most


def add_commands(commands: Any) -> None:
    """Add this family's commands."""
    parser = add_command(
        commands, "sensitivity", _sensitivity,
        "the gait sensitivity norm: how far a step up or down is felt in the strides after",
    )  # fmt: skip
    add_walker(parser)
    add_out(parser, drawings=())
    parser = add_command(
        commands, "lyapunov", _lyapunov, "the largest Lyapunov exponent along the walk"
    )
    add_walker(parser)
    parser.add_argument(
        "--strides", type=int, default=2000, help="counted (default %(default)s), 40 or more"
    )
    parser.add_argument(
        "--transient", type=int, default=200, help="before them (default %(default)s)"
    )
    add_out(parser, drawings=())
    parser = add_command(
        commands, "volume", _volume, "the share of a box on the section that ends on the gait"
    )
    add_walker(parser)
    parser.add_argument(
        "--samples", type=int, default=10_000, help="random starts (default %(default)s)"
    )
    parser.add_argument("--strides", type=int, default=100, help="at most (default %(default)s)")
    parser.add_argument("--seed", type=int, default=0, help="of the starts (default %(default)s)")
    for name in ("low", "high"):
        parser.add_argument(
            f"--{name}", type=float, nargs="+", metavar="VALUE",
            help="corner of the box: three numbers on the section (stance angle, stance rate, "
            "swing rate), or all four of the state; around the gait if left out",
        )  # fmt: skip
    add_running(parser)
    add_out(parser, drawings=(), resumable=True)
    parser = add_command(
        commands, "largest", _largest, "the largest single step and push that the gait survives"
    )
    add_walker(parser)
    parser.add_argument("--strides", type=int, default=50, help="after it (default %(default)s)")
    add_out(parser, saved=(".npz",), drawings=())
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


def _sensitivity(options: argparse.Namespace) -> Report:
    gait = gait_of(options)
    params = gait.params
    rate = float(natural_units(params)[2])
    causes = {HEIGHT: params.leg_length, "stance_rate": rate, "swing_rate": rate}
    units = (1.0 / rate, params.leg_length, params.leg_length * rate, 1.0, 1.0, rate, rate)
    found = gait_sensitivity(gait, causes, dict(zip(INDICATORS, units, strict=True)))
    rows = [("", *(name.replace("_", " ") for name in causes))]
    for name, parts in zip(found.indicators, found.parts.tolist(), strict=True):
        rows.append((name.replace("_", " "), *(f"{part:.5g}" for part in parts)))
    text = "gait sensitivity norms, in units of leg length and gravity:\n" + "\n".join(
        aligned(rows)
    )
    data = {
        "disturbances": dict(found.disturbances),
        "indicators": dict(found.indicators),
        "parts": found.parts.tolist(),
    }
    return Report(text, data, result=found)


def _lyapunov(options: argparse.Namespace) -> Report:
    check_count("--strides", options.strides, 40, MOST_STRIDES)
    check_count("--transient", options.transient, 0, MOST_STRIDES)
    gait = gait_of(options)
    state = np.array(gait.state)
    state[2:] += 1e-4 * natural_units(gait.params)[2:]  # off an unstable gait, onto what attracts
    found = lyapunov_exponent(
        gait.params, gait.control, state.tolist(), strides=options.strides,
        transient=options.transient,
    )  # fmt: skip
    verdict = "chaotic" if found.chaotic else "not chaotic"
    text = (
        f"largest exponent {found.exponent:.5f} ± {found.standard_error:.2g} per stride: {verdict}"
        if np.isfinite(found.exponent)
        else f"the walk ends: {found.outcome.label}"
    )
    data = {
        "exponent": found.exponent, "standard_error": found.standard_error,
        "chaotic": found.chaotic, "outcome": found.outcome.label,
    }  # fmt: skip
    return Report(text, data, result=found)


def _volume(options: argparse.Namespace) -> Report:
    check_count("--samples", options.samples)
    check_count("--strides", options.strides, most=MOST_STRIDES)
    gait = gait_of(options)
    with Progress("volume") as progress:
        found = basin_volume(
            gait.params, gait.control, options.low, options.high, samples=options.samples,
            seed=options.seed, strides=options.strides, gaits=[gait] if gait.stable else [],
            backend=options.backend, address=options.address, jobs=options.jobs,
            progress=progress, checkpoint=unfinished(options),
        )  # fmt: skip
    where = "all four numbers of the state" if found.section is None else str(found.section)
    rows = [
        ("section", where),
        ("share that ends on the gait", f"{found.share:.5g}"),
        (f"{found.confidence:.0%} interval", f"{found.share_low:.5g} to {found.share_high:.5g}"),
    ]
    for name, low, high in zip(found.coordinates, found.low, found.high, strict=True):
        rows.append((name.replace("_", " "), f"{low:.5g} to {high:.5g}"))
    data = {
        "share": found.share, "interval": [found.share_low, found.share_high],
        "coordinates": list(found.coordinates), "low": found.low.tolist(),
        "high": found.high.tolist(), "volume": found.volume[0],
    }  # fmt: skip
    return Report("\n".join(aligned(rows, left=2)), data, result=found)


def _largest(options: argparse.Namespace) -> Report:
    check_count("--strides", options.strides, most=MOST_STRIDES)
    gait = gait_of(options)
    step = largest_step(gait.params, gait.control, gait.state, strides=options.strides)
    push = largest_push(gait.params, gait.control, gait.state, strides=options.strides)
    rows = [
        ("step", f"{step.up:+.6g} m", f"{step.down:+.6g} m"),
        ("push on the stance leg", f"{push.up:+.6g} rad/s", f"{push.down:+.6g} rad/s"),
    ]
    data = {"step_m": [step.up, step.down], "push_rad_s": [push.up, push.down]}
    return Report("\n".join(aligned(rows)), data, result=(step, push))


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
