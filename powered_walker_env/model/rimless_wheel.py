"""The rimless wheel, in closed form: what a walker becomes when its swing leg weighs nothing.

A wheel without its rim rolls down a slope on the tips of n spokes, α = π/n from spoke to
slope normal when two touch. It is McGeer's first model of walking (1990); Coleman
(PhD thesis, Cornell 1998; DCDIS-B 16, 2009) gave the map and its multiplier exactly. With
θ the stance spoke from the slope's normal, ω = θ', γ the slope and λ² = m L²/(I + m L²):

    swing       θ'' = λ² (g/L) sin(θ + γ), from θ = −α to α:
                ω⁻² = ω⁺² + 4 λ² (g/L) sin α sin γ         (energy)
    collision   ω⁺ = μ ω⁻,  μ = 1 + λ² (cos 2α − 1)        (momentum about the new contact)
    stride      ω⁺² ↦ μ² (ω⁺² + 4 λ² (g/L) sin α sin γ)

The map is linear in the squared rate: one fixed point, one multiplier, μ².

Two legs make such a wheel while a stride lasts if the mass is at the hip and the swing leg
weighs nothing: λ² = 1, and α is wherever the swing leg happens to land. That is the
analytic check of the simulator in `tests/model/test_rimless_wheel.py`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from scipy.optimize import brentq
from scipy.special import ellipkinc


@dataclass(frozen=True)
class RimlessWheel:
    """A wheel of spokes on a slope, and its steady rolling.

    Raises:
        ValueError: a field outside its domain; the message names field, need and value.
    """

    half_angle: float  # α, rad, half the angle between two spokes, in (0, π/2)
    slope: float  # γ, rad, downhill positive, in (−π/2, π/2)
    concentration: float = 1.0  # λ² = m L²/(I + m L²), in (0, 1]; 1: all mass at the hub
    spoke_length: float = 1.0  # L, m
    gravity: float = 1.0  # g, m/s²

    def __post_init__(self) -> None:
        needs = {
            "half_angle": ("lie in (0, pi/2)", 0.0 < self.half_angle < math.pi / 2),
            "slope": ("lie in (-pi/2, pi/2)", abs(self.slope) < math.pi / 2),
            "concentration": ("lie in (0, 1]", 0.0 < self.concentration <= 1.0),
            "spoke_length": ("be positive and finite", 0.0 < self.spoke_length < math.inf),
            "gravity": ("be positive and finite", 0.0 < self.gravity < math.inf),
        }
        for name, (need, holds) in needs.items():
            if not holds:
                raise ValueError(f"{name} must {need}, got {getattr(self, name)!r}")

    @classmethod
    def with_spokes(cls, spokes: int, slope: float, concentration: float = 1.0) -> RimlessWheel:
        """A wheel of n spokes, α = π/n, with L = g = 1.

        Raises:
            ValueError: fewer than three spokes, or as the class.
        """
        if spokes < 3:
            raise ValueError(f"spokes must be at least 3 for a wheel, got {spokes!r}")
        return cls(math.pi / spokes, slope, concentration)

    @property
    def _pace(self) -> float:
        """λ² g/L, rad²/s²."""
        return self.concentration * self.gravity / self.spoke_length

    @property
    def retained(self) -> float:
        """μ, the share of its rate that the wheel keeps in a collision."""
        return 1.0 + self.concentration * (math.cos(2.0 * self.half_angle) - 1.0)

    @property
    def gained(self) -> float:
        """Squared rate gained from the slope in a stride, 4 λ² (g/L) sin α sin γ, rad²/s²."""
        return 4.0 * self._pace * math.sin(self.half_angle) * math.sin(self.slope)

    @property
    def multiplier(self) -> float:
        """Floquet multiplier μ² of the stride map, by the squared rate as by the rate."""
        return self.retained**2

    def before_strike(self, rate: float) -> float:
        """The rate just before a collision from that after the last one, rad/s.

        Raises:
            ValueError: a rate too small for the wheel to come over its spoke.
        """
        if not (rate >= 0.0 and rate**2 > self.least_squared_rate):
            raise ValueError(
                f"rate must exceed {math.sqrt(self.least_squared_rate):.6g} rad/s for the wheel "
                f"to come over its spoke, got {rate!r}"
            )
        return math.sqrt(rate**2 + self.gained)

    def stride(self, rate: float) -> float:
        """The rate just after the next collision, rad/s.

        Raises:
            ValueError: as `before_strike`.
        """
        return self.retained * self.before_strike(rate)

    @property
    def least_squared_rate(self) -> float:
        """ω⁺² with which the wheel just comes to rest upright, 2 λ² (g/L) (1 − cos(α − γ)).

        With γ ≥ α the stance spoke is past the vertical from the start, and any rate does.
        """
        if self.slope >= self.half_angle:
            return 0.0
        return 2.0 * self._pace * (1.0 - math.cos(self.half_angle - self.slope))

    @property
    def steady_squared_rate(self) -> float:
        """Fixed point of the stride map, ω⁺² = μ² gained/(1 − μ²), rad²/s²; below 0 uphill."""
        return self.multiplier * self.gained / (1.0 - self.multiplier)

    @property
    def rolls(self) -> bool:
        """Whether the fixed point is a steady rolling: μ > 0, and it comes over its spokes."""
        return self.retained > 0.0 and self.steady_squared_rate > self.least_squared_rate

    @property
    def steady_rate(self) -> float:
        """Rate just after each collision of the steady rolling, rad/s.

        Raises:
            ValueError: the wheel does not roll; the message gives the slope it needs.
        """
        if not self.rolls:
            raise ValueError(
                f"slope must exceed {self.least_slope:.6g} rad for the wheel to roll, "
                f"got {self.slope!r}"
            )
        return math.sqrt(self.steady_squared_rate)

    @property
    def least_slope(self) -> float:
        """The slope, rad, below which the wheel stops: steady and least rate are equal.

        k sin γ = 1 − cos(α − γ) with k = 2 μ² sin α/(1 − μ²), that is r sin(γ + δ) = 1 with
        r e^{iδ} = k + sin α + i cos α. NaN if μ ≤ 0: such a wheel stops at any slope.
        """
        if self.retained <= 0.0:
            return math.nan
        sine = math.sin(self.half_angle)
        k = 2.0 * self.multiplier * sine / (1.0 - self.multiplier)
        across, up = k + sine, math.cos(self.half_angle)
        return math.asin(1.0 / math.hypot(across, up)) - math.atan2(up, across)

    def normal_force(self, angle: float, rate: float) -> float:
        """Floor's push along its normal over the weight; below 0 the wheel would take off.

        Along the spoke g cos ψ − L ω², across it (λ² − 1) g sin ψ, with ψ = angle + slope.
        """
        tilted = angle + self.slope
        along = math.cos(tilted) - self.spoke_length * rate**2 / self.gravity
        across = (self.concentration - 1.0) * math.sin(tilted)
        return along * math.cos(angle) - across * math.sin(angle)

    @property
    def step_length(self) -> float:
        """Distance between two spoke tips, m."""
        return 2.0 * self.spoke_length * math.sin(self.half_angle)

    def duration(self, rate: float) -> float:
        """Time from one collision to the next, s, by elliptic integrals.

        With ψ = θ + γ the energy is ω² = A + 4 λ² (g/L) sin²(ψ/2), A the squared rate at the
        top; so dt = dψ/ω is an incomplete integral of the first kind, m = −4 λ² (g/L)/A.

        Raises:
            ValueError: as `before_strike`.
        """
        self.before_strike(rate)
        first, last = self.slope - self.half_angle, self.slope + self.half_angle
        top = rate**2 - 4.0 * self._pace * math.sin(first / 2.0) ** 2
        if top <= 0.0:  # γ > α and a slow start: it never was upright
            return self._duration_past_the_top(top, first, last)
        m = -4.0 * self._pace / top
        return float(2.0 / math.sqrt(top) * (ellipkinc(last / 2, m) - ellipkinc(first / 2, m)))

    def _duration_past_the_top(self, top: float, first: float, last: float) -> float:
        """The same with A ≤ 0: ω² = 4 λ² (g/L) (sin²(ψ/2) − share).

        With cos(ψ/2) = √(1 − share) sin φ it is the same integral with m = 1 − share.
        """
        k = 4.0 * self._pace
        share = -top / k

        def phase(angle: float) -> float:
            return math.asin(min(1.0, math.cos(angle / 2.0) / math.sqrt(1.0 - share)))

        m = 1.0 - share
        return float(2.0 / math.sqrt(k) * (ellipkinc(phase(first), m) - ellipkinc(phase(last), m)))

    @property
    def steady_speed(self) -> float:
        """Mean speed of the steady rolling, m/s.

        Raises:
            ValueError: the wheel does not roll.
        """
        return self.step_length / self.duration(self.steady_rate)


def synthetic_wheel_steps() -> tuple[float, float]:
    """Steps of McGeer's synthetic wheel, ω τ with ω the swing leg's rate as a pendulum.

    On semicircular feet round the hip (R = l), with all mass at the hip, two legs roll on at a
    constant rate 2 α/τ with no loss (McGeer 1990, section 4). The swing leg begins at α
    behind the hip with that rate and must be at α before it when the step ends:
    cos x + (2/x) sin x = −1, x = ω τ. Its roots below 2π are π and that of tan(x/2) = −x/2.
    """
    long = brentq(lambda x: x * math.cos(x / 2.0) + 2.0 * math.sin(x / 2.0), math.pi, 5.0)
    return math.pi, float(long)
