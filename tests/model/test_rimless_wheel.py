"""The rimless wheel in closed form, and the simulator held against it."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp

from powered_walker_env import Outcome, PostStrikeState, WalkerParams, find_gait, stride
from powered_walker_env.literature.values.published import load
from powered_walker_env.model.rimless_wheel import RimlessWheel, synthetic_wheel_steps
from tests.helpers.derivation import Array

SLOPE = 0.009
WHEELS = [
    RimlessWheel.with_spokes(6, 0.2, 2 / 3),
    RimlessWheel.with_spokes(8, 0.08),
    RimlessWheel(0.2, 0.009),
    RimlessWheel(0.3, 0.5, 0.9, spoke_length=0.7, gravity=9.81),  # steeper than half its angle
]


def swing(wheel: RimlessWheel, rate: float) -> tuple[float, float]:
    """Duration and rate at the end of a swing, by integrating θ'' = λ² (g/L) sin(θ + γ)."""
    pace = wheel.concentration * wheel.gravity / wheel.spoke_length

    def landed(_: float, y: Array) -> float:
        return y[0] - wheel.half_angle

    landed.terminal = True  # type: ignore[attr-defined]
    run = solve_ivp(
        lambda _, y: [y[1], pace * math.sin(y[0] + wheel.slope)],
        (0.0, 100.0), [-wheel.half_angle, rate],
        events=landed, rtol=1e-12, atol=1e-13, method="DOP853",
    )  # fmt: skip
    return float(run.t[-1]), float(run.y[1, -1])


def test_coleman_s_benchmark_wheel() -> None:
    published = load("published.json")["rimless_wheel"]["rimless_wheel"]
    wheel = RimlessWheel.with_spokes(published["n"], published["alpha"], published["lambda2"])
    assert wheel.steady_rate == pytest.approx(published["x0"][1], abs=5e-16)
    assert wheel.multiplier == pytest.approx(published["sigma"], abs=1e-15)
    assert wheel.half_angle == pytest.approx(-published["x0"][0], abs=1e-13)


@pytest.mark.parametrize("wheel", WHEELS, ids=str)
def test_the_closed_forms_are_the_equation_of_motion_s(wheel: RimlessWheel) -> None:
    for rate in (1.05 * wheel.steady_rate, 2.0 * wheel.steady_rate):
        duration, before = swing(wheel, rate)
        assert wheel.before_strike(rate) == pytest.approx(before, rel=1e-10)
        assert wheel.duration(rate) == pytest.approx(duration, rel=1e-10)
    steady = wheel.steady_rate
    assert wheel.stride(steady) == pytest.approx(steady, rel=1e-14)
    assert wheel.steady_speed == pytest.approx(wheel.step_length / swing(wheel, steady)[0])
    after = [wheel.stride(steady + h) for h in (-1e-5, 1e-5)]
    assert (after[1] - after[0]) / 2e-5 == pytest.approx(wheel.multiplier, rel=1e-8)


def test_deviations_of_the_squared_rate_shrink_by_the_multiplier_exactly() -> None:
    wheel = WHEELS[0]
    rate = 3.0 * wheel.steady_rate  # far away: the map is linear
    for _ in range(5):
        deviation = rate**2 - wheel.steady_squared_rate
        rate = wheel.stride(rate)
        kept = (rate**2 - wheel.steady_squared_rate) / deviation
        assert kept == pytest.approx(wheel.multiplier, rel=1e-11)


def test_the_collision_keeps_the_angular_momentum_of_masses_on_the_spokes() -> None:
    """Two point masses m/2 at ±ρ from the hub, any way round: I = m ρ², λ² = 1/(1 + ρ²)."""
    half, gyration, rate = 0.35, 0.6, 1.3
    wheel = RimlessWheel(half, 0.0, 1.0 / (1.0 + gyration**2))
    hub = complex(math.cos(half), math.sin(half))  # up + i·forward, from the old contact
    contact = complex(0.0, 2.0 * math.sin(half))
    momentum = inertia = 0.0
    for offset in (gyration * np.exp(0.8j), -gyration * np.exp(0.8j)):
        place = hub + offset
        momentum += 0.5 * ((place - contact).conjugate() * place * rate).real
        inertia += 0.5 * abs(place - contact) ** 2
    assert momentum / inertia == pytest.approx(wheel.retained * rate, rel=1e-13)


@pytest.mark.parametrize(("spokes", "concentration"), [(6, 2 / 3), (8, 1.0), (12, 0.5)])
def test_below_the_least_slope_the_wheel_stops(spokes: int, concentration: float) -> None:
    least = RimlessWheel.with_spokes(spokes, 0.0, concentration).least_slope
    above, below = (
        RimlessWheel.with_spokes(spokes, least * factor, concentration) for factor in (1.001, 0.999)
    )
    assert above.rolls
    assert not below.rolls
    assert swing(above, above.steady_rate)[0] < 99.0  # it comes over its spoke
    with pytest.raises(ValueError, match="slope must exceed"):
        _ = below.steady_rate
    with pytest.raises(ValueError, match=r"rate must exceed .* to come over its spoke"):
        above.stride(0.99 * math.sqrt(above.least_squared_rate))
    triangle = RimlessWheel.with_spokes(3, 0.5)  # a collision would throw it back
    assert triangle.retained < 0.0
    assert math.isnan(triangle.least_slope) and not triangle.rolls


def test_a_fast_wheel_would_take_off() -> None:
    wheel = RimlessWheel.with_spokes(8, 0.08)
    end = wheel.half_angle
    assert wheel.normal_force(end, wheel.before_strike(wheel.steady_rate)) > 0.5
    assert wheel.normal_force(end, 1.1) < 0.0
    assert wheel.normal_force(0.0, 0.0) == pytest.approx(math.cos(wheel.slope))


def test_bad_wheels_are_named() -> None:
    with pytest.raises(ValueError, match=r"half_angle must lie in \(0, pi/2\), got 2.0"):
        RimlessWheel(2.0, 0.1)
    with pytest.raises(ValueError, match=r"concentration must lie in \(0, 1\], got 1.5"):
        RimlessWheel(0.3, 0.1, 1.5)
    with pytest.raises(ValueError, match="spokes must be at least 3"):
        RimlessWheel.with_spokes(2, 0.1)
    with pytest.raises(ValueError, match="slope must lie in"):
        RimlessWheel(0.3, math.nan)


# The simulator as a wheel: all mass at the hip, and a swing leg that weighs nothing, so that
# the stance leg is a pendulum and a collision keeps cos 2α of its rate.


def legs(foot_mass: float, slope: float = SLOPE) -> WalkerParams:
    return WalkerParams.from_composite_leg(
        hip_mass=0.5, foot_mass=foot_mass, gravity=1.0, slope=slope,
        foot_length=0.0, locked_ankle_angle=math.pi,
    )  # fmt: skip


def limit(masses: Array, values: Array) -> Array:
    """The values at mass zero, by the polynomial through them."""
    others = [np.delete(masses, i) for i in range(len(masses))]
    weights = [np.prod(o / (o - m)) for m, o in zip(masses, others, strict=True)]
    return np.array(weights) @ values


@pytest.mark.parametrize(
    "start",
    [
        (-0.2, 0.2, 0.21, 0.19),  # near the gait
        (-0.2, 0.2, 0.2, 0.06),  # the swing leg lags: shorter steps
        (-0.2, 0.2, 0.2, 0.2),
        (-0.2, 0.2, 0.22, 0.132),
    ],
)
def test_a_stride_on_light_feet_is_a_stride_of_a_wheel(start: tuple[float, ...]) -> None:
    """From legs α₀ apart to legs α₁ apart: energy over the swing, cos 2α₁ at the strike."""
    masses = 2e-5 * np.arange(1.0, 6.0)
    rows = []
    for mass in masses:
        walked = stride(start, None, legs(float(mass)), rtol=1e-13)
        assert walked.outcome is Outcome.WALKED
        final = walked.final.u[0] + walked.final.u[1]  # α' just before the strike
        rows.append([-walked.state.stance_angle, final, walked.state.stance_rate,
                     walked.energy_lost, walked.state.swing_angle])  # fmt: skip
    landing, before, after, lost, swing_angle = limit(masses, np.array(rows)).tolist()
    first, rate = -start[0], start[2]
    gained = 2.0 * (math.cos(first - SLOPE) - math.cos(landing + SLOPE))
    squared = rate**2 + gained
    wheel = RimlessWheel(landing, SLOPE)
    assert before == pytest.approx(math.sqrt(squared), abs=1e-9)
    assert after == pytest.approx(wheel.retained * math.sqrt(squared), abs=1e-9)
    assert lost == pytest.approx(0.5 * squared * math.sin(2.0 * landing) ** 2, abs=1e-9)
    assert swing_angle == pytest.approx(landing, abs=1e-9)
    # At a thousandth of the hip's mass the swing leg's pull is plain to see.
    heavy = stride(start, None, legs(1e-3), rtol=1e-13)
    assert abs(heavy.state.stance_rate - after) > 1e-5


@pytest.mark.parametrize("guess", [(0.2003, 0.1998), (0.1939, 0.2039)], ids=["long", "short"])
def test_a_gait_on_light_feet_is_the_steady_rolling_of_its_wheel(
    guess: tuple[float, float],
) -> None:
    masses = 5e-4 * np.arange(1.0, 7.0)
    rows = []
    for mass in masses:
        angle, rate = guess
        state = PostStrikeState(-angle, angle, rate, rate * math.cos(2 * angle))
        gait = find_gait(legs(float(mass)), None, state)
        rows.append([-gait.state.stance_angle, gait.state.stance_rate, gait.duration, gait.speed])
    angle, rate, duration, speed = limit(masses, np.array(rows)).tolist()
    wheel = RimlessWheel(angle, SLOPE)
    assert wheel.rolls
    assert rate == pytest.approx(wheel.steady_rate, abs=1e-12)
    assert duration == pytest.approx(wheel.duration(wheel.steady_rate), abs=1e-9)
    assert speed == pytest.approx(wheel.steady_speed, abs=1e-9)


def test_on_feet_round_the_hip_the_walker_takes_the_synthetic_wheel_s_steps() -> None:
    """R → l on the level: no loss, constant rate, and the leg's pendulum sets the period."""
    short, long = synthetic_wheel_steps()
    assert short == math.pi
    assert long == pytest.approx(-2.0 * math.tan(long / 2.0), rel=1e-12)
    below, gyration_squared, half = 0.5, 0.1, 0.02  # so small that the pendulum's rate holds
    pendulum = math.sqrt(below / (below**2 + gyration_squared))  # rate of the hanging leg, g = 1
    rate, rows = 2.0 * half * pendulum / long, []
    left = np.array([0.04, 0.05, 0.06, 0.08, 0.1])  # from foot centre to hip; less takes too long
    for rest in left:
        params = WalkerParams.from_composite_leg(
            hip_mass=0.5, frame_mass=1e-5, frame_com_along=rest - below,
            frame_inertia=1e-5 * gyration_squared, leg_length=rest,
            foot_radius=1.0 - rest, foot_length=0.0, gravity=1.0,
            locked_ankle_angle=math.pi,
        )  # fmt: skip
        walked = stride((-half, half, rate, rate), None, params, rtol=1e-12)
        rows.append([walked.duration, walked.state.stance_rate])
    duration, after = limit(left, np.array(rows)).tolist()
    assert duration == pytest.approx(long / pendulum, rel=5e-5)
    assert after == pytest.approx(rate, rel=1e-3)


def test_elliptic_integrals_hold_where_the_wheel_starts_past_the_vertical() -> None:
    wheel = RimlessWheel(0.2, 0.5)
    for rate in (0.01, 0.2, 0.3, 1.0):
        slow, _ = quad(
            lambda angle, rate=rate: 1.0 / math.sqrt(
                rate**2 + 2.0 * (math.cos(0.3) - math.cos(angle + 0.5))
            ),
            -0.2, 0.2, epsabs=1e-12,
        )  # fmt: skip
        assert wheel.duration(rate) == pytest.approx(slow, rel=1e-10)
