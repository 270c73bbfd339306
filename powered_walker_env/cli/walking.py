"""`powered-walker walk`, `gait`, `presets`: one walker walking."""

from __future__ import annotations

import argparse
import dataclasses
import math
import textwrap
from pathlib import Path
from typing import Any

import numpy as np

from powered_walker_env.cli.options import (
    MOST_STRIDES,
    add_command,
    add_walker,
    check_count,
    control_data,
    control_text,
    gait_of,
    walker_of,
)
from powered_walker_env.cli.output import Report, add_out, figures
from powered_walker_env.files import check_writable
from powered_walker_env.model.phases import Outcome
from powered_walker_env.model.powering import scheme_of
from powered_walker_env.model.presets import PRESETS
from powered_walker_env.poincare import Gait, GaitNotFoundError, contact_of, costs, find_gait
from powered_walker_env.poincare.energy.assumptions import ContactReport
from powered_walker_env.simulation.trajectory import Trajectory, walk
from powered_walker_env.tabular import aligned

SAMPLES = 0.01  # of sqrt(L/g): time between them
PORTRAIT, STICKS = "-portrait", "-sticks"


def add_commands(commands: Any) -> None:
    """Add this family's commands."""
    walking = add_command(commands, "walk", _walk, "walk from the gait's state, stride by stride")
    add_walker(walking)
    walking.add_argument("--strides", type=int, default=10, help="at most (default %(default)s)")
    walking.add_argument(
        "--push", type=float, nargs=2, default=(0.0, 0.0), metavar=("STANCE", "SWING"),
        help="rad/s added to both leg rates at the start",
    )  # fmt: skip
    walking.add_argument("--animation", metavar="FILE", help="write a .gif or .mp4 of the walk")
    add_out(walking)
    gait = add_command(
        commands, "gait", _gait, "find the limit cycle, its multipliers and its contact forces"
    )
    add_walker(gait)
    gait.add_argument("--period", type=int, default=1, help="strides (default %(default)s)")
    add_out(gait, drawings=("", PORTRAIT, STICKS))
    add_command(commands, "presets", _presets, "list the walkers that come with the package")


def _walk(options: argparse.Namespace) -> Report:
    check_count("strides", options.strides, most=MOST_STRIDES)
    if options.animation:
        from powered_walker_env.pictures.film import check_film, save_animation

        check_film(options.animation)
        check_writable([Path(options.animation)], options.overwrite, "--animation")
    params, control, state = walker_of(options)
    stance, swing = options.push
    start = state._replace(
        stance_rate=state.stance_rate + stance, swing_rate=state.swing_rate + swing
    )
    interval = SAMPLES * math.sqrt(params.leg_length / params.gravity)
    walked = walk(start, control, params, options.strides, sample_interval=interval)
    if options.animation:
        save_animation(walked, options.animation)
    text = f"scheme: {control_text(control)}\n{_walk_text(walked)}"
    data = control_data(control) | _walk_data(walked)
    return Report(text, data, result=walked, draw=lambda: {"": _walk_drawing(options, walked)})


def _walk_drawing(options: argparse.Namespace, walked: Trajectory) -> Any:
    """The walk's portrait, with the gait's where there is one."""
    shown = {"walk": walked}
    try:
        gait = gait_of(options)
        shown["gait"] = figures().cycle(gait, gait.period + 1)
    except (GaitNotFoundError, ValueError):
        pass  # there is none, or it does not close: the walk is worth seeing alone
    stance, swing = options.push
    pushed = f", pushed by {stance:g} and {swing:g} rad/s" if stance or swing else ""
    title = f"Walk of {options.preset}{pushed}: {walked.outcome.label}"
    return figures().portrait_figure(shown, title=title)


def _strikes(walked: Trajectory) -> list[float]:
    """Times of the heel strikes, s; a fall is none."""
    begins = np.searchsorted(walked.stride, np.arange(1, walked.stride[-1] + 1))
    last = walked.t[-1:] if walked.outcome == Outcome.WALKED else walked.t[:0]
    times: list[float] = np.concatenate([walked.t[begins], last]).tolist()
    return times


def _walk_data(walked: Trajectory) -> dict[str, Any]:
    strikes = _strikes(walked)
    return {
        "outcome": walked.outcome.label,
        "strides": len(strikes),
        "heel_strikes_s": strikes,
        "states": [row.tolist() for row in walked.states if np.isfinite(row).all()],
        "landings_m": walked.landings.tolist(),
    }


def _walk_text(walked: Trajectory) -> str:
    rows: list[tuple[str, ...]] = [
        ("stride", "stance angle", "swing angle", "stance rate", "swing rate", "step length"),
        ("", "rad", "rad", "rad/s", "rad/s", "m"),
    ]
    for k, (row, length) in enumerate(
        zip(walked.states[1:], np.diff(walked.landings), strict=True), start=1
    ):
        if np.isfinite(row).all():
            rows.append((str(k), *(f"{value:.4f}" for value in (*row, length))))
    return "\n".join(
        [*aligned(rows, left=0), f"{walked.outcome.label}: {walked.outcome.description}"]
    )


def _gait(options: argparse.Namespace) -> Report:
    gait = gait_of(options, options.period)
    contact = contact_of(gait)
    title = f"Gait of {options.preset}: largest multiplier {gait.spectral_radius:.4f}"

    def draw() -> dict[str, Any]:
        charts = figures()
        portrait = charts.portrait_figure(
            {"gait": charts.cycle(gait, gait.period + 1)}, title=title
        )
        sticks = charts.stick_figure(charts.cycle(gait), title=title)
        return {"": charts.gait_figure(gait, title=title), PORTRAIT: portrait, STICKS: sticks}

    data = gait_data(gait) | {"contact": _contact(contact)}
    return Report(_gait_text(gait, contact), data, result=gait, draw=draw)


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
        "electrical_energy_J": gait.electrical_energy if _has_motor(gait) else None,
        "cost_of_transport": costs(gait).mechanical,
    }


def _has_motor(gait: Gait) -> bool:
    """Whether an ankle motor powers the gait."""
    return scheme_of(gait.control).moves_ankle


def _contact(contact: ContactReport) -> dict[str, Any]:
    numbers = dataclasses.asdict(contact) | {"outcome": contact.outcome.label}
    return numbers | {"violations": list(contact.violations())}


def _gait_text(gait: Gait, contact: ContactReport) -> str:
    electrical = f", {gait.electrical_energy:.4g} J of electricity" if _has_motor(gait) else ""
    broken = contact.violations() or ("nothing that the model assumes is broken",)
    rows = [
        ("scheme", control_text(gait.control)),
        ("post-strike state (α, s, α', β')", ", ".join(f"{x:.6f}" for x in gait.state)),
        ("Floquet multipliers", ", ".join(f"{value:.4f}" for value in gait.multipliers)),
        ("spectral radius",
         f"{gait.spectral_radius:.4f} ({'stable' if gait.stable else 'unstable'})"),
        ("duration", f"{gait.duration:.4f} s"),
        ("step length", f"{gait.step_length:.4f} m"),
        ("speed", f"{gait.speed:.4f} m/s"),
        ("positive work", f"{gait.positive_work:.4g} J{electrical}"),
        ("cost of transport", f"{costs(gait).mechanical:.4f} (positive work, gravity's included, "
         "over weight times distance)"),
        ("least normal force", f"{contact.min_normal_fraction:.4f} of the weight"),
        ("friction needed",
         f"{contact.friction:.4f} in swing, {contact.strike_friction:.4f} at heel strike"),
        ("swing foot after mid-swing", f"{contact.min_clearance:.4f} to "
         f"{contact.max_clearance:.4f} m above the floor"),
    ]  # fmt: skip
    return "\n".join([*aligned(rows, left=2), *(f"beyond the model: {text}" for text in broken)])


def _presets(options: argparse.Namespace) -> Report:
    gaits = {name: find_gait(*preset[:3]) for name, preset in PRESETS.items()}
    rows = [("walker", "powered by", "slope", "largest multiplier", "")] + [
        (name, scheme_of(gait.control).name, f"{gait.params.slope:.4g} rad",
         f"{gait.spectral_radius:.4f}", "stable" if gait.stable else "unstable")
        for name, gait in gaits.items()
    ]  # fmt: skip
    head, *lines = aligned(rows, left=2)
    sources = [
        textwrap.fill(preset.source, 96, initial_indent="    ", subsequent_indent="    ")
        for preset in PRESETS.values()
    ]
    text = "\n".join([head, *(f"{a}\n{b}" for a, b in zip(lines, sources, strict=True))])
    data = {
        name: {
            "params": preset.params.to_dict(),
            **control_data(preset.control),
            "state": list(preset.state),
            "spectral_radius": gaits[name].spectral_radius,
            "stable": gaits[name].stable,
            "source": preset.source,
        }
        for name, preset in PRESETS.items()
    }
    return Report(text, data)
