"""Legs put together from their parts, by the parallel-axis theorem.

Every part has a mass, a place on the leg and an inertia about its own centre of mass. Places are
complex: along the leg from the ankle + i·across it, forward positive on the stance leg.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

from powered_walker_env.model.checks import real_number, require
from powered_walker_env.model.knee import Knee


class Part(NamedTuple):
    """A rigid piece of a leg."""

    mass: float  # kg
    place: complex  # m, of its centre of mass
    inertia: float = 0.0  # kg m², about that


def together(parts: Sequence[Part]) -> Part:
    """Several parts as one."""
    mass = sum(part.mass for part in parts)
    place = sum(part.mass * part.place for part in parts) / mass
    inertia = sum(part.inertia + part.mass * abs(part.place - place) ** 2 for part in parts)
    return Part(mass, place, inertia)


def composite_leg(
    *,
    hip_mass: float,
    frame_mass: float = 0.0,
    foot_mass: float = 0.0,
    leg_length: float = 1.0,
    frame_com_along: float | None = None,
    frame_com_across: float = 0.0,
    frame_inertia: float | None = None,
    **fields: Any,
) -> dict[str, Any]:
    """Fields of `WalkerParams` for a leg of a hip mass, a frame and a foot mass at the ankle.

    (The listing's `init.m` does the same, but takes the frame's inertia for m L / 12 and
    drops the offsets across the leg; its figures have no frame, so they are right.)

    Args:
        hip_mass: one leg's share of the hip, kg, at the hip.
        frame_mass: kg, spread along the leg.
        foot_mass: kg, at the ankle.
        leg_length: m, ankle to hip.
        frame_com_along: m from the ankle; the middle of the leg if left out.
        frame_com_across: m across the leg.
        frame_inertia: kg m² about the frame's centre; a uniform rod's, m L²/12, if left out.
        **fields: any other field of `WalkerParams`.

    Raises:
        ValueError: a negative mass or inertia, or no mass at all.
    """
    length = real_number("leg_length", leg_length)
    hip, foot = _mass("hip_mass", hip_mass), _mass("foot_mass", foot_mass)
    frame = _segment("frame", frame_mass, length, frame_com_along, frame_com_across, frame_inertia)
    mass = hip + frame.mass + foot
    require(mass > 0, "hip_mass + frame_mass + foot_mass", "be positive", mass)
    leg = together([Part(hip, complex(length)), frame, Part(foot, 0j)])
    return {**_fields(length, leg), **fields}


def kneed_leg(
    *,
    hip_mass: float,
    thigh_mass: float,
    shank_mass: float,
    foot_mass: float = 0.0,
    thigh_length: float = 0.5,
    shank_length: float = 0.5,
    thigh_com_along: float | None = None,
    thigh_com_across: float = 0.0,
    thigh_inertia: float | None = None,
    shank_com_along: float | None = None,
    shank_com_across: float = 0.0,
    shank_inertia: float | None = None,
    **fields: Any,
) -> tuple[dict[str, Any], Knee]:
    """Fields of `WalkerParams`, and the knee, for a leg of hip mass, thigh, shank and foot mass.

    Args:
        hip_mass: one leg's share of the hip, kg, at the hip.
        thigh_mass, shank_mass: kg.
        foot_mass: kg, at the ankle, turning with the shank.
        thigh_length: m, knee to hip; shank_length: m, ankle to knee.
        thigh_com_along, shank_com_along: m from the knee and from the ankle; the middle if left
            out.
        thigh_com_across, shank_com_across: m across the leg, forward positive on the stance leg.
        thigh_inertia, shank_inertia: kg m² about their centres; a uniform rod's if left out.
        **fields: any other field of `WalkerParams`.

    Raises:
        ValueError: a negative mass or inertia, a segment without length.
    """
    above, below = (
        real_number("thigh_length", thigh_length),
        real_number("shank_length", shank_length),
    )
    require(above > 0, "thigh_length", "be positive", above)
    require(below > 0, "shank_length", "be positive", below)
    thigh = _segment("thigh", thigh_mass, above, thigh_com_along, thigh_com_across, thigh_inertia)
    shank = _segment("shank", shank_mass, below, shank_com_along, shank_com_across, shank_inertia)
    foot = Part(_mass("foot_mass", foot_mass), 0j)
    require(shank.mass + foot.mass > 0, "shank_mass + foot_mass", "be positive", shank.mass)
    lower = together([shank, foot])
    raised = thigh._replace(place=below + thigh.place)
    hip = Part(_mass("hip_mass", hip_mass), complex(above + below))
    leg = together([hip, raised, lower])
    knee = Knee(
        shank_length=below,
        shank_mass=lower.mass,
        shank_com_along=lower.place.real,
        shank_com_across=lower.place.imag,
        shank_inertia=lower.inertia,
    )
    return {**_fields(above + below, leg), **fields}, knee


def _fields(length: float, leg: Part) -> dict[str, Any]:
    return {
        "leg_length": length,
        "leg_mass": leg.mass,
        "leg_inertia": leg.inertia,
        "com_along": leg.place.real,
        "com_across": leg.place.imag,
    }


def _mass(name: str, value: float) -> float:
    mass = real_number(name, value)
    require(mass >= 0, name, "not be negative", mass)
    return mass


def _segment(
    name: str,
    mass: float,
    length: float,
    along: float | None,
    across: float,
    inertia: float | None,
) -> Part:
    """A part that is spread along a length; what is left out is a uniform rod's."""
    heavy = _mass(f"{name}_mass", mass)
    middle = real_number(f"{name}_com_along", 0.5 * length if along is None else along)
    aside = real_number(f"{name}_com_across", across)
    rod = heavy * length**2 / 12
    spin = real_number(f"{name}_inertia", rod if inertia is None else inertia)
    require(spin >= 0, f"{name}_inertia", "not be negative", spin)
    return Part(heavy, complex(middle, aside), spin)
