"""The knee of a leg: how the leg of `WalkerParams` is split into thigh and shank.

The walker's own numbers describe the whole leg, straight; the knee takes the shank off it, and
what is left is the thigh with its share of the hip. So a walker whose knee never bends is the
straight-legged one with the same numbers.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

from powered_walker_env.model.checks import require
from powered_walker_env.model.quantities import (
    ANY,
    NOT_NEGATIVE,
    POSITIVE,
    check_numbers,
    documented,
    quantities,
    quantity,
)

if TYPE_CHECKING:
    from powered_walker_env.model.walker import WalkerParams

ROUNDING = 1e-12  # of a leg's inertia: what a thigh of point masses may fall short of zero


@documented
@dataclass(frozen=True, kw_only=True)
class Knee:
    """A knee that is locked straight on the stance leg and free on the swing leg until it strikes.

    Raises:
        ValueError: a field outside its domain; TypeError: one that is not a number.
    """

    shank_length: float = quantity("ls", "m", "shank length, ankle to knee", POSITIVE)
    shank_mass: float = quantity("ms", "kg", "mass of the shank", POSITIVE)
    shank_com_along: float = quantity(
        "xs", "m", "centre of mass of the shank from the ankle, along the leg", ANY
    )
    shank_com_across: float = quantity(
        "ys",
        "m",
        "centre of mass of the shank across the leg, forward positive on the stance leg",
        ANY,
        0.0,
    )
    shank_inertia: float = quantity(
        "Is", "kg m²", "inertia of the shank about its centre of mass", NOT_NEGATIVE, 0.0
    )

    def __post_init__(self) -> None:
        check_numbers(self)
        at_knee = self.shank_com_along == self.shank_length and self.shank_com_across == 0.0
        require(
            self.shank_inertia > 0.0 or not at_knee,
            "shank_inertia",
            "be positive for a shank whose centre of mass is at its knee",
            self.shank_inertia,
        )

    @classmethod
    def from_dict(cls, fields: dict[str, float]) -> Knee:
        """A knee from its fields by name.

        Raises:
            TypeError: an unknown field, or one that is missing; ValueError: outside its domain.
        """
        known = quantities(cls)
        unknown = [name for name in fields if name not in known]
        if unknown:
            raise TypeError(f"Knee has no field {unknown[0]!r}; its fields are {', '.join(known)}")
        return cls(**fields)


def scaled(params: WalkerParams, mass: float, inertia: float) -> dict[str, float]:
    """Fields of a leg whose thigh and shank both have their masses, and their inertias about
    their own centres of mass, multiplied by these factors; such a leg can always be."""
    assert params.knee is not None
    own = thigh_of(params).inertia + params.knee.shank_inertia
    return {
        "leg_mass": mass * params.leg_mass,
        "leg_inertia": mass * (params.leg_inertia - own) + inertia * own,
        "shank_mass": mass * params.knee.shank_mass,
        "shank_inertia": inertia * params.knee.shank_inertia,
    }


class Thigh(NamedTuple):
    """What the shank leaves of the leg, its share of the hip included."""

    length: float  # m
    mass: float  # kg
    com_along: float  # m, from the ankle
    com_across: float  # m
    inertia: float  # kg m², about its own centre of mass


def thigh_of(params: WalkerParams) -> Thigh:
    """The thigh of a walker with knees, by the parallel-axis theorem.

    Raises:
        ValueError: a shank that is longer, heavier, or of more inertia than the leg has.
    """
    knee, M = params.knee, params.leg_mass
    if knee is None:
        raise ValueError(f"params must have a knee, got {params!r}; give knee=Knee(...)")
    m, length = knee.shank_mass, params.leg_length - knee.shank_length
    require(length > 0, "shank_length", "be less than leg_length", knee.shank_length)
    require(m < M, "shank_mass", f"be less than leg_mass, which is {M}", m)
    X, Y = params.com_along, params.com_across
    x, y = knee.shank_com_along, knee.shank_com_across
    along, across = (M * X - m * x) / (M - m), (M * Y - m * y) / (M - m)
    apart = m * M / (M - m) * ((x - X) ** 2 + (y - Y) ** 2)
    inertia = params.leg_inertia - knee.shank_inertia - apart
    require(
        inertia >= -ROUNDING * (params.leg_inertia + apart),
        "leg_inertia",
        "leave the thigh an inertia that is not negative; with this shank it must be at least "
        f"{knee.shank_inertia + apart}",
        params.leg_inertia,
    )
    return Thigh(length, M - m, along, across, max(inertia, 0.0))
