"""Arguments that commands share: which walker, which range."""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable, Sequence
from typing import Any

from powered_walker_env.cli.output import Report
from powered_walker_env.model.knee import Knee
from powered_walker_env.model.powering import (
    CONTROL_NUMBERS,
    SCHEMES,
    AnyControl,
    Scheme,
    scheme_named,
    scheme_of,
)
from powered_walker_env.model.presets import PRESETS
from powered_walker_env.model.quantities import ANY, Domain, quantities
from powered_walker_env.model.state import PostStrikeState
from powered_walker_env.model.walker import WalkerParams
from powered_walker_env.poincare import PARAMETERS, Gait, GaitNotFoundError, find_gait
from powered_walker_env.poincare.families import check_parameter

AROUND = 0.05  # of a parameter's value: the range looked at if none is given
AROUND_ZERO = 0.02  # the same for a parameter that is zero, as the slope
MOST = 10_000_000  # starts or values of one command: about a gigabyte
MOST_STRIDES = 10_000  # of a walk, whose samples are all kept


def add_command(
    commands: Any, name: str, command: Callable[[argparse.Namespace], Report], text: str
) -> argparse.ArgumentParser:
    """A command with --json."""
    parser: argparse.ArgumentParser = commands.add_parser(name, help=text, description=text)
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.set_defaults(command=command, out=None)
    return parser


def add_preset(parser: argparse.ArgumentParser, default: str = "camp1997") -> None:
    """The argument that chooses a walker."""
    parser.add_argument(
        "--preset", default=default, choices=PRESETS, metavar="NAME",
        help=f"one of {', '.join(PRESETS)} (default %(default)s)",
    )  # fmt: skip


def add_walker(parser: argparse.ArgumentParser) -> None:
    """Arguments that choose the walker and its control."""
    add_preset(parser)
    parser.add_argument(
        "--scheme", choices=SCHEMES, metavar="NAME",
        help=f"what powers the walker, one of {', '.join(SCHEMES)}; as the preset if left out",
    )  # fmt: skip
    for name in CONTROL_NUMBERS:
        parser.add_argument(
            _flag(name), type=float, help=f"{_meaning(name)}; the preset's if left out"
        )
    numbers = quantities(WalkerParams) | quantities(Knee)
    known = "; ".join(f"{q.name}: {q.axis}" for q in numbers.values())
    parser.add_argument(
        "--set", action="append", default=[], metavar="NAME=VALUE",
        help="change a number of the control or the walker, as slope=0.01, or physics; may be "
        f"given more than once ({known})",
    )  # fmt: skip


def _meaning(number: str) -> str:
    """What a number of a control is, in each scheme that has it."""
    found = [
        quantities(each.control)[number] for each in SCHEMES.values() if number in each.numbers
    ]
    return f"{', or '.join(dict.fromkeys(q.label for q in found))}, {found[0].unit}"


def add_range(parser: argparse.ArgumentParser, around: float = AROUND) -> None:
    """Arguments that choose a parameter and its bounds."""
    parser.add_argument(
        "--parameter", choices=PARAMETERS, metavar="NAME",
        help=f"one of {', '.join(PARAMETERS)} (default: stall_torque, "
        "or what else powers the walker; of a passive one, slope)",
    )  # fmt: skip
    parser.add_argument(
        "--bounds", type=float, nargs=2, metavar=("LOW", "HIGH"),
        help=f"of the parameter; {around:.0%}% to either side of the walker's value if left out "
        f"({AROUND_ZERO:g} if that is zero)",
    )  # fmt: skip
    parser.set_defaults(around=around)


def check_count(name: str, value: int, least: int = 1, most: int = MOST) -> None:
    """Refuse a number of things that is too small to mean anything, or too large to hold.

    Raises:
        ValueError: naming the argument.
    """
    if not least <= value <= most:
        raise ValueError(f"{name} must be at least {least} and at most {most}, got {value!r}")


def walker_of(
    options: argparse.Namespace,
) -> tuple[WalkerParams, AnyControl | None, PostStrikeState]:
    """The walker and control asked for (None: passive), and the preset's state.

    Raises:
        ValueError, TypeError: a name that is no parameter, a value out of its domain, a
            number that the walker's scheme has not, or one that is missing.
    """
    params, _, state, _ = PRESETS[options.preset]
    changes = dict(_assignment(text) for text in options.set)
    for name in CONTROL_NUMBERS:
        if getattr(options, name) is not None:
            changes[name] = getattr(options, name)
    chosen = {name: changes.pop(name) for name in CONTROL_NUMBERS if name in changes}
    return params.replace(**changes), _control(options, chosen), state


def _control(options: argparse.Namespace, chosen: dict[str, float]) -> AnyControl | None:
    """The control of the scheme asked for: its numbers chosen, else those of the preset."""
    powered, own = powered_by(options), PRESETS[options.preset].control
    for name in chosen:
        if name not in powered.numbers:
            passive = f"--preset {options.preset} is a passive walker and"
            whose = f"--scheme {powered.name}" if powered.control or options.scheme else passive
            raise ValueError(
                f"{whose} has no {name}; choose another preset or --scheme, or leave it out"
            )
    numbers = []
    for name in powered.numbers:
        value = chosen.get(name, getattr(own, name, None))
        if value is None:
            raise ValueError(
                f"{_flag(name)} must be given for --scheme {powered.name}: --preset "
                f"{options.preset} has none"
            )
        numbers.append(value)
    return None if powered.control is None else powered.control(*numbers)


def _flag(name: str) -> str:
    return f"--{name.replace('_', '-')}"


def powered_by(options: argparse.Namespace) -> Scheme:
    """The scheme asked for, else the preset's."""
    return (
        scheme_named(options.scheme)
        if options.scheme
        else scheme_of(PRESETS[options.preset].control)
    )


def control_text(control: Any) -> str:
    """A scheme and the numbers of its control, as people read them."""
    numbers = [] if control is None else quantities(control).values()
    told = [
        f"{q.name.replace('_', ' ')} {getattr(control, q.name):g} {q.unit}".strip() for q in numbers
    ]
    return ", ".join([scheme_of(control).name, *told])


def control_data(control: Any) -> dict[str, Any]:
    """The same for programs."""
    powered = scheme_of(control)
    numbers = [getattr(control, name) for name in powered.numbers]
    return {"scheme": powered.name, "control": numbers or None}


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


def parameter_of(options: argparse.Namespace) -> str:
    """The parameter asked for, else what drives the walker: its control, or the slope.

    Raises:
        ValueError: one that this walker has not.
    """
    name: str = options.parameter or ("slope", *powered_by(options).numbers)[-1]
    check_parameter(name, walker_of(options)[1])
    return name


def _domains() -> dict[str, Domain]:
    """Of the numbers of walkers and controls."""
    owners = (WalkerParams, Knee, *(each.control for each in SCHEMES.values() if each.control))
    return {name: q.domain for owner in owners for name, q in quantities(owner).items()}


def range_around(
    bounds: Sequence[float] | None, value: float, around: float = AROUND, name: str = ""
) -> tuple[float, float]:
    """The bounds asked for, or some to either side of a value, in the domain of the name.

    Raises:
        ValueError: bounds that do not rise, or are not finite.
    """
    if bounds is None:
        reach = around * abs(value) if value else AROUND_ZERO
        domain = _domains().get(name, ANY)
        low, high = max(value - reach, domain.low), min(value + reach, domain.high)
        return (
            low if domain.holds(low) else 0.5 * (low + value),
            high if domain.holds(high) else 0.5 * (high + value),
        )
    low, high = bounds
    if not -math.inf < low < high < math.inf:
        raise ValueError(f"--bounds must rise and be finite, got {low!r} {high!r}")
    return low, high
