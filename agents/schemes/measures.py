"""What a scheme's gait is like: cost, flows of energy, stability, what it survives, its timing."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

from agents.schemes.cases import Found
from agents.schemes.timing import clocked, timing
from powered_walker_env import PRESETS, Gait
from powered_walker_env.model.powering import scheme_of
from powered_walker_env.poincare import (
    Section,
    basin_volume,
    contact_of,
    costs,
    gait_sensitivity,
    largest_push,
    largest_step,
)
from powered_walker_env.poincare.sections import swings_freely

RATES = ("stance_rate", "swing_rate")
SAMPLES = 1000  # starts of a basin
BASIN_SEED = 0


def measured(legs: str, found: Found, samples: int = SAMPLES) -> dict[str, Any]:
    """All that is measured of one scheme on one pair of legs; of no gait, why there is none."""
    if found.gait is None:
        return {"scheme": found.scheme, "reason": found.reason}
    gait = found.gait
    return {
        "scheme": found.scheme,
        "control": numbers(gait),
        "slope": gait.params.slope,
        **energies(gait),
        "spectral_radius": gait.spectral_radius,
        "multipliers": pairs(gait.multipliers),
        "robustness": robustness(legs, gait, samples) if gait.stable else None,
        "timing": timing(gait),
        "clock": None if (loop := clocked(gait)) is None else pairs(loop),
        "contact": list(contact_of(gait).violations()),
    }


def numbers(gait: Gait) -> dict[str, float]:
    """Of the control, by name."""
    return {} if gait.control is None else dataclasses.asdict(gait.control)  # type: ignore[arg-type]


def pairs(multipliers: Any) -> list[list[float]]:
    """Complex numbers as JSON has them."""
    return [[float(value.real), float(value.imag)] for value in multipliers]


def energies(gait: Gait) -> dict[str, Any]:
    """Costs of transport: energies over weight times distance."""
    spent = costs(gait)
    return {
        "speed": spent.speed,
        "step_length": spent.step_length,
        "work": spent.work,
        "gravity": spent.gravity,
        "mechanical": spent.mechanical,
        "braked": max(spent.work + spent.gravity - spent.net, 0.0),
        "lost": spent.lost,
        "electrical": _known(spent.electrical),
        "ideal": _known(spent.ideal),
        "least": _known(spent.least),
    }


def _known(value: float) -> float | None:
    return None if math.isnan(value) else value


def robustness(legs: str, gait: Gait, samples: int) -> dict[str, Any]:
    """Of a stable gait: sensitivity norms, the largest single push and step, its basin.

    The box of the basin is 0.1 (0.1 √(g/L) of a rate) around the gait, on the hip angle at
    which the legs' own motor starts, for all schemes that swing freely until then; on both
    feet on the floor where there is no motor.
    """
    push, effects = dict.fromkeys(RATES, 1.0), dict.fromkeys(RATES, 1.0)
    start = gait.state
    pushed = largest_push(gait.params, gait.control, start)
    stepped = largest_step(gait.params, gait.control, start)
    section = _section(legs, gait)
    share: dict[str, Any] | None = None
    if section is not None:
        volume = basin_volume(
            gait.params, gait.control, samples=samples, seed=BASIN_SEED, gaits=[gait],
            section=section, backend="threading", jobs=1,
        )  # fmt: skip
        share = {"section": str(section), "share": volume.share, "low": volume.share_low,
                 "high": volume.share_high}  # fmt: skip
    return {
        "sensitivity_to_pushes": gait_sensitivity(gait, push, effects).norm,
        "sensitivity_to_steps": gait_sensitivity(gait).norm,
        "push": [pushed.down, pushed.up],
        "step": [stepped.down, stepped.up],
        "basin": share,
    }


def _section(legs: str, gait: Gait) -> Section | None:
    """Where starts are drawn; None where there is no section that the schemes share."""
    control = PRESETS[legs].control
    if control is None or not scheme_of(control).moves_ankle:
        return Section(gait.params)
    if gait.params.knee is not None or not swings_freely(gait.control):
        return None
    return Section(gait.params, control.switch_angle)  # type: ignore[attr-defined]
