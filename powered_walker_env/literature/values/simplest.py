"""The simplest walker: all mass at the hip, feet that weigh nothing (Garcia et al. 1998).

Angle θ (positive leaning back), rate θ' and the hip's φ' are those of the paper; unit of
time √(l/g). The package takes the vanishing mass of the feet as the limit that it is (see
`WalkerParams`); only the laws of small slopes are extrapolated, to slope zero.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable

import numpy as np

from powered_walker_env.literature.values import li_yang
from powered_walker_env.literature.values.cascades import last_ratio, slope_of_the_end
from powered_walker_env.literature.values.published import Kind, Origin, load
from powered_walker_env.literature.values.rows import Family, Measures, Row, digits_rows
from powered_walker_env.model.presets import PRESETS
from powered_walker_env.model.state import PostStrikeState
from powered_walker_env.model.walker import WalkerParams
from powered_walker_env.poincare import Gait, SpecialKind, continue_gait, find_gait
from powered_walker_env.simulation.strides import Array

WALKER = "simplest walker"
SOURCE = "this project's independent code for massless feet (after Garcia et al. 1998)"
REFERENCE = 0.009  # slope
RUNGS = 7  # of the ladder of slopes behind the small-slope laws
RUNG = 2.0**1.5  # from one slope to the next: γ^(2/3) is halved
SEEDS = {"long": (0.2003, 0.1998), "short": (0.1939, 0.2039)}  # θ and −θ' at slope 0.009
UP = (0.005, 0.0178)  # slopes of the branch with the first doubling


def walker(slope: float) -> WalkerParams:
    """The walker on a slope; hip mass, leg and gravity 1."""
    return PRESETS["simplest"].params.replace(slope=slope)


def gait(slope: float, seed: tuple[float, float]) -> Gait:
    """The gait near θ and −θ'; its swing leg after the strike turns at −θ' cos 2θ."""
    angle, rate = seed
    guess = PostStrikeState(-angle, angle, rate, rate * math.cos(2.0 * angle))
    return find_gait(walker(slope), None, guess)


@functools.cache
def cycle(slope: float, length: str) -> dict[str, complex]:
    """θ, θ', φ', duration, step length and both multipliers of the long or short gait."""
    angle, rate = SEEDS[length]
    return _limit_cycle(slope, _scaled(angle, rate, slope / REFERENCE))


@functools.cache
def _rung(number: int, length: str) -> dict[str, complex]:
    """The same at a slope of the ladder, from the cycle above."""
    if number == 0:
        return cycle(REFERENCE, length)
    above = _rung(number - 1, length)
    seed = _scaled(above["angle"].real, -above["rate"].real, 1.0 / RUNG)
    return _limit_cycle(REFERENCE / RUNG**number, seed)


def _scaled(angle: float, rate: float, ratio: float) -> tuple[float, float]:
    """θ and −θ' on a slope that is `ratio` times as steep: θ ∝ γ^(1/3)."""
    return angle * ratio ** (1 / 3), rate * ratio ** (1 / 3)


def _limit_cycle(slope: float, seed: tuple[float, float]) -> dict[str, complex]:
    found = gait(slope, seed)
    state = found.state
    first, second = found.multipliers[:2].tolist()
    return {
        "angle": -state.stance_angle,
        "rate": -state.stance_rate,
        "hip_rate": state.swing_rate - state.stance_rate,
        "duration": found.duration,
        "step_length": found.step_length,
        "multiplier": first,
        "multiplier_2": second,
    }


@functools.cache
def law(length: str) -> dict[str, float]:
    """The coefficients of the small-slope laws of Garcia et al. 1998, appendix A.2.

    θ = Θ₀ γ^(1/3) + Θ₁ γ and θ' = α Θ₀ γ^(1/3) + (α Θ₁ + c₁) γ: θ/γ^(1/3) and θ'/γ^(1/3)
    as polynomials in γ^(2/3); τ is the duration in the limit.
    """
    numbers = np.arange(1, RUNGS)
    cycles = [_rung(int(number), length) for number in numbers]
    x = (REFERENCE / RUNG**numbers) ** (2 / 3)

    def coefficients(name: str, root: Array) -> list[float]:
        values = np.array([c[name].real for c in cycles]) / root
        scaled = np.linalg.solve(np.vander(x / x[0], increasing=True), values)
        return [float(scaled[0]), float(scaled[1] / x[0])]

    cube_root = np.sqrt(x)
    angle, angle_1 = coefficients("angle", cube_root)
    rate, rate_1 = coefficients("rate", cube_root)
    alpha = rate / angle
    return {
        "tau": coefficients("duration", np.ones(len(x)))[0],
        "angle": angle,
        "angle_1": angle_1,
        "alpha": alpha,
        "c1": rate_1 - alpha * angle_1,
    }


@functools.cache
def first_doubling() -> float:
    """The slope at which the long gait doubles."""
    branch = continue_gait(_long(), "slope", UP, step=0.1)
    (point,) = branch.of_kind(SpecialKind.PERIOD_DOUBLING)
    return point.value


def identity_residual() -> float:
    """θ' + cot 2θ √(2 (cos(θ − γ) − cos(θ + γ))), zero for every cycle."""
    found, slope = cycle(REFERENCE, "long"), REFERENCE
    angle = found["angle"].real
    fall = 2.0 * (math.cos(angle - slope) - math.cos(angle + slope))
    return float(found["rate"].real + math.sqrt(fall) / math.tan(2.0 * angle))


def _known() -> list[Row]:
    data, accuracy = load("published.json")["simplest_walker"], load("published.json")["accuracy"]
    lines = []
    for case in data["cases"].values():
        name = f"{WALKER}, slope {case['gamma']}, {case['branch']} step"
        origin, ours = _origin(name), cycle(case["gamma"], case["branch"])
        states = [
            ("θ, rad", case["theta"], ours["angle"]),
            ("θ', rad/s", case["thetadot"], ours["rate"]),
            ("φ', rad/s", case["phidot"], ours["hip_rate"]),
            ("step duration", case["T"], ours["duration"]),
            ("step length", case["steplen"], ours["step_length"]),
        ]
        first, second = (complex(*pair) for pair in case["eig"])
        factors = [("multiplier 1", first, ours["multiplier"])]
        if second.imag == 0.0:  # else the conjugate of the first
            factors.append(("multiplier 2", second, ours["multiplier_2"]))
        lines += digits_rows(origin, states, accuracy["states"])
        lines += digits_rows(origin, factors, accuracy["multipliers"])
    doubling = ("first doubling, slope", data["first_period_doubling"]["gamma"], first_doubling())
    return lines + digits_rows(_origin(f"{WALKER}, in its slope"), [doubling], accuracy["states"])


def _origin(walker: str) -> Origin:
    return Origin(Kind.OWN, "simplest", walker, SOURCE)


def _of_cycle(length: str, name: str) -> Callable[[], complex]:
    return lambda: cycle(REFERENCE, length)[name]


def _of_law(length: str, name: str) -> Callable[[], complex]:
    return lambda: law(length)[name]


@functools.cache
def _long() -> Gait:
    return gait(REFERENCE, SEEDS["long"])


_CYCLE = ("angle", "rate", "hip_rate", "duration", "multiplier", "multiplier_2")
_LAW = ("tau", "angle", "angle_1", "alpha", "c1")
MEASURES: Measures = {
    **{f"{a}_{n}": _of_cycle(a, n) for a in SEEDS for n in _CYCLE},
    **{f"law_{a}_{n}": _of_law(a, n) for a in SEEDS for n in _LAW},
    "first_doubling": first_doubling,
    "identity": identity_residual,
    "feigenbaum": lambda: last_ratio(_long(), "slope", (0.005, 0.0185)),
    "end": lambda: slope_of_the_end(_long(), (0.0182, 0.0205)),
    **li_yang.measures(3),
    **li_yang.measures(4),
}

FAMILY = Family("simplest", MEASURES, _known)
