"""The walker's parameters (Camp 1997, Appendix A).

SI units and radians throughout. Everything is checked when it is made, so that nothing
downstream meets an impossible walker.
"""

from __future__ import annotations

import dataclasses
import json
import math
from dataclasses import dataclass
from typing import Any

from powered_walker_env.model.checks import real_number, require
from powered_walker_env.model.knee import Knee, thigh_of
from powered_walker_env.model.quantities import (
    ANKLE_ANGLE,
    ANY,
    NOT_NEGATIVE,
    POSITIVE,
    SLOPE,
    check_numbers,
    documented,
    quantities,
    quantity,
)

CONSERVING = "conserving"  # the thesis's text: the physics to use
AS_PUBLISHED = "as_published"  # the thesis's listing: reproduces its printed numbers


@documented
@dataclass(frozen=True, kw_only=True)
class WalkerParams:
    """A planar walker: two identical legs, hinged at the hip, each with a massless round foot.

    The defaults are the geometry of the thesis's figure 6: hip 1000 kg and ankle 1 kg
    per leg, L = 1 m, D = 0.05 m, point feet.

    A leg whose whole mass is at the hip (no inertia, `com_along` = L, `com_across` = 0)
    swings as if a vanishing mass were at its ankle: the simplest walker of Garcia et al.
    (1998), exactly. Its `hip_stiffness` is per unit of that mass.

    With a `knee` the leg is split into thigh and shank; its numbers are those of the straight leg.

    Raises:
        ValueError: a field outside its domain; the message names field, need and value.
        TypeError: a field that is not a number, or an unknown field.
    """

    leg_length: float = quantity("L", "m", "leg length, ankle to hip", POSITIVE, 1.0)
    foot_length: float = quantity(
        "D", "m", "foot length, ankle to the centre of the foot", NOT_NEGATIVE, 0.05
    )
    foot_radius: float = quantity("R", "m", "foot radius", NOT_NEGATIVE, 0.0)
    locked_ankle_angle: float = quantity(
        "q2", "rad", "ankle angle at the stop", ANKLE_ANGLE, 0.75 * math.pi
    )
    leg_mass: float = quantity(
        "M", "kg", "mass of one leg with its share of the hip", POSITIVE, 1001.0
    )
    leg_inertia: float = quantity(
        "I", "kg m²", "inertia of one leg about its centre of mass", NOT_NEGATIVE, 1000.0 / 1001.0
    )
    com_along: float = quantity(
        "X", "m", "centre of mass from the ankle, along the leg", ANY, 1000.0 / 1001.0
    )
    com_across: float = quantity(
        "Y", "m", "centre of mass across the leg, forward positive on the stance leg", ANY, 0.0
    )
    gravity: float = quantity("g", "m/s²", "gravity", POSITIVE, 10.0)
    slope: float = quantity("γ", "rad", "slope of the ground, downhill positive", SLOPE, 0.0)
    no_load_speed: float = quantity(
        "ω0", "rad/s", "no-load speed of the ankle motor", POSITIVE, 100.0
    )
    hip_stiffness: float = quantity(
        "k", "N m/rad", "stiffness of the spring between the legs", NOT_NEGATIVE, 0.0
    )
    torque_limit: float = quantity(
        "τ_max", "N m", "limit of the ankle motor's torque, 0 for none", NOT_NEGATIVE, 0.0
    )
    physics: str = CONSERVING  # "conserving" (the text) or "as_published" (the listing)
    knee: Knee | None = None  # how the leg is split at a knee; None: a straight leg

    def __post_init__(self) -> None:
        check_numbers(self)
        if self.knee is not None:
            if not isinstance(self.knee, Knee):
                raise TypeError(f"knee must be a Knee or None, got {self.knee!r}")
            thigh_of(self)
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
        """The same walker with some fields changed (and checked), those of its knee included.

        Raises:
            TypeError: a field that does not exist, named with those that do.
            ValueError: a field outside its domain; one of the knee of a walker that has none.
        """
        of_knee = {name: changes.pop(name) for name in quantities(Knee) if name in changes}
        self._reject_unknown(changes)
        if of_knee:
            knee = changes.get("knee", self.knee)
            if knee is None:
                raise ValueError(
                    f"{next(iter(of_knee))} must be of a walker with knees; this one has none: "
                    "give knee=Knee(...)"
                )
            changes["knee"] = dataclasses.replace(knee, **of_knee)
        return dataclasses.replace(self, **changes)

    def to_dict(self) -> dict[str, Any]:
        """The fields by name: plain numbers and strings, ready for JSON; no knee is left out."""
        fields = dataclasses.asdict(self)
        return fields if self.knee else {k: v for k, v in fields.items() if k != "knee"}

    @classmethod
    def from_dict(cls, fields: dict[str, Any]) -> WalkerParams:
        """The inverse of `to_dict`; fields left out take their defaults.

        Raises:
            TypeError: an unknown field; ValueError: a field outside its domain.
        """
        if not isinstance(fields, dict):
            raise TypeError(f"params must be a mapping of field to value, got {fields!r}")
        cls._reject_unknown(fields)
        knee = fields.get("knee")
        if isinstance(knee, dict):
            fields = {**fields, "knee": Knee(**knee)}
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
