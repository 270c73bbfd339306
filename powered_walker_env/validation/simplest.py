"""The simplest walker: all mass at the hip, feet that weigh nothing (Garcia et al. 1998).

Its parameters leave the swing leg without an equation of motion in general walkers, so its
numbers are the limits of walkers with light feet: polynomials in the foot's mass, at zero.
Angle θ (positive leaning back), rate θ' and the hip's φ' are those of the paper; unit of
time √(l/g).
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable

import numpy as np

from powered_walker_env.params import PostStrikeState, WalkerParams
from powered_walker_env.poincare import Gait, SpecialKind, continue_gait, find_gait
from powered_walker_env.stride import Array
from powered_walker_env.validation.cascades import last_ratio, slope_of_the_end
from powered_walker_env.validation.checks import Measures, Row, digits_row, printed_rows
from powered_walker_env.validation.published import load

FAMILY = "simplest"
WALKER = "simplest walker"
REFERENCE = 0.009  # slope
FOOT_MASSES = 5e-4 * np.arange(1.0, 7.0)  # of the hip's mass, 1, at that slope
LIGHT = 1e-4  # foot mass where a limit is not worth its time
RUNGS = 7  # of the ladder of slopes behind the small-slope laws
RUNG = 2.0**1.5  # from one slope to the next: γ^(2/3) is halved
SEEDS = {"long": (0.2003, 0.1998), "short": (0.1939, 0.2039)}  # θ and −θ' at slope 0.009
UP = (0.005, 0.0178)  # slopes of the branch with the first doubling


def walker(foot_mass: float, slope: float) -> WalkerParams:
    """The walker with feet of this mass; hip mass, leg and gravity 1."""
    return WalkerParams.from_composite_leg(
        hip_mass=0.5,
        foot_mass=foot_mass,
        gravity=1.0,
        slope=slope,
        foot_length=0.0,
        locked_ankle_angle=math.pi,
    )


def in_the_limit(quantity: Callable[[float], Array], slope: float = REFERENCE) -> Array:
    """A quantity of the foot mass at foot mass zero, by extrapolation.

    A foot's mass matters as its ratio to θ² ~ γ^(2/3): on a shallower slope it must be less.
    With a walker whose feet may weigh nothing this is `quantity(0.0)`.
    """
    masses = FOOT_MASSES * (slope / REFERENCE) ** (2 / 3)
    return _at_zero(masses) @ np.array([quantity(float(mass)) for mass in masses])


def _at_zero(nodes: Array) -> Array:
    """Lagrange's weights of the values at the nodes for that at zero."""
    others = [np.delete(nodes, i) for i in range(len(nodes))]
    return np.array([np.prod(o / (o - x)) for x, o in zip(nodes, others, strict=True)])


def gait(foot_mass: float, slope: float, seed: tuple[float, float]) -> Gait:
    """The gait near θ and −θ'; its swing leg after the strike turns at −θ' cos 2θ."""
    angle, rate = seed
    guess = PostStrikeState(-angle, angle, rate, rate * math.cos(2.0 * angle))
    return find_gait(walker(foot_mass, slope), None, guess)


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
    def quantities(foot_mass: float) -> Array:
        found = gait(foot_mass, slope, seed)
        state, (first, second) = found.state, found.multipliers[:2]
        angles = [-state.stance_angle, -state.stance_rate, state.swing_rate - state.stance_rate]
        symmetric = [(first + second).real, (first * second).real]
        return np.array([*angles, found.duration, found.step_length, *symmetric])

    *values, total, product = in_the_limit(quantities, slope).tolist()
    names = ("angle", "rate", "hip_rate", "duration", "step_length")
    root = np.emath.sqrt(total**2 - 4.0 * product)  # both from sum and product, which are smooth
    multipliers = sorted(((total + root) / 2.0, (total - root) / 2.0), key=lambda z: -abs(z))
    if abs(multipliers[0].imag) > 0.0:
        multipliers.sort(key=lambda z: -z.imag)
    return dict(zip(names, values, strict=True)) | {
        "multiplier": complex(multipliers[0]),
        "multiplier_2": complex(multipliers[1]),
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

    def slope(foot_mass: float) -> Array:
        branch = continue_gait(_long(foot_mass), "slope", UP, step=0.1)
        (point,) = branch.of_kind(SpecialKind.PERIOD_DOUBLING)
        return np.array([point.value])

    return float(in_the_limit(slope)[0])


def identity_residual() -> float:
    """θ' + cot 2θ √(2 (cos(θ − γ) − cos(θ + γ))), zero for every cycle."""
    found, slope = cycle(REFERENCE, "long"), REFERENCE
    angle = found["angle"].real
    fall = 2.0 * (math.cos(angle - slope) - math.cos(angle + slope))
    return float(found["rate"].real + math.sqrt(fall) / math.tan(2.0 * angle))


def rows(long: bool) -> list[Row]:
    """The lines of this family."""
    data, accuracy = load("published.json")["simplest_walker"], load("published.json")["accuracy"]
    source = "this project's independent code for massless feet (after Garcia et al. 1998)"
    lines = []
    for case in data["cases"].values():
        name = f"{WALKER}, slope {case['gamma']}, {case['branch']} step"
        ours = cycle(case["gamma"], case["branch"])
        compared = {
            "θ, rad": (case["theta"], ours["angle"]),
            "θ', rad/s": (case["thetadot"], ours["rate"]),
            "φ', rad/s": (case["phidot"], ours["hip_rate"]),
            "step duration": (case["T"], ours["duration"]),
            "step length": (case["steplen"], ours["step_length"]),
            "multiplier 1": (complex(*case["eig"][0]), ours["multiplier"]),
        }
        if case["eig"][1][1] == 0.0:  # else the conjugate of the first
            compared["multiplier 2"] = (complex(*case["eig"][1]), ours["multiplier_2"])
        lines += [
            digits_row(FAMILY, name, source, quantity, value, found, accuracy["limit"])
            for quantity, (value, found) in compared.items()
        ]
    doubling = data["first_period_doubling"]["gamma"]
    lines.append(
        digits_row(
            FAMILY, f"{WALKER}, in its slope", source, "first doubling, slope", doubling,
            first_doubling(), accuracy["limit"],
        )
    )  # fmt: skip
    return lines + printed_rows(FAMILY, MEASURES, long)


def _of_cycle(length: str, name: str) -> Callable[[], complex]:
    return lambda: cycle(REFERENCE, length)[name]


def _of_law(length: str, name: str) -> Callable[[], complex]:
    return lambda: law(length)[name]


@functools.cache
def _long(foot_mass: float) -> Gait:
    return gait(foot_mass, REFERENCE, SEEDS["long"])


_CYCLE = ("angle", "rate", "hip_rate", "duration", "multiplier", "multiplier_2")
_LAW = ("tau", "angle", "angle_1", "alpha", "c1")
MEASURES: Measures = {
    **{f"{a}_{n}": _of_cycle(a, n) for a in SEEDS for n in _CYCLE},
    **{f"law_{a}_{n}": _of_law(a, n) for a in SEEDS for n in _LAW},
    "first_doubling": first_doubling,
    "identity": identity_residual,
    "feigenbaum": lambda: last_ratio(_long(LIGHT), "slope", (0.005, 0.0185)),
    "end": lambda: slope_of_the_end(_long(LIGHT), (0.0182, 0.0205)),
}
