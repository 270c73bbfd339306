"""The walker's parameters, its control and its state after heel strike (Camp 1997, Appendix A).

SI units and radians throughout. Everything is checked when it is made, so that nothing
downstream meets an impossible walker.
"""

from __future__ import annotations

import dataclasses
import json
import math
import numbers
from dataclasses import dataclass
from typing import Any, NamedTuple

CONSERVING = "conserving"  # the thesis's text: the physics to use
AS_PUBLISHED = "as_published"  # the thesis's listing: reproduces its printed numbers


def real_number(name: str, value: Any) -> float:
    """`value` as a finite Python float (numba compiles a second kernel for an int)."""
    if isinstance(value, bool) or not isinstance(value, numbers.Real):
        raise TypeError(f"{name} must be a real number, got {value!r}")
    try:
        number = float(value)
    except OverflowError:  # an integer beyond the floats
        number = math.inf
    if not math.isfinite(number):
        raise ValueError(f"{name} must be finite, got {value!r}")
    return number


def require(holds: bool, name: str, need: str, value: object, remedy: str = "") -> None:
    if not holds:
        raise ValueError(f"{name} must {need}, got {value!r}" + (f"; {remedy}" if remedy else ""))


@dataclass(frozen=True, kw_only=True)
class WalkerParams:
    """A planar walker: two identical legs, hinged at the hip, each with a massless round foot.

    The defaults are the geometry of the thesis's figure 6: hip 1000 kg and ankle 1 kg
    per leg, L = 1 m, D = 0.05 m, point feet.

    A leg whose whole mass is at the hip (no inertia, `com_along` = L, `com_across` = 0)
    swings as if a vanishing mass were at its ankle: the simplest walker of Garcia et al.
    (1998), exactly. Its `hip_stiffness` is per unit of that mass.

    Raises:
        ValueError: a field outside its domain; the message names field, need and value.
        TypeError: a field that is not a number, or an unknown field.
    """

    leg_length: float = 1.0  # L, m, ankle to hip, > 0
    foot_length: float = 0.05  # D, m, ankle to the centre of the foot, >= 0
    foot_radius: float = 0.0  # R, m, >= 0
    locked_ankle_angle: float = 0.75 * math.pi  # q2 at the stop, rad, in (-pi, pi]
    leg_mass: float = 1001.0  # M, kg, one leg with its share of the hip, > 0
    leg_inertia: float = 1000.0 / 1001.0  # I, kg m^2, about the leg's centre of mass, >= 0
    com_along: float = 1000.0 / 1001.0  # X, m, centre of mass from the ankle, along the leg
    com_across: float = 0.0  # Y, m, the same across the leg, forward positive on the stance leg
    gravity: float = 10.0  # m/s^2, > 0
    slope: float = 0.0  # rad, downhill positive, |slope| < pi/2
    no_load_speed: float = 100.0  # rad/s, of the ankle motor, > 0
    hip_stiffness: float = 0.0  # N m/rad, of a spring between the legs, >= 0 (below)
    torque_limit: float = 0.0  # N m, of the ankle motor, >= 0; 0 for none
    physics: str = CONSERVING  # "conserving" (the text) or "as_published" (the listing)

    def __post_init__(self) -> None:
        for field in dataclasses.fields(self):
            if field.name != "physics":
                value = real_number(field.name, getattr(self, field.name))
                object.__setattr__(self, field.name, value)
        for name in ("leg_length", "leg_mass", "gravity", "no_load_speed"):
            require(getattr(self, name) > 0, name, "be positive", getattr(self, name))
        for name in (
            "foot_length",
            "foot_radius",
            "leg_inertia",
            "hip_stiffness",
            "torque_limit",
        ):
            require(getattr(self, name) >= 0, name, "not be negative", getattr(self, name))
        q2, slope = self.locked_ankle_angle, self.slope
        require(
            -math.pi < q2 <= math.pi,
            "locked_ankle_angle",
            "lie in (-pi, pi]",
            q2,
            "angles are radians",
        )
        require(
            abs(slope) < math.pi / 2,
            "slope",
            "lie in (-pi/2, pi/2)",
            slope,
            "radians, downhill positive",
        )
        require(
            self.physics in (CONSERVING, AS_PUBLISHED),
            "physics",
            f"be {CONSERVING!r} or {AS_PUBLISHED!r}",
            self.physics,
        )

    @property
    def massless_foot(self) -> bool:
        """Whether the whole mass is at the hip: the limit of a massless foot."""
        at_hip = self.com_along == self.leg_length and self.com_across == 0
        return at_hip and self.leg_inertia == 0

    def replace(self, **changes: Any) -> WalkerParams:
        """The same walker with some fields changed (and checked).

        Raises:
            TypeError: a field that does not exist, named with those that do.
            ValueError: a field outside its domain.
        """
        self._reject_unknown(changes)
        return dataclasses.replace(self, **changes)

    def to_dict(self) -> dict[str, Any]:
        """The fields by name: plain numbers and strings, ready for JSON."""
        return dataclasses.asdict(self)

    @classmethod
    def from_dict(cls, fields: dict[str, Any]) -> WalkerParams:
        """The inverse of `to_dict`; fields left out take their defaults.

        Raises:
            TypeError: an unknown field; ValueError: a field outside its domain.
        """
        if not isinstance(fields, dict):
            raise TypeError(f"params must be a mapping of field to value, got {fields!r}")
        cls._reject_unknown(fields)
        return cls(**fields)

    def to_json(self) -> str:
        """The fields as a JSON object; `from_json` gives back an equal walker."""
        return json.dumps(self.to_dict())

    @classmethod
    def from_json(cls, text: str) -> WalkerParams:
        """The inverse of `to_json`."""
        return cls.from_dict(json.loads(text))

    @classmethod
    def _reject_unknown(cls, fields: dict[str, Any]) -> None:
        known = [field.name for field in dataclasses.fields(cls)]
        unknown = [name for name in fields if name not in known]
        if unknown:
            raise TypeError(
                f"WalkerParams has no field {unknown[0]!r}; its fields are {', '.join(known)}"
            )

    @classmethod
    def from_composite_leg(
        cls,
        *,
        hip_mass: float,
        frame_mass: float = 0.0,
        foot_mass: float = 0.0,
        leg_length: float = 1.0,
        frame_com_along: float | None = None,
        frame_com_across: float = 0.0,
        frame_inertia: float | None = None,
        **fields: Any,
    ) -> WalkerParams:
        """Assemble a leg from a hip mass, a frame and a foot mass at the ankle.

        The parallel-axis theorem gives the leg's centre of mass and inertia. (The
        listing's `init.m` does the same, but takes the frame's inertia for m L / 12 and
        drops the offsets across the leg; its figures have no frame, so they are right.)

        Args:
            hip_mass: one leg's share of the hip, kg, at the hip.
            frame_mass: kg, spread along the leg.
            foot_mass: kg, at the ankle.
            leg_length: m, ankle to hip.
            frame_com_along: m from the ankle; the middle of the leg if left out.
            frame_com_across: m across the leg, forward positive on the stance leg.
            frame_inertia: kg m² about the frame's centre; a uniform rod's, m L²/12, if
                left out.
            **fields: any other field of `WalkerParams`.

        Raises:
            ValueError: a negative mass or inertia, or no mass at all.
        """
        length = real_number("leg_length", leg_length)
        parts = {"hip_mass": hip_mass, "frame_mass": frame_mass, "foot_mass": foot_mass}
        masses = {name: real_number(name, value) for name, value in parts.items()}
        for name, value in masses.items():
            require(value >= 0, name, "not be negative", value)
        hip, frame, foot = masses.values()
        mass = hip + frame + foot
        require(mass > 0, "hip_mass + frame_mass + foot_mass", "be positive", mass)
        middle = 0.5 * length if frame_com_along is None else frame_com_along
        frame_along = real_number("frame_com_along", middle)
        frame_across = real_number("frame_com_across", frame_com_across)
        rod = frame * length**2 / 12 if frame_inertia is None else frame_inertia
        spin = real_number("frame_inertia", rod)
        require(spin >= 0, "frame_inertia", "not be negative", spin)
        along = (hip * length + frame * frame_along) / mass
        across = frame * frame_across / mass
        inertia = (
            spin
            + frame * ((frame_along - along) ** 2 + (frame_across - across) ** 2)
            + hip * ((length - along) ** 2 + across**2)
            + foot * (along**2 + across**2)
        )
        return cls(
            leg_length=length,
            leg_mass=mass,
            leg_inertia=inertia,
            com_along=along,
            com_across=across,
            **fields,
        )


@dataclass(frozen=True)
class Control:
    """The open-loop control of one stride: when the motor starts and how strong it is.

    Raises:
        ValueError: `switch_angle` outside (0, 2π) or a `stall_torque` that is negative
            or not finite.
    """

    switch_angle: float  # q3 at which the motor starts, rad, in (0, 2 pi)
    stall_torque: float  # N m, torque of the motor at rest, >= 0

    def __post_init__(self) -> None:
        object.__setattr__(self, "switch_angle", real_number("switch_angle", self.switch_angle))
        object.__setattr__(self, "stall_torque", real_number("stall_torque", self.stall_torque))
        require(
            0 < self.switch_angle < 2 * math.pi,
            "switch_angle",
            "lie in (0, 2*pi)",
            self.switch_angle,
            "angles are radians",
        )
        require(self.stall_torque >= 0, "stall_torque", "not be negative", self.stall_torque)


class PostStrikeState(NamedTuple):
    """The walker just after heel strike, feet locked: the Poincaré section of the package.

    Both legs are measured ankle to hip from the floor's normal, forward positive. After
    a fall there is no such state and all four are NaN.
    """

    stance_angle: float  # α, rad
    swing_angle: float  # s = β − π, rad
    stance_rate: float  # α', rad/s
    swing_rate: float  # β', rad/s


def check_state(state: Any) -> PostStrikeState:
    """The state as four finite floats.

    Raises:
        ValueError: not four numbers, or one that is not finite.
    """
    try:
        values = tuple(state)
    except TypeError:
        values = ()
    require(
        len(values) == 4,
        "state",
        "be four numbers (stance_angle, swing_angle, stance_rate, swing_rate)",
        state,
    )
    named = zip(PostStrikeState._fields, values, strict=True)
    checked = (real_number(f"state.{n}", _plain(v)) for n, v in named)
    return PostStrikeState(*checked)


def _plain(value: Any) -> Any:
    """A numpy scalar as the Python number it holds."""
    return value.item() if getattr(value, "ndim", None) == 0 else value
