"""Arguments that commands share: which walker, which range, where to run."""

from __future__ import annotations

import argparse
import dataclasses
from collections.abc import Callable
from typing import Any

from powered_walker_env.cli.output import Report
from powered_walker_env.params import Control, PostStrikeState, WalkerParams
from powered_walker_env.poincare import PARAMETERS, Gait, GaitNotFoundError, find_gait
from powered_walker_env.poincare.families import check_parameter
from powered_walker_env.presets import PRESETS

AROUND = 0.05  # of a parameter's value: the range looked at if none is given
AROUND_ZERO = 0.02  # the same for a parameter that is zero, as the slope


def add_command(
    commands: Any, name: str, command: Callable[[argparse.Namespace], Report], text: str
) -> argparse.ArgumentParser:
    """A command with --json."""
    parser: argparse.ArgumentParser = commands.add_parser(name, help=text, description=text)
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.set_defaults(command=command, out=None)
    return parser


def add_walker(parser: argparse.ArgumentParser) -> None:
    """Arguments that choose the walker and its control."""
    parser.add_argument(
        "--preset", default="camp1997", choices=PRESETS, help="(default %(default)s)"
    )
    parser.add_argument("--switch-angle", type=float, help="rad; the preset's if left out")
    parser.add_argument("--stall-torque", type=float, help="N m; the preset's if left out")
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        help="change a parameter of the walker or its control, as slope=0.01 (SI units, "
        "radians); may be given more than once",
    )


def add_range(parser: argparse.ArgumentParser) -> None:
    """Arguments that choose a parameter and its bounds."""
    parser.add_argument(
        "--parameter", choices=PARAMETERS, metavar="NAME",
        help=f"one of {', '.join(PARAMETERS)} (default: stall_torque; of a passive walker, slope)",
    )  # fmt: skip
    parser.add_argument(
        "--bounds", type=float, nargs=2, metavar=("LOW", "HIGH"),
        help="of the parameter; 5%% to either side of the walker's value if left out",
    )  # fmt: skip


def add_running(parser: argparse.ArgumentParser) -> None:
    """Arguments that choose where pieces of work run."""
    parser.add_argument(
        "--backend", default="loky", choices=("loky", "threading", "dask", "ray"),
        help="what runs the pieces (default %(default)s: processes on this machine)",
    )  # fmt: skip
    parser.add_argument("--address", help="of a running Dask or Ray cluster")
    parser.add_argument("--jobs", type=int, help="workers; all cores if left out")


def walker_of(
    options: argparse.Namespace,
) -> tuple[WalkerParams, Control | None, PostStrikeState]:
    """The walker and control asked for (None: passive), and the preset's state.

    Raises:
        ValueError, TypeError: a name that is no parameter, a value out of its domain, a
            control for a walker that has none.
    """
    params, control, state, _ = PRESETS[options.preset]
    changes = dict(_assignment(text) for text in options.set)
    for name in ("switch_angle", "stall_torque"):
        if getattr(options, name) is not None:
            changes[name] = getattr(options, name)
    controls = [field.name for field in dataclasses.fields(Control)]
    chosen = {name: changes.pop(name) for name in controls if name in changes}
    if control is None:
        if chosen:
            raise ValueError(
                f"--preset {options.preset} is a passive walker and has no {next(iter(chosen))}; "
                "choose a powered preset, or leave it out"
            )
        return params.replace(**changes), None, state
    return params.replace(**changes), dataclasses.replace(control, **chosen), state


def _assignment(text: str) -> tuple[str, Any]:
    name, equals, value = text.partition("=")
    known = (*PARAMETERS, "physics")
    if not equals or name not in known:
        raise ValueError(
            f"--set must be NAME=VALUE with NAME one of {', '.join(known)}, got {text!r}"
        )
    if name == "physics":
        return name, value
    try:
        return name, float(value)
    except ValueError:
        raise ValueError(f"--set {name} must be a number, got {value!r}") from None


def gait_of(options: argparse.Namespace, period: int = 1) -> Gait:
    """The walker's gait: near the preset's, else wherever one is found.

    Raises:
        GaitNotFoundError: there is none.
    """
    params, control, state = walker_of(options)
    try:
        return find_gait(params, control, state, period=period)
    except GaitNotFoundError:
        return find_gait(params, control, period=period)


def passive(options: argparse.Namespace) -> bool:
    """Whether the walker asked for has no motor."""
    return PRESETS[options.preset].control is None


def parameter_of(options: argparse.Namespace) -> str:
    """The parameter asked for, else what drives the walker: its motor, or the slope.

    Raises:
        ValueError: one that this walker has not.
    """
    name: str = options.parameter or ("slope" if passive(options) else "stall_torque")
    check_parameter(name, PRESETS[options.preset].control)
    return name


def range_around(
    bounds: tuple[float, float] | list[float] | None, value: float
) -> tuple[float, float]:
    """The bounds asked for, or some to either side of a value.

    Raises:
        ValueError: bounds that do not rise.
    """
    if bounds is None:
        reach = AROUND * abs(value) if value else AROUND_ZERO
        return value - reach, value + reach
    low, high = bounds
    if not low < high:
        raise ValueError(f"--bounds must rise, got {low!r} {high!r}")
    return low, high
