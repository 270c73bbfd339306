"""`powered-walker walk`, `gait`, `presets`: one walker walking."""

from __future__ import annotations

import argparse
import dataclasses
from typing import Any

import numpy as np

from powered_walker_env.cli.options import (
    add_command,
    add_walker,
    control_data,
    control_text,
    gait_of,
    powered_by,
    walker_of,
)
from powered_walker_env.cli.output import Report, add_out, check_out, figures, put_out
from powered_walker_env.model.phases import Outcome
from powered_walker_env.model.powering import scheme_of
from powered_walker_env.model.presets import PRESETS
from powered_walker_env.poincare import Gait
from powered_walker_env.poincare.energy.contact import ContactReport, contact_of
from powered_walker_env.simulation.trajectory import Trajectory, walk


def add_commands(commands: Any) -> None:
    """Add this family's commands."""
    walking = add_command(commands, "walk", _walk, "walk from the gait's state, stride by stride")
    add_walker(walking)
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
    gait = add_command(
        commands, "gait", _gait, "find the limit cycle, its multipliers and its contact forces"
    )
    add_walker(gait)
    gait.add_argument("--period", type=int, default=1, help="strides (default %(default)s)")
    add_out(gait)
    add_command(commands, "presets", _presets, "list the walkers that come with the package")


def _walk(options: argparse.Namespace) -> Report:
    params, control, state = walker_of(options)
    stance, swing = options.push
    start = state._replace(
        stance_rate=state.stance_rate + stance, swing_rate=state.swing_rate + swing
    )
    walked = walk(start, control, params, options.strides)
    if options.animation:
        from powered_walker_env.pictures.film import save_animation

        save_animation(walked, options.animation)
    text = f"scheme: {control_text(control)}\n{_walk_text(walked)}"
    return Report(text, control_data(control) | _walk_data(walked))


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
    check_out(options)
    powered = powered_by(options)
    if options.out and not options.no_plot and not powered.moves_ankle:
        raise ValueError(
            f"--scheme must be one with a motor for the picture of a gait, got {powered.name!r} "
            f"(--preset {options.preset}); add --no-plot to save the numbers"
        )
    gait = gait_of(options, options.period)
    contact = contact_of(gait)
    report = Report(_gait_text(gait, contact), gait_data(gait) | {"contact": _contact(contact)})
    title = f"Gait of {options.preset}: largest multiplier {gait.spectral_radius:.4f}"
    return put_out(options, report, gait, lambda: figures().gait_figure(gait, title=title))


def gait_data(gait: Gait) -> dict[str, Any]:
    """A gait for programs."""
    return {
        "params": gait.params.to_dict(),
        **control_data(gait.control),
        "period": gait.period,
        "state": list(gait.state),
        "section_state": gait.section_state,
        "multipliers": [[value.real, value.imag] for value in gait.multipliers.tolist()],
        "spectral_radius": gait.spectral_radius,
        "stable": gait.stable,
        "duration_s": gait.duration,
        "step_length_m": gait.step_length,
        "speed_m_s": gait.speed,
        "positive_work_J": gait.positive_work,
        "electrical_energy_J": gait.electrical_energy if moves_ankle(gait) else None,
        "cost_of_transport": gait.cost_of_transport,
    }


def moves_ankle(gait: Gait) -> bool:
    """Whether an ankle motor powers the gait."""
    return scheme_of(gait.control).moves_ankle


def _contact(contact: ContactReport) -> dict[str, Any]:
    numbers = dataclasses.asdict(contact) | {"outcome": contact.outcome.label}
    return numbers | {"violations": list(contact.violations())}


def _gait_text(gait: Gait, contact: ContactReport) -> str:
    multipliers = ", ".join(f"{value:.4f}" for value in gait.multipliers)
    electrical = f", {gait.electrical_energy:.4g} J of electricity" if moves_ankle(gait) else ""
    broken = contact.violations() or ("nothing that the model assumes is broken",)
    return "\n".join(
        [
            f"scheme                            {control_text(gait.control)}",
            f"post-strike state (α, s, α', β')  {', '.join(f'{x:.6f}' for x in gait.state)}",
            f"Floquet multipliers               {multipliers}",
            f"spectral radius                   {gait.spectral_radius:.4f} "
            f"({'stable' if gait.stable else 'unstable'})",
            f"duration                          {gait.duration:.4f} s",
            f"step length                       {gait.step_length:.4f} m",
            f"speed                             {gait.speed:.4f} m/s",
            f"positive work                     {gait.positive_work:.4g} J{electrical}",
            f"cost of transport                 {gait.cost_of_transport:.4f}",
            f"least normal force                {contact.min_normal_fraction:.4f} of the weight",
            f"friction needed                   {contact.friction:.4f} in swing, "
            f"{contact.strike_friction:.4f} at heel strike",
            f"swing foot after mid-swing        {contact.min_clearance:.4f} to "
            f"{contact.max_clearance:.4f} m above the floor",
            *(f"beyond the model: {text}" for text in broken),
        ]
    )


def _presets(options: argparse.Namespace) -> Report:
    text = "\n".join(
        f"{name:24s} {scheme_of(preset.control).name:16s} {preset.source}"
        for name, preset in PRESETS.items()
    )
    data = {
        name: {
            "params": preset.params.to_dict(),
            **control_data(preset.control),
            "state": list(preset.state),
            "source": preset.source,
        }
        for name, preset in PRESETS.items()
    }
    return Report(text, data)
