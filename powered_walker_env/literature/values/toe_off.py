"""Walkers on the level with a push-off: legs with masses, and Kuo's simplest walker (2002).

Kuo's walker has all its mass at the hip (`WalkerParams.massless_foot`); unit of mass is the
hip's, of length the leg, of time √(l/g). His state is (θ, φ, θ', φ'): the stance leg leaning
back by θ, the angle φ between the legs and their rates. His spring between the legs is our
`hip_stiffness`, his push-off impulse P comes just before heel strike.

Not here: his powering by a torque of the stance leg against a torso that takes no part, which
puts in what the collision takes as gravity does; a slope stands in for it. McGeer's hip powers
his walkers with a torso, which this model has not.
"""

from __future__ import annotations

import functools
import math

import numpy as np
from scipy.optimize import root

from powered_walker_env.literature.values.passive import gait_rows
from powered_walker_env.literature.values.published import TOE_OFF_GAITS
from powered_walker_env.literature.values.rows import Family, Row
from powered_walker_env.literature.values.simplest import REFERENCE, SEEDS
from powered_walker_env.model.powering import ToeOff
from powered_walker_env.model.state import PostStrikeState
from powered_walker_env.model.walker import WalkerParams
from powered_walker_env.poincare import Gait, find_gait
from powered_walker_env.simulation.strides import Array, stride

EARTH = 9.81  # m/s²: Kuo's m/s and Hz are of a leg of 1 m
# Impulse, stiffness and state (θ, φ, θ', φ') of Kuo's gaits, to find ours from.
SLOW = (0.04, 0.0, (0.195, 0.389, -0.203, -0.015))
NORMAL = (0.1877, 2.5127, (0.355, 0.711, -0.506, -0.122))
CREEPING = (0.001, 0.125, (0.0307, 0.0614, -0.03256, -6.1e-5))
SHORT = (0.1, 0.05)  # step lengths between which a power law's exponent is taken
SHALLOW = 1e-4  # slope, of a walker with steps short enough for laws of short steps
RUNGS = 12  # slopes on the way there
SPRING = 0.1  # between its legs


def kuo(stiffness: float = 0.0, slope: float = 0.0) -> WalkerParams:
    """Kuo's simplest walker: mass, leg and gravity 1."""
    return WalkerParams(
        foot_length=0.0,
        locked_ankle_angle=math.pi,
        leg_mass=0.5,
        leg_inertia=0.0,
        com_along=1.0,
        gravity=1.0,
        hip_stiffness=stiffness,
        slope=slope,
    )


@functools.cache
def kuos_gait(impulse: float, stiffness: float, seed: tuple[float, ...]) -> Gait:
    """The gait near his state."""
    theta, phi, rate, hip_rate = seed
    guess = PostStrikeState(-theta, phi - theta, -rate, hip_rate - rate)
    return find_gait(kuo(stiffness), ToeOff(impulse), guess)


def kuos_state(gait: Gait) -> tuple[float, float, float, float]:
    """(θ, φ, θ', φ') of a gait."""
    alpha, s, dalpha, ds = gait.state
    return -alpha, s - alpha, -dalpha, ds - dalpha


def gait_at(speed: float, step_length: float, start: Gait) -> Gait:
    """The gait of that speed and step length: impulse and spring are solved for.

    Args:
        start: a gait on the level with a push-off, near the one wanted.
    """
    state = start.state

    def misses(x: Array) -> list[float]:
        nonlocal state
        found = find_gait(kuo(float(x[1])), ToeOff(float(x[0])), state)
        state = found.state
        return [found.speed / speed - 1.0, found.step_length / step_length - 1.0]

    assert isinstance(start.control, ToeOff)
    guess = [start.control.impulse, start.params.hip_stiffness]
    impulse, stiffness = root(misses, guess, tol=1e-11).x.tolist()
    return find_gait(kuo(stiffness), ToeOff(impulse), state)


@functools.cache
def exponent() -> float:
    """d ln(rate of collision losses)/d ln(step length) at the normal gait's step frequency."""
    gait = kuos_gait(*NORMAL)
    frequency, powers = 1.0 / gait.duration, []
    for length in (0.5, 0.35, 0.25, 0.18, 0.13, *SHORT):
        ratio = length / gait.step_length
        # Impulses of short steps are as the square of their length, states as the length.
        nearer = ToeOff(gait.control.impulse * ratio**2)  # type: ignore[union-attr]
        guess = [ratio * value for value in gait.state]
        gait = gait_at(frequency * length, length, find_gait(gait.params, nearer, guess))
        lost = stride(gait.state, gait.control, gait.params, rtol=1e-13).energy_lost
        powers.append(lost * frequency)
    return math.log(powers[-2] / powers[-1]) / math.log(SHORT[0] / SHORT[1])


@functools.cache
def cost_ratio() -> float:
    """What gravity puts in over a step, over the push-off's work at the same speed and length."""
    passive = _with_spring(_on_the_shallow_slope())
    half, speed = passive.state.swing_angle, passive.state.stance_rate
    push = ToeOff(speed * math.tan(half))
    start = find_gait(kuo(SPRING), push, passive.state)
    level = gait_at(passive.speed, passive.step_length, start)
    return math.sin(SHALLOW) * passive.step_length / level.positive_work


def _on_the_shallow_slope() -> Gait:
    """The long passive gait, from Garcia's slope down: angles and rates are as slope^(1/3)."""
    angle, rate = SEEDS["long"]
    guess = [-angle, angle, rate, rate * math.cos(2.0 * angle)]
    slopes = np.geomspace(REFERENCE, SHALLOW, RUNGS)
    for slope in slopes.tolist():
        found = find_gait(kuo(0.0, slope), None, guess)
        guess = (np.array(found.state) * (slopes[1] / slopes[0]) ** (1 / 3)).tolist()
    return found


def _with_spring(passive: Gait) -> Gait:
    """The same passive walker with the spring, stiffened in steps."""
    for stiffness in np.linspace(0.0, SPRING, 5)[1:].tolist():
        passive = find_gait(kuo(stiffness, SHALLOW), None, passive.state)
    return passive


def _known() -> list[Row]:
    return [row for gait in TOE_OFF_GAITS for row in gait_rows(FAMILY.name, gait)]


_STATE = ("angle", "legs", "rate", "legs_rate")


def _component(seed: tuple[float, float, tuple[float, ...]], number: int) -> complex:
    return kuos_state(kuos_gait(*seed))[number]


def _work_over_half_square() -> complex:
    """Work of the push-off over ½P²."""
    return kuos_gait(*NORMAL).positive_work / (0.5 * NORMAL[0] ** 2)


FAMILY = Family(
    "toe-off",
    {
        **{
            f"{name}_{part}": functools.partial(_component, seed, number)
            for name, seed in (("slow", SLOW), ("normal", NORMAL), ("creeping", CREEPING))
            for number, part in enumerate(_STATE)
        },
        "slow_speed": lambda: kuos_gait(*SLOW).speed,
        "normal_speed": lambda: kuos_gait(*NORMAL).speed * math.sqrt(EARTH),
        "normal_frequency": lambda: math.sqrt(EARTH) / kuos_gait(*NORMAL).duration,
        "work": _work_over_half_square,
        "exponent": exponent,
        "cost_ratio": cost_ratio,
    },
    _known,
)
