"""What a step-to-step transition must cost: from one stance leg's arc to the next.

A mass m on a massless stance leg moves across it. At heel strike, with 2α between the legs, the
leading leg takes the component along itself (Kuo 2002; Ruina, Bertram and Srinivasan 2005): of
v is left v cos 2α, and ½mv² sin²2α is lost. To go on at v, which the level asks for, either

- that is put in elsewhere in the step; or
- the trailing leg pushes with P just before. Across the new leg is then v cos 2α + P/m sin 2α,
  which is v for P = mv tan α. Its work, P²/2m = ½mv² tan²α, is all that is lost:
  a quarter, for short steps, of what it costs to power the walker elsewhere. Pushing with or
  after the strike meets the foot moving, or the leading leg blocked, and costs more.

So ½mv² tan²α is the least work per step of a mass on stiff legs that push along themselves: less
would need an impulse across the leg. With v and α from speed and step length, by the
pendulum θ'' = (g/L) sin θ from −α to α, it is a curve to measure walkers by (`least_cost`). For
legs with masses and feet, `ideal_push` is the same transition by the two momenta of the heel
strike: the impulse along the trailing leg, just before, after which the walker has the kinetic
energy that it came with.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from scipy.integrate import quad
from scipy.optimize import brentq

from powered_walker_env.model.checks import real_number, require
from powered_walker_env.model.mechanics.chain import kinetic_energy, pose_of
from powered_walker_env.model.mechanics.packing import chains_of, constants_of
from powered_walker_env.model.mechanics.push_off import push_off, work_before
from powered_walker_env.model.walker import WalkerParams

SLOWEST, FASTEST = 1e-8, 1e3  # mid-stance rates looked at, units of √(g/L)


def strike_rate(time: float, half_angle: float) -> float:
    """Rate of the pendulum θ'' = sin θ at ±`half_angle`, which it passes `time` apart.

    From the energy, θ'² = ω² + 2(1 − cos θ) with ω the rate at the top.

    Raises:
        ValueError: a time too long or too short for any pendulum.
    """

    def passage(rate: float) -> float:
        def slowness(u: float) -> float:
            # θ = ω sinh u takes the peak at the top away: dθ/√(ω² + θ²) = du.
            theta = rate * math.sinh(u)
            fall = 4.0 * math.sin(0.5 * theta) ** 2
            return math.sqrt((rate**2 + theta**2) / (rate**2 + fall))

        end = math.asinh(half_angle / rate)
        return 2.0 * float(quad(slowness, 0.0, end, epsabs=1e-13, epsrel=1e-12)[0])

    if not passage(FASTEST) < time < passage(SLOWEST):
        raise ValueError(
            f"time must lie between {passage(FASTEST):.3g} and {passage(SLOWEST):.3g} √(L/g) for "
            f"a step of ±{half_angle:.3g} rad, got {time!r}; give a speed that a leg can walk at"
        )
    top = brentq(lambda x: passage(math.exp(x)) - time, math.log(SLOWEST), math.log(FASTEST),
                 xtol=1e-13)  # fmt: skip
    return math.hypot(math.exp(top), 2.0 * math.sin(0.5 * half_angle))


def least_cost(speed: float, step_length: float, params: WalkerParams) -> float:
    """Least cost of transport of a mass on massless legs at this speed and step length.

    It walks on the level, on point feet: round ones, which roll, may do with less.

    Args:
        speed: m/s, mean. step_length: m, less than two legs.
        params: gravity and the leg, with its foot, are used; the masses do not matter.

    Returns:
        Work over weight times distance, v² tan²α/(2gl).

    Raises:
        ValueError: a speed or step length out of bounds.
    """
    length = leg(params)
    step = real_number("step_length", step_length)
    require(0 < step < 2 * length, "step_length", f"lie in (0, {2 * length!r})", step)
    pace = real_number("speed", speed)
    require(pace > 0, "speed", "be positive", pace)
    half_angle = math.asin(0.5 * step / length)
    unit = math.sqrt(length / params.gravity)
    rate = strike_rate(step / pace / unit, half_angle)
    return 0.5 * (rate * math.tan(half_angle)) ** 2 * length / step


def leg(params: WalkerParams) -> float:
    """From the sole to the hip with the ankle locked, m: |L + D e^{−i·lock}| + R."""
    c = constants_of(params)
    return abs(c.L + c.retracted) + c.R


def ideal_push(strike: Sequence[float], params: WalkerParams) -> tuple[float, float]:
    """Impulse, N s, and work, J, of the ideal push-off at a heel strike.

    Args:
        strike: (φ, α, β, φ', α', β') just before it.

    The state after is linear in the impulse, so that its kinetic energy is a parabola.

    Raises:
        ValueError: no push along the trailing leg keeps the kinetic energy.
    """
    c, free = constants_of(params), chains_of(params).free
    y = tuple(float(value) for value in strike)
    pose = pose_of(*y)
    before = kinetic_energy(pose, free, c)
    unit = math.sqrt(2.0 * before * 2.0 * params.leg_mass)  # a momentum
    tries = np.array([0.0, 0.5, 1.0])
    after = [
        kinetic_energy(push_off(pose, unit * share, free, c), free, c) - before for share in tries
    ]
    roots = np.roots(np.polyfit(tries, after, 2))
    good = sorted(root.real for root in roots if abs(root.imag) < 1e-9 and root.real > 0)
    if not good:
        raise ValueError(
            f"strike must be one that a push along the trailing leg makes up for, got {y!r}"
        )
    impulse = unit * good[0]
    return impulse, float(work_before(pose, impulse, c))
