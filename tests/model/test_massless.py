"""Feet that weigh nothing: the exact limit against its equations, its gaits and light feet.

The walker of Garcia, Chatterjee, Ruina and Coleman 1998 (The simplest walking model, ASME J.
Biomech. Eng. 120(2), 281-288) in their angles θ = −α (positive leaning back) and φ = s − α.
"""

from __future__ import annotations

import dataclasses
import itertools
import math
from typing import Any

import numpy as np
import pytest

from powered_walker_env import (
    PRESETS,
    Control,
    Outcome,
    PostStrikeState,
    WalkerParams,
    continue_gait,
    find_gait,
    stride,
)
from powered_walker_env.literature.values.published import load
from powered_walker_env.model.mechanics.chain import accelerations, energy
from powered_walker_env.model.mechanics.heel_strike import heel_strike
from powered_walker_env.model.powering import PASSIVE_WALKER, scheme_of
from powered_walker_env.model.walker import AS_PUBLISHED, CONSERVING
from powered_walker_env.poincare import SpecialKind
from tests.helpers.derivation import Array
from tests.helpers.differences import INPUTS, difference, point_of, variational
from tests.helpers.samples import constants, free_chain, locked_chain, pose

SIMPLEST = WalkerParams(
    leg_length=1.0, leg_mass=0.5, leg_inertia=0.0, com_along=1.0, com_across=0.0,
    foot_length=0.0, foot_radius=0.0, locked_ankle_angle=math.pi, gravity=1.0, slope=0.009,
)  # fmt: skip
CASES = load("published.json")["simplest_walker"]["cases"]
FIELDS = [field.name for field in dataclasses.fields(WalkerParams)]
DOUBLING = load("published.json")["simplest_walker"]["first_period_doubling"]["gamma"]


def state_of(case: dict[str, Any]) -> PostStrikeState:
    """(θ, θ', φ') of a case in the package's convention."""
    theta, rate, hip_rate = case["theta"], case["thetadot"], case["phidot"]
    return PostStrikeState(-theta, theta, -rate, hip_rate - rate)


def test_the_preset_is_garcia_s_walker_and_its_long_gait() -> None:
    params, control, state, source = PRESETS["simplest"]
    assert params == SIMPLEST
    assert control is None
    assert state == pytest.approx(state_of(CASES["0.009_long"]), abs=1e-14)
    assert "Garcia" in source


def test_swing_is_garcia_s_two_equations_to_rounding() -> None:
    """θ'' = sin(θ − γ); θ'' − φ'' + θ'² sin φ − cos(θ − γ) sin φ = 0."""
    rng = np.random.default_rng(1)
    for _ in range(100):
        alpha, s, gamma = rng.uniform(-0.5, 0.5, 3)
        dalpha, ds = rng.uniform(-1, 1, 2)
        y = (alpha - math.pi, 0.0, s + math.pi, dalpha, 0.0, ds)
        theta, phi, dtheta = -alpha, s - alpha, -dalpha
        ddtheta = math.sin(theta - gamma)
        ddphi = ddtheta + dtheta**2 * math.sin(phi) - math.cos(theta - gamma) * math.sin(phi)
        params = SIMPLEST.replace(slope=gamma)
        found = accelerations(y, 0.0, 0.0, locked_chain(params), constants(params))
        assert found == pytest.approx((-ddtheta, 0.0, ddphi - ddtheta), abs=3e-15)


def test_the_hip_keeps_cos_2_theta_of_its_speed_to_rounding() -> None:
    for theta in (0.05, 0.2, 0.35):
        y = (theta - math.pi, theta, math.pi - theta, 0.4, 0.4, 0.3)
        struck = heel_strike(pose(y), free_chain(SIMPLEST), constants(SIMPLEST))
        kept = math.cos(2 * theta)
        assert struck.dalpha == pytest.approx(0.4 * kept, abs=1e-15)
        assert struck.dbeta - struck.dalpha == pytest.approx(-0.4 * kept * (1 - kept), abs=1e-15)


def test_feet_without_mass_have_no_energy() -> None:
    """The walker's energy is that of a point of mass 2M at the hip, however the leg swings."""
    rng = np.random.default_rng(2)
    mass = 2.0 * SIMPLEST.leg_mass
    for _ in range(50):
        alpha, s, dalpha, ds = rng.uniform(-1, 1, 4)
        height = math.cos(alpha + SIMPLEST.slope)
        y = (alpha - math.pi, alpha, s + math.pi, dalpha, dalpha, ds)
        expected = mass * (0.5 * dalpha**2 + height)
        found = energy(pose(y), free_chain(SIMPLEST), constants(SIMPLEST))
        assert found == pytest.approx(expected, abs=1e-15)


@pytest.mark.parametrize("name", CASES)
def test_gaits_durations_and_multipliers_are_those_of_an_independent_code(name: str) -> None:
    case = CASES[name]
    params, state = SIMPLEST.replace(slope=case["gamma"]), state_of(CASES[name])
    walked = stride(state, None, params, rtol=1e-13)
    assert walked.state == pytest.approx(state, abs=1e-12)
    gait = find_gait(params, None, [round(x, 3) for x in state])
    assert gait.state == pytest.approx(state, abs=1e-12)
    assert gait.duration == pytest.approx(case["T"], abs=1e-12)
    assert gait.step_length == pytest.approx(case["steplen"], abs=1e-12)
    expected = np.array([complex(*pair) for pair in case["eig"]])
    assert gait.multipliers[:2] == pytest.approx(expected, abs=1e-12)
    assert np.abs(gait.multipliers[2:]).max() < 1e-12  # the strike leaves two numbers free


def test_a_gait_loses_at_the_strike_what_the_slope_gives() -> None:
    walked = stride(state_of(CASES["0.009_long"]), None, SIMPLEST, rtol=1e-13)
    given = 2 * SIMPLEST.leg_mass * SIMPLEST.gravity * walked.step_length * math.sin(0.009)
    assert walked.energy_lost == pytest.approx(given, abs=1e-13)


def test_the_long_gait_doubles_where_an_independent_code_has_it() -> None:
    gait = find_gait(SIMPLEST, None, state_of(CASES["0.009_long"]))
    branch = continue_gait(gait, "slope", (0.005, 0.0178), step=0.1)
    (point,) = branch.of_kind(SpecialKind.PERIOD_DOUBLING)
    assert point.value == pytest.approx(DOUBLING, abs=1e-12)


def tend_to(limit: Array, values: list[Array]) -> None:
    """The values of masses, each a hundredth of the one before, differ from it in proportion."""
    gaps = [np.abs(value - limit).max() for value in values]
    for larger, smaller in itertools.pairwise(gaps):
        assert larger / smaller == pytest.approx(100.0, rel=0.05)


def light_feet(foot_mass: float, **fields: Any) -> WalkerParams:
    """Garcia's walker, but for feet of some mass."""
    return WalkerParams.from_composite_leg(
        hip_mass=0.5, foot_mass=foot_mass, gravity=1.0, slope=0.009,
        **{"foot_length": 0.0, "locked_ankle_angle": math.pi, **fields},
    )  # fmt: skip


@pytest.mark.parametrize("name", ["0.009_long", "0.009_short"])
def test_gaits_on_light_feet_tend_to_it_like_the_feet_s_mass(name: str) -> None:
    def quantities(params: WalkerParams) -> Array:
        gait = find_gait(params, None, state_of(CASES[name]))
        total, product = gait.multipliers[:2].sum().real, gait.multipliers[:2].prod().real
        return np.array([*gait.state, gait.duration, total, product])

    light = [quantities(light_feet(mass)) for mass in (1e-3, 1e-5, 1e-7)]
    tend_to(quantities(SIMPLEST), light)


#: Round feet ahead of the ankle and a spring, and a start from which they take a step.
GENERAL = {
    "foot_length": 0.1, "foot_radius": 0.2, "locked_ankle_angle": 2.5, "hip_stiffness": 0.3,
}  # fmt: skip
START = (-0.19, 0.24, 0.29, -0.2)


@pytest.mark.parametrize("physics", [CONSERVING, AS_PUBLISHED])
def test_strides_on_light_round_feet_and_with_a_spring_tend_to_the_limit(physics: str) -> None:
    """The spring's stiffness is per unit of the mass at the ankle."""

    def walked(foot_mass: float) -> Array:
        fields = GENERAL | {"hip_stiffness": 0.3 * (foot_mass or 1.0), "physics": physics}
        found = stride(START, None, light_feet(foot_mass, **fields))
        assert found.outcome == Outcome.WALKED
        return np.array([*found.state, found.duration, found.step_length, found.energy_lost])

    tend_to(walked(0.0), [walked(mass) for mass in (1e-3, 1e-5)])


def test_a_powered_stride_tends_to_that_of_massless_feet() -> None:
    _, control, start, _ = PRESETS["camp1997"]
    assert control is not None

    def walked(foot_mass: float) -> Array:
        walker = WalkerParams.from_composite_leg(hip_mass=1000.0, foot_mass=foot_mass)
        found = stride(start, Control(control.switch_angle, control.stall_torque), walker)
        assert found.outcome == Outcome.WALKED
        return np.array([*found.state, found.duration, found.step_length])

    tend_to(walked(0.0), [walked(mass) for mass in (1.0, 1e-2, 1e-4)])


#: Changes that stay in the limit; of the walker's numbers by name.
WITHIN = [
    ("leg_length", "com_along"), ("foot_length",), ("foot_radius",), ("locked_ankle_angle",),
    ("leg_mass",), ("gravity",), ("slope",), ("hip_stiffness",),
]  # fmt: skip


def directions() -> Array:
    """Those and the post-strike state's, as rows of changes of (state, control, walker)."""
    rows = [np.eye(INPUTS)[i] for i in range(4)]
    for names in WITHIN:
        rows.append(np.sum([np.eye(INPUTS)[6 + FIELDS.index(name)] for name in names], axis=0))
    return np.array(rows)


@pytest.mark.parametrize("physics", [CONSERVING, AS_PUBLISHED])
def test_derivatives_are_those_of_differences(physics: str) -> None:
    params = light_feet(0.0, **GENERAL, physics=physics)
    point = point_of(np.array(START), np.array(scheme_of(None).row(None)), params)
    _, exact = variational(PASSIVE_WALKER, point, directions())
    for change, by in zip(directions(), exact.T, strict=True):
        steps = (1e-2, 3e-3, 1e-3, 3e-4)
        gaps = [np.abs(difference(PASSIVE_WALKER, point, change, h) - by).max() for h in steps]
        assert np.nanmin(gaps) < 1e-8 * max(np.abs(by).max(), 1e-3), change
