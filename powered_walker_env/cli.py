"""The command line: `powered-walker walk`, `gait`, `presets`.

Each command is a function from parsed arguments to a result that can be printed as text
or, with --json, as one JSON object.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable, Sequence
from importlib.metadata import version
from typing import Any, NamedTuple

import numpy as np

from powered_walker_env.params import Control, PostStrikeState, WalkerParams
from powered_walker_env.phases import Outcome
from powered_walker_env.poincare import Gait, GaitNotFoundError, find_gait
from powered_walker_env.presets import PRESETS
from powered_walker_env.trajectory import Trajectory, walk


class Report(NamedTuple):
    """What a command found: for people and for programs."""

    text: str
    data: dict[str, Any]


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command; returns the exit status (2 for a bad argument, 1 for no result)."""
    parser = _parser()
    options = parser.parse_args(arguments)
    command: Callable[[argparse.Namespace], Report] = options.command
    try:
        report = command(options)
    except GaitNotFoundError as error:
        print(f"powered-walker: {error}", file=sys.stderr)
        return 1
    except (ValueError, TypeError, ImportError, OSError) as error:
        print(f"powered-walker: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("powered-walker: interrupted", file=sys.stderr)
        return 130
    print(json.dumps(report.data, indent=2) if options.json else report.text)
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="powered-walker",
        description="A nearly passive powered walker: strides, walks and gaits.",
    )
    parser.add_argument(
        "--version", action="version", version=f"%(prog)s {version('powered-walker-env')}"
    )
    commands = parser.add_subparsers(required=True, metavar="command")
    walking = _add(commands, "walk", _walk, "walk from the gait's state, stride by stride")
    _add_walker(walking)
    walking.add_argument("--strides", type=int, default=10, help="at most (default %(default)s)")
    walking.add_argument(
        "--push",
        type=float,
        nargs=2,
        default=(0.0, 0.0),
        metavar=("STANCE", "SWING"),
        help="rad/s added to both leg rates at the start",
    )
    walking.add_argument("--animation", metavar="FILE", help="write a .gif or .mp4 of the walk")
    gait = _add(commands, "gait", _gait, "find the limit cycle and its multipliers")
    _add_walker(gait)
    gait.add_argument("--period", type=int, default=1, help="strides (default %(default)s)")
    _add(commands, "presets", _presets, "list the walkers that come with the package")
    return parser


def _add(
    commands: Any, name: str, command: Callable[[argparse.Namespace], Report], text: str
) -> argparse.ArgumentParser:
    parser: argparse.ArgumentParser = commands.add_parser(name, help=text, description=text)
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.set_defaults(command=command)
    return parser


def _add_walker(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--preset", default="camp1997", choices=PRESETS, help="(default %(default)s)"
    )
    parser.add_argument("--switch-angle", type=float, help="rad; the preset's if left out")
    parser.add_argument("--stall-torque", type=float, help="N m; the preset's if left out")


def _walker(options: argparse.Namespace) -> tuple[WalkerParams, Control, PostStrikeState]:
    params, control, state, _ = PRESETS[options.preset]
    if control is None:
        raise ValueError(f"--preset must be a powered walker, got {options.preset!r}")
    angle, torque = options.switch_angle, options.stall_torque
    chosen = Control(
        control.switch_angle if angle is None else angle,
        control.stall_torque if torque is None else torque,
    )
    return params, chosen, state


def _walk(options: argparse.Namespace) -> Report:
    params, control, state = _walker(options)
    stance, swing = options.push
    start = state._replace(
        stance_rate=state.stance_rate + stance, swing_rate=state.swing_rate + swing
    )
    walked = walk(start, control, params, options.strides)
    if options.animation:
        from powered_walker_env.animation import save_animation

        save_animation(walked, options.animation)
    return Report(_walk_text(walked), _walk_data(walked))


def _walk_data(walked: Trajectory) -> dict[str, Any]:
    ends = [event.t for event in walked.events if event.phase == walked.events[-1].phase]
    return {
        "outcome": walked.outcome.label,
        "strides": int(walked.outcome == Outcome.WALKED) + int(walked.stride[-1]),
        "heel_strikes_s": ends,
        "states": [row.tolist() for row in walked.states if np.isfinite(row).all()],
        "landings_m": walked.landings.tolist(),
    }


def _walk_text(walked: Trajectory) -> str:
    lines = ["stride  stance angle  swing angle  stance rate  swing rate  step length"]
    lengths = np.diff(walked.landings)
    for k, row in enumerate(walked.states[1:]):
        if np.isfinite(row).all():
            alpha, s, dalpha, dbeta = row
            lines.append(
                f"{k + 1:6d}  {alpha:8.4f} rad  {s:7.4f} rad  {dalpha:7.4f} /s  {dbeta:6.4f} /s"
                f"  {lengths[k]:9.4f} m"
            )
    lines.append(f"{walked.outcome.label}: {walked.outcome.description}")
    return "\n".join(lines)


def _gait(options: argparse.Namespace) -> Report:
    params, control, state = _walker(options)
    try:
        gait = find_gait(params, control, state, period=options.period)
    except GaitNotFoundError:
        gait = find_gait(params, control, period=options.period)
    return Report(_gait_text(gait), _gait_data(gait))


def _gait_data(gait: Gait) -> dict[str, Any]:
    return {
        "params": gait.params.to_dict(),
        "control": [gait.control.switch_angle, gait.control.stall_torque]
        if isinstance(gait.control, Control)
        else None,
        "period": gait.period,
        "state": list(gait.state),
        "section_state": gait.section_state,
        "multipliers": [[value.real, value.imag] for value in gait.multipliers.tolist()],
        "spectral_radius": gait.spectral_radius,
        "stable": gait.stable,
        "duration_s": gait.duration,
        "step_length_m": gait.step_length,
        "speed_m_s": gait.speed,
        "cost_of_transport": gait.cost_of_transport,
    }


def _gait_text(gait: Gait) -> str:
    multipliers = ", ".join(f"{value:.4f}" for value in gait.multipliers)
    return "\n".join(
        [
            f"post-strike state (α, s, α', β')  {', '.join(f'{x:.6f}' for x in gait.state)}",
            f"Floquet multipliers               {multipliers}",
            f"spectral radius                   {gait.spectral_radius:.4f} "
            f"({'stable' if gait.stable else 'unstable'})",
            f"duration                          {gait.duration:.4f} s",
            f"step length                       {gait.step_length:.4f} m",
            f"speed                             {gait.speed:.4f} m/s",
            f"cost of transport                 {gait.cost_of_transport:.4f}",
        ]
    )


def _presets(options: argparse.Namespace) -> Report:
    text = "\n".join(f"{name:24s} {preset.source}" for name, preset in PRESETS.items())
    data = {
        name: {
            "params": preset.params.to_dict(),
            "control": preset.control
            and [preset.control.switch_angle, preset.control.stall_torque],
            "state": list(preset.state),
            "source": preset.source,
        }
        for name, preset in PRESETS.items()
    }
    return Report(text, data)
