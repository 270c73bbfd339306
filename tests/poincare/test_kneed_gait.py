"""Gaits with knees: found by the search, and from a slope to a motor."""

from __future__ import annotations

import math
from dataclasses import fields

import numpy as np
import pytest

from powered_walker_env import (
    PRESETS,
    Control,
    Gait,
    GaitNotFoundError,
    WalkerParams,
    find_gait,
)
from powered_walker_env.model.knee import Knee
from powered_walker_env.poincare import SpecialKind, continue_path, find_gaits
from powered_walker_env.simulation.strides import stride

KNEED = PRESETS["kneed"]
#: Rises of the switch angle that are tried as the slope falls a little, rad.
RISES = (0.0, 0.003, 0.006, 0.01, 0.015, 0.02, 0.03, 0.04, 0.06)
SLOPE, STEPS = 0.02, 20


def test_the_search_finds_the_kneed_walkers_gait() -> None:
    gaits = find_gaits(KNEED.params, KNEED.control, starts=1024)
    assert gaits[0].spectral_radius < 0.52
    assert gaits[0].state == pytest.approx(KNEED.state, abs=1e-8)


def near(params: WalkerParams, control: Control | None, gait: Gait) -> Gait | None:
    try:
        return find_gait(params, control, gait.state)
    except GaitNotFoundError:
        return None


def legs(gait: Gait) -> float:
    """The angle between them at heel strike, rad."""
    return gait.state.swing_angle - gait.state.stance_angle


@pytest.fixture(scope="module")
def powered() -> tuple[Gait, float]:
    """A passive gait on a slope become a motor's on level ground, and how long its step was.

    The motor begins where the passive leg is about to land, when it does hardly anything; as the
    slope falls it starts earlier, so that the steps stay as long.
    """
    params = WalkerParams.from_kneed_leg(
        hip_mass=23.73, thigh_mass=7.0, thigh_com_along=0.2835, thigh_inertia=0.183,
        shank_mass=4.27, shank_com_along=0.25, shank_inertia=0.131, foot_length=0.05,
        foot_radius=0.35, locked_ankle_angle=0.6, no_load_speed=20.0, gravity=9.81, slope=SLOPE,
    )  # fmt: skip
    passive = find_gaits(params, None, starts=1024)[0]
    assert passive.stable
    switch = math.pi - legs(passive) + 0.01
    gait = near(params, Control(switch, 50.0), passive)
    assert gait is not None
    long = legs(gait)
    for slope in SLOPE * (1.0 - np.arange(1, STEPS + 1) / STEPS):
        walker, tried = params.replace(slope=float(slope)), []
        for rise in RISES:
            if (found := near(walker, Control(switch + rise, 50.0), gait)) is not None:
                tried.append((abs(legs(found) - long), switch + rise, found))
        away, switch, gait = min(tried, key=lambda each: each[0])
        assert away < 0.1 * long  # and not another gait
    return gait, long


def test_a_passive_gait_becomes_a_motors_as_the_slope_goes_to_zero(
    powered: tuple[Gait, float],
) -> None:
    gait, _ = powered
    assert gait.params.slope == 0.0
    walked = stride(gait.state, gait.control, gait.params)
    assert walked.state == pytest.approx(gait.state, abs=1e-7)
    assert walked.energy_in == pytest.approx(walked.energy_lost, rel=1e-6)
    assert walked.min_clearance > -1e-9


def test_and_then_the_preset_as_its_legs_and_control_do(powered: tuple[Gait, float]) -> None:
    """The torque grows with the square of the way, or the swing leg lands on a bent knee."""
    first, last = powered[0], KNEED
    begun, ended = first.control, last.control
    bent, wanted = first.params.knee, last.params.knee
    assert isinstance(begun, Control) and isinstance(ended, Control)
    assert bent is not None and wanted is not None

    def between(a: float, b: float, share: float) -> float:
        return (1.0 - share) * a + share * b

    def mixed(a: WalkerParams | Knee, b: WalkerParams | Knee, share: float) -> dict[str, float]:
        names = [item.name for item in fields(a) if isinstance(getattr(a, item.name), float)]
        return {name: between(getattr(a, name), getattr(b, name), share) for name in names}

    def path(way: float) -> tuple[WalkerParams, Control]:
        knee = Knee(**mixed(bent, wanted, way))
        control = Control(
            between(begun.switch_angle, ended.switch_angle, way),
            between(begun.stall_torque, ended.stall_torque, way * way),
        )
        return first.params.replace(knee=knee, **mixed(first.params, last.params, way)), control

    gait = find_gait(*path(0.0), first.state)
    branch = continue_path(path, gait, (0.0, 1.0))
    assert branch.values[-1] == 1.0 and (np.diff(branch.values) > 0).all()
    assert branch.states[-1] == pytest.approx(last.state, abs=1e-8)
    assert branch.special_points[-1].kind == SpecialKind.NEIMARK_SACKER  # there it becomes stable
    assert branch.spectral_radius[0] > 2.0 and branch.spectral_radius[-1] < 0.52
