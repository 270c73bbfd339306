"""`powered-walker sensitivity`, `lyapunov`, `volume`, `largest`: how robust a gait is."""

from __future__ import annotations

import argparse
from typing import Any

import numpy as np

from powered_walker_env.cli.long import add_running
from powered_walker_env.cli.options import (
    MOST_STRIDES,
    add_command,
    add_walker,
    check_count,
    gait_of,
)
from powered_walker_env.cli.output import Progress, Report, add_out, unfinished
from powered_walker_env.model.state import natural_units
from powered_walker_env.poincare import (
    basin_volume,
    gait_sensitivity,
    largest_push,
    largest_step,
    lyapunov_exponent,
)
from powered_walker_env.poincare.stability.robustness import INDICATORS
from powered_walker_env.poincare.stability.robustness import STEP_HEIGHT as HEIGHT
from powered_walker_env.tabular import aligned


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
