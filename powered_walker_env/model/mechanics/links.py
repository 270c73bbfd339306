"""The chains of links that a walker is: its joints locked, its ankle free, its swing knee free.

Here alone the geometry of the links is put together, for any number of walkers at once, and with
derivatives (`dual.py`).
"""

from __future__ import annotations

from typing import Any, NamedTuple

from powered_walker_env.compiled.decorators import small
from powered_walker_env.compiled.lanes import zero
from powered_walker_env.model.mechanics.constants import Constants
from powered_walker_env.model.mechanics.dual import choose, real, square, unit, value_of


class Chain(NamedTuple):
    """Links that move against each other, the first on a round foot; vectors at angle 0.

    Link k carries those after it. Its moment is Σ m r over all that it carries, r from its lower
    joint (of the first: the foot's centre), where what hangs on a later link counts at the joint.
    A link that does not exist has no lever and no moment, and an inertia of 1: it stands still.
    """

    lever1: complex  # m, to the next joint
    lever2: complex
    moment1: complex  # kg m
    moment2: complex
    moment3: complex
    inertia1: float  # kg m², about the lower joint; of the first with the foot's radius
    inertia2: float
    inertia3: float
    share3: float  # 1/inertia3, 1/(kg m²)
    roll: float  # kg m, mass times the foot's radius
    hip1: float  # q3 = Σ hip_k·angle_k + hip0
    hip2: float
    hip3: float
    hip0: float  # rad
    ankle: float  # 1 if the ankle moves, between links 1 and 2
    knee: float  # 1 if the knee moves, between links 2 and 3


class Chains(NamedTuple):
    """The chains that a walker can be."""

    locked: Any  # all joints but the hip locked
    free: Any  # the stance ankle free
    bent: Any  # the swing knee free; of a walker without knees the first


@small
def without_second(chain: Any) -> Chain:
    """A chain whose second link does not exist, said so that its numbers take a kernel no time."""
    return Chain(
        chain.lever1, zero(), chain.moment1, zero(), chain.moment3,
        chain.inertia1, 1.0, chain.inertia3, chain.share3, chain.roll,
        chain.hip1, zero(), chain.hip3, chain.hip0, zero(), zero(),
    )  # fmt: skip


def locked_chain(c: Constants) -> Chain:
    """Foot and stance leg as one link, then the swing leg; the angle of the first is φ.

    The swing leg is the third link: the second does not exist.
    """
    fold = unit(c.lock)  # from the leg's frame to the foot's: α = φ + lock
    hip = c.D + c.L * fold
    com = c.D + c.ankle_to_com * fold
    stance = c.I + c.M * (square(com) + square(hip) + 2.0 * c.R * c.R)
    return Chain(
        lever1=hip,
        lever2=0j,
        moment1=c.M * (com + hip),
        moment2=0j,
        inertia1=stance,
        inertia2=1.0,
        hip1=-1.0,
        hip2=0.0,
        hip0=-c.lock,
        ankle=0.0,
        knee=0.0,
        **_swing_leg(c),
    )


def free_chain(c: Constants) -> Chain:
    """Foot, stance leg and swing leg."""
    both = c.D * c.D + c.R * c.R
    return Chain(
        lever1=c.D + 0j,
        lever2=c.L + 0j,
        moment1=2.0 * c.M * c.D + 0j,
        moment2=c.M * (c.ankle_to_com + c.L),
        inertia1=2.0 * c.M * both,
        inertia2=c.I + c.M * (square(c.ankle_to_com) + c.L * c.L),
        hip1=0.0,
        hip2=-1.0,
        hip0=0.0,
        ankle=1.0,
        knee=0.0,
        **_swing_leg(c),
    )


def bent_chain(c: Constants, own: Any) -> Chain:
    """Foot and stance leg as one, then thigh and shank of the swing leg.

    The thigh is what the shank leaves of the leg: with a the shank's centre of mass from the
    knee, m its mass and d the thigh's length, the thigh's moment about the hip with the shank at
    the knee is the leg's less m a, and its inertia the leg's less the shank's about the knee and
    2 m ⟨d, a⟩.
    """
    locked, kneed = locked_chain(c), value_of(c.kneed)
    com = own.shank_length - own.shank_com_along - 1j * own.shank_com_across
    moment = own.shank_mass * com
    inertia = choose(kneed, own.shank_inertia + own.shank_mass * square(com), 1.0)
    thigh = locked.inertia3 - inertia - 2.0 * c.thigh * real(moment)
    return locked._replace(
        lever2=choose(kneed, c.thigh + 0j, locked.lever2),
        moment2=choose(kneed, locked.moment3 - moment, locked.moment2),
        moment3=choose(kneed, moment, locked.moment3),
        inertia2=choose(kneed, thigh, locked.inertia2),
        inertia3=choose(kneed, inertia, locked.inertia3),
        share3=choose(kneed, 1.0 / inertia, locked.share3),
        hip2=choose(kneed, 1.0, locked.hip2),
        hip3=choose(kneed, 0.0, locked.hip3),
        knee=choose(kneed, 1.0, locked.knee),
    )


def _swing_leg(c: Constants) -> dict[str, Any]:
    moment = c.swing_mass * c.hip_to_com
    inertia = c.swing_inertia + c.swing_mass * square(c.hip_to_com)
    roll = 2.0 * c.M * c.R
    return {
        "moment3": moment, "inertia3": inertia, "share3": 1.0 / inertia, "roll": roll, "hip3": 1.0
    }  # fmt: skip
