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

from powered_walker_env.model.checks import require
from powered_walker_env.model.knee import Knee, thigh_of
from powered_walker_env.model.legs import composite_leg, kneed_leg
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

    def number(self, name: str) -> float:
        """One of the walker's numbers, or of its knee's, by the name of its field.

        Raises:
            ValueError: no such number; one of the knee of a walker that has none.
        """
        if name in quantities(WalkerParams):
            return float(getattr(self, name))
        known = quantities(Knee)
        require(name in known, "name", f"be one of {', '.join(quantities(self) | known)}", name)
        return float(getattr(self._has_knee(name), name))

    def _has_knee(self, name: str) -> Knee:
        if self.knee is None:
            raise ValueError(
                f"{name} must be of a walker with knees; this one has none: give knee=Knee(...)"
            )
        return self.knee

    def replace(self, **changes: Any) -> WalkerParams:
        """The same walker with some fields changed (and checked), those of its knee included.

        Raises:
            TypeError: a field that does not exist, named with those that do.
            ValueError: a field outside its domain; one of the knee of a walker that has none.
        """
        of_knee = {name: changes.pop(name) for name in quantities(Knee) if name in changes}
        self._reject_unknown(changes)
        if of_knee:
            knee = changes.get("knee") or self._has_knee(next(iter(of_knee)))
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
            fields = {**fields, "knee": Knee.from_dict(knee)}
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
    def from_composite_leg(cls, *, hip_mass: float, **parts: Any) -> WalkerParams:
        """Assemble a leg from a hip mass, a frame and a foot mass at the ankle.

        Args:
            hip_mass: one leg's share of the hip, kg, at the hip.
            **parts: what `legs.composite_leg` takes besides (`frame_mass`, `foot_mass`,
                `leg_length`, ...), and any other field of `WalkerParams`.

        Raises:
            ValueError: a negative mass or inertia, or no mass at all.
        """
        return cls(**composite_leg(hip_mass=hip_mass, **parts))

    @classmethod
    def from_kneed_leg(
        cls, *, hip_mass: float, thigh_mass: float, shank_mass: float, **parts: Any
    ) -> WalkerParams:
        """Assemble a leg with a knee from a hip mass, a thigh, a shank and a foot at the ankle.

        Args:
            hip_mass: one leg's share of the hip, kg, at the hip.
            thigh_mass, shank_mass: kg.
            **parts: what `legs.kneed_leg` takes besides (`thigh_length`, `shank_length`,
                `foot_mass`, ...), and any other field of `WalkerParams`.

        Raises:
            ValueError: a negative mass or inertia, a segment without length.
        """
        masses = {"hip_mass": hip_mass, "thigh_mass": thigh_mass, "shank_mass": shank_mass}
        fields, knee = kneed_leg(**masses, **parts)
        return cls(**fields, knee=knee)
