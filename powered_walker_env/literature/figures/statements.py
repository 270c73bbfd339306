"""Which published statement holds, in which physics, with numbers (Camp 1997, section 8)."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any

import numpy as np

from powered_walker_env.literature.figures.figure5 import RADIUS_5, Figure5
from powered_walker_env.literature.figures.studies import (
    RADIUS_4,
    Figure6,
    control_of,
    torque_of,
)
from powered_walker_env.model.walker import AS_PUBLISHED
from powered_walker_env.poincare.energy.assumptions import STILL
from powered_walker_env.poincare.energy.contact import contact_of
from powered_walker_env.simulation.trajectory import walk

MAJOR = 0.5  # change of the multiplier's slope, per N m, that would be a major one


@dataclass(frozen=True)
class Statement:
    """One statement, what was found, and whether they agree."""

    topic: str
    says: str  # the thesis, in other words
    found: str
    holds: bool | None  # None: nothing published to compare with
    numbers: dict[str, Any]


def statements(four_to_six: Figure6, five: Figure5) -> list[Statement]:
    """All statements about one physics."""
    six = four_to_six
    found = [_figure_4(six), *_figure_5(five), _extended(six), _onset(six), _falls_first(six)]
    return [*found, _late(six), _doubling(six), _both_kinds(six), _contact(six)]


def _figure_4(six: Figure6) -> Statement:
    radius, gait = six.gait.spectral_radius, six.gait
    printed = six.setting.physics == AS_PUBLISHED
    return Statement(
        "figure 4",
        f"a typical stable gait; largest multiplier {RADIUS_4}",
        f"at {torque_of(gait):g} N m the gait is {'stable' if gait.stable else 'unstable'}, "
        f"largest multiplier {radius:.4f}"
        + ("" if printed else " (the counterpart of the published gait in this physics)"),
        bool(gait.stable and round(radius, 2) == RADIUS_4) if printed else None,
        {
            "spectral_radius": radius,
            "multipliers": [[m.real, m.imag] for m in gait.multipliers.tolist()],
            "step_length_m": gait.step_length,
            "duration_s": gait.duration,
        },
    )


def _figure_5(five: Figure5) -> list[Statement]:
    stable, turned = five.stable, five.not_monotone
    found = []
    pairs = [("figure 5, on the branch of figure 6", five.on_branch)]
    if five.at_torque is not None:
        pairs.append(("figure 5, at another switch angle", five.at_torque))
    for topic, candidate in pairs:
        gait, reversals = candidate.gait, candidate.reversals
        solved = candidate.solved and f" (by construction: the {candidate.solved} is solved for it)"
        numbers = {
            **dataclasses.asdict(control_of(gait)),
            "spectral_radius": gait.spectral_radius,
            "solved_for_it": candidate.solved,
            "overrun_rad": candidate.overrun,
            "reversals": reversals,
            "stable_gaits_searched": len(stable),
            "of_them_not_monotone": len(turned),
        }
        words = (
            f"at {torque_of(gait):.4f} N m, switch angle {numbers['switch_angle']:.5f}, the "
            f"largest multiplier is {gait.spectral_radius:.4f}{solved}; the foot falls back "
            f"{candidate.overrun:.4f} rad and the ankle turns round {reversals} "
            f"{'time' if reversals == 1 else 'times'}; of {len(stable)} stable gaits searched, "
            f"{len(turned)} have such a foot, multipliers {turned[:, 2].min():.2f} to "
            f"{turned[:, 2].max():.2f}"
        )
        near = abs(gait.spectral_radius - RADIUS_5) < 0.005
        says = f"a stable gait whose foot does not extend monotonely; largest multiplier {RADIUS_5}"
        found.append(Statement(topic, says, words, bool(near and reversals), numbers))
    return found


def _extended(six: Figure6) -> Statement:
    lock = six.gait.params.locked_ankle_angle
    feet = []
    for gait in six.gaits:
        struck = walk(gait.state, gait.control, gait.params, 1, sample_interval=0)
        feet.append(lock - struck.q[-1, 1])
    return Statement(
        "foot at heel strike",
        "the foot always ends the stride extended",
        f"over the {len(feet)} gaits of figure 6 it is extended by {min(feet):.3f} to "
        f"{max(feet):.3f} rad at heel strike",
        bool(min(feet) > 0),
        {"least_rad": min(feet), "most_rad": max(feet)},
    )


def _onset(six: Figure6) -> Statement:
    onset = six.falling_back
    says = "the onset of the foot's rising and falling brings no major change of stability"
    if onset is None:
        return Statement("onset", says, "no onset in the window of figure 6", None, {})
    low, high = six.stable_range
    change = abs(onset.slope_above - onset.slope_below)
    away = min(onset.stall_torque - low, high - onset.stall_torque)
    return Statement(
        "onset",
        says,
        f"the foot begins to fall back below {onset.stall_torque:.4f} N m; there the largest "
        f"multiplier is {onset.radius:.4f} and changes by {onset.slope_below:+.4f} per N m below "
        f"and {onset.slope_above:+.4f} above; the gait is stable on both sides, from {low:.4f} "
        f"to {high:.4f} N m",
        bool(onset.radius < 1 and away > 0 and change < MAJOR),
        {**dataclasses.asdict(onset), "distance_to_a_stability_limit": away},
    )


def _falls_first(six: Figure6) -> Statement:
    onset = six.falling_back
    below = [g for g in six.gaits if onset is not None and torque_of(g) < onset.stall_torque - 1e-3]
    overruns = [contact_of(gait).stop_overrun for gait in below]
    return Statement(
        "which way first",
        "at this onset the foot falls back first, and extends afterwards",
        f"{sum(o > STILL for o in overruns)} of {len(below)} gaits below the onset fall back past "
        f"the stop as the motor starts, by up to {max(overruns, default=0.0):.4f} rad",
        bool(below and all(o > STILL for o in overruns)),
        {"largest_overrun_rad": max(overruns, default=0.0)},
    )


def _late(six: Figure6) -> Statement:
    onset = six.turning_late
    words = "no such onset in the window"
    if onset is not None:
        words = (
            f"above {onset.stall_torque:.3f} N m the extending foot rises and falls once on its "
            f"way; the largest multiplier is {onset.radius:.3f} there and rises by "
            f"{onset.slope_below:.3f} per N m below and {onset.slope_above:.3f} above"
        )
    numbers = {} if onset is None else dataclasses.asdict(onset)
    return Statement("second onset", "not mentioned", words, None, numbers)


def _doubling(six: Figure6) -> Statement:
    doubled, at = six.doubled, six.doubling.value
    ranges = doubled.stable_ranges()
    first = ranges[0] if ranges else (float("nan"),) * 2
    critical = six.doubling.critical_multiplier.real
    return Statement(
        "period doubling",
        "period doubling was found",
        f"at {at:.6f} N m (multiplier {critical:.6f}); the gait of two strides is stable from "
        f"{first[0]:.4f} to {first[1]:.4f} N m",
        bool(ranges),
        {"stall_torque": at, "doubled_stable_range": list(first)},
    )


def _both_kinds(six: Figure6) -> Statement:
    low, high = six.stable_range
    radii = six.radii
    limits = ", ".join(
        f"{p.kind.value} at {p.value:.6f} N m"
        for p in six.branch.special_points
        if p.limits_stability
    )
    return Statement(
        "figure 6",
        "stable and unstable gaits lie in the window, with a good deal going on",
        f"of {len(radii)} gaits from {six.stall_torques[0]:g} to {six.stall_torques[-1]:g} N m "
        f"{int(np.sum(radii < 1))} are stable; the largest multiplier runs from {radii[0]:.4f} "
        f"over {radii.min():.4f} to {radii[-1]:.4f}; stable from {low:.6f} to {high:.6f} N m; "
        f"limits of stability on the branch: {limits}",
        bool((radii < 1).any() and (radii > 1).any()),
        {"stable_range": [low, high], "radii": radii.tolist()},
    )


def _contact(six: Figure6) -> Statement:
    report = contact_of(six.gait)
    found = "; ".join(report.violations()) or "nothing that the model assumes is broken"
    return Statement(
        "contact in figure 4's gait",
        "not examined",
        f"least normal force {report.min_normal_fraction:.3f} of the weight, friction needed "
        f"{report.friction:.3f} (at heel strike {report.strike_friction:.3f}); {found}",
        None,
        dataclasses.asdict(report),
    )
