"""McGeer's passive biped (1990): straight legs on round feet, no mass at the hip.

He fixes the legs' angle at heel strike, α₀ = 0.3, and lets the slope follow. His table 1 is
of his test machine, whose inertias our sources do not give: those rows show the nominal
biped at the machine's slope, and differ.
"""

from __future__ import annotations

import functools

from scipy.optimize import brentq

from powered_walker_env.literature.values.rows import Family
from powered_walker_env.model.presets import PRESETS
from powered_walker_env.poincare import Branch, Gait, continue_gait, find_gait

HALF_ANGLE = 0.3  # α₀, rad
BOUNDS = (0.015, 0.09)  # slopes
POINT_FEET_GUESS = (-0.20, 0.20, 0.31, 0.23)  # at slope 2.5 %


@functools.cache
def _nominal() -> Gait:
    params, control, state, _ = PRESETS["mcgeer1990"]
    return find_gait(params, control, state)


@functools.cache
def _point_feet() -> Gait:
    """The same legs with R = 0: hip, sole and masses stay where they are."""
    params = PRESETS["mcgeer1990"].params
    radius = params.foot_radius
    longer = params.replace(
        foot_radius=0.0,
        leg_length=params.leg_length + radius,
        com_along=params.com_along + radius,
    )
    return find_gait(longer, None, POINT_FEET_GUESS)


@functools.cache
def _branch(round_feet: bool) -> Branch:
    return continue_gait(_nominal() if round_feet else _point_feet(), "slope", BOUNDS)


@functools.cache
def _at_half_angle(round_feet: bool) -> Gait:
    """The gait whose legs are at α₀ when they strike."""
    branch = _branch(round_feet)

    def excess(slope: float) -> float:
        return branch.at(slope)[0].state.swing_angle - HALF_ANGLE

    slope = float(brentq(excess, branch.values[0], branch.values[-1], xtol=1e-12))
    return branch.at(slope)[0]


def _mode(number: int) -> float:
    """A multiplier's real part at the machine's slope, largest first."""
    return float(sorted(_nominal().multipliers[:3].real.tolist(), reverse=True)[number])


FAMILY = Family(
    "mcgeer",
    {
        "slope": lambda: _at_half_angle(True).params.slope,
        "duration": lambda: _at_half_angle(True).duration,
        "point_feet_beyond": lambda: float(_at_half_angle(False).multipliers.real.min() < -1.0),
        "speed_mode": lambda: _mode(0),
        "swing_mode": lambda: _mode(1),
        "totter_mode": lambda: _mode(2),
    },
)
