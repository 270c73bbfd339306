"""The numbers that kernels need of a walker, from `WalkerParams`: one row of floats.

A row has the walker's own numbers, what follows from them (`Constants`), and the chains of links
that it is (`Chains`): its joints locked, its ankle free, its swing knee free. Here alone the
geometry is put together, for any number of walkers at once, and with derivatives (`dual.py`).
"""

from __future__ import annotations

import functools
from collections.abc import Sequence
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from powered_walker_env.compiled.records import Layout
from powered_walker_env.model.knee import Knee
from powered_walker_env.model.mechanics.dual import (
    Dual,
    choose,
    conjugate,
    length,
    real,
    square,
    tangent_of,
    unit,
    value_of,
)
from powered_walker_env.model.quantities import quantities
from powered_walker_env.model.walker import AS_PUBLISHED, CONSERVING, WalkerParams

Array = NDArray[np.float64]

#: Names of the walker's own numbers, in the order in which they begin its row.
NUMBERS = (*quantities(WalkerParams), *quantities(Knee), "as_published")
OWN = len(NUMBERS)
LEG_LENGTH, LEG_MASS, GRAVITY = (NUMBERS.index(n) for n in ("leg_length", "leg_mass", "gravity"))


class Constants(NamedTuple):
    """The walker as the formulas see it; symbols as in Camp 1997, Appendix A."""

    L: float  # m, ankle to hip
    D: float  # m, ankle to the centre of the foot
    R: float  # m, radius of the foot
    lock: float  # rad, ankle angle q2 at the stop
    M: float  # kg, one leg
    I: float  # kg m², one leg about its centre of mass
    ankle_to_com: complex  # m, X + iY: leg's centre of mass from the ankle, leg frame
    hip_to_com: complex  # m, L − X − iY: the same from the hip, on the swing leg
    swing_mass: float  # kg, M; in the limit of a massless foot 1
    swing_inertia: float  # kg m², I; in that limit 0
    reaction: float  # 1; in that limit 0: the swing leg does not pull at the rest
    g: complex  # m/s², gravity·e^{−i·slope}: minus the gravitational acceleration
    retracted: complex  # m, D e^{−i·lock}: the foot's centre from the ankle, swing leg's frame
    reach: float  # m, |K| with K = L + D e^{−i·lock}: from the hip to the foot's centre
    lean: complex  # K/|K|
    kneed: bool  # whether the swing leg has a knee
    thigh: float  # m, from the hip to the knee; without a knee the whole leg, L
    shank: complex  # m, from the knee to the swing foot's centre, on the swing leg
    hip_stiffness: float  # N m/rad
    no_load_speed: float  # rad/s
    droop: float  # s/rad, of the motor's torque with the ankle's rate u2: ±1/ω_noload
    torque_limit: float  # N m, of the motor; infinite for none
    as_published: bool  # the thesis's listing instead of its text


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


CONSTANTS, CHAIN = Layout(Constants), Layout(Chain)
CONSTANTS_SIZE, CHAIN_SIZE = CONSTANTS.size, CHAIN.size
#: Where the parts of a row begin.
LOCKED_CHAIN = OWN + CONSTANTS_SIZE
FREE_CHAIN, BENT_CHAIN = LOCKED_CHAIN + CHAIN_SIZE, LOCKED_CHAIN + 2 * CHAIN_SIZE
ROW = BENT_CHAIN + CHAIN_SIZE


def constants_from(own: Any) -> Constants:
    """What follows from a walker's own numbers, given by name: floats, arrays or `Dual`s."""
    L, D, M, I = own.leg_length, own.foot_length, own.leg_mass, own.leg_inertia
    X, Y, lock = own.com_along, own.com_across, own.locked_ankle_angle
    inertia, x, y = value_of(I), value_of(X), value_of(Y)
    massless = (inertia == 0.0) & (x == value_of(L)) & (y == 0.0)
    as_published = value_of(own.as_published) != 0.0
    com = X + 1j * Y
    retracted = D * conjugate(unit(lock))
    arm = L + retracted
    size = length(arm)
    point = value_of(size) == 0.0  # the foot's centre at the hip: no lean
    limit = value_of(own.torque_limit)
    kneed = value_of(own.shank_length) > 0.0
    return Constants(
        L=L,
        D=D,
        R=own.foot_radius,
        lock=lock,
        M=M,
        I=I,
        ankle_to_com=com,
        hip_to_com=choose(massless, L + 0j, L - com),
        swing_mass=choose(massless, 1.0, M),
        swing_inertia=I,
        reaction=choose(massless, 0.0, 1.0),
        g=own.gravity * unit(-own.slope),
        retracted=retracted,
        reach=size,
        lean=choose(point, 1.0 + 0j, arm / choose(point, 1.0, size)),
        kneed=kneed,
        thigh=L - own.shank_length,
        shank=own.shank_length + retracted,
        hip_stiffness=own.hip_stiffness,
        no_load_speed=own.no_load_speed,
        # The listing (`pow_qddt.m`) has a motor that pushes harder the faster it turns.
        droop=np.where(as_published, -1.0, 1.0) / own.no_load_speed,
        torque_limit=choose(limit > 0.0, own.torque_limit, np.inf),
        as_published=as_published,
    )


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


def own_numbers(params: WalkerParams) -> list[float]:
    """A walker's own numbers, in the order of `NUMBERS`."""
    own = [getattr(params, name) for name in quantities(WalkerParams)]
    knee = [0.0 if params.knee is None else getattr(params.knee, n) for n in quantities(Knee)]
    return [*own, *knee, float(params.physics == AS_PUBLISHED)]


def rows_from_own(own: Array) -> Array:
    """(N, ROW) the rows of walkers from their own numbers, (N, OWN)."""
    numbers = SimpleNamespace(**dict(zip(NUMBERS, own.T, strict=True)))
    return np.ascontiguousarray(np.hstack([own, _derived(numbers, value_of)]))


def row_tangents(own: Array, change: Array) -> Array:
    """(N, ROW) derivatives of the rows of walkers along a change of their own numbers, (OWN,)."""
    if not change.any():
        return np.zeros((len(own), ROW))
    moved = {
        name: Dual(number, np.full(len(own), part))
        for name, number, part in zip(NUMBERS, own.T, change, strict=True)
    }
    tangents = _derived(SimpleNamespace(**moved), tangent_of)
    return np.ascontiguousarray(np.hstack([np.tile(change, (len(own), 1)), tangents]))


def _derived(own: SimpleNamespace, part: Any) -> Array:
    count = len(value_of(own.leg_length))
    with np.errstate(all="ignore"):  # of walkers that no kernel can walk either
        c = constants_from(own)
        chains = Chains(locked_chain(c), free_chain(c), bent_chain(c, own))
        records: list[tuple[Layout[Any], Any]] = [(CONSTANTS, c), *((CHAIN, x) for x in chains)]
        columns = [
            column if np.ndim(column) else np.full(count, column)
            for layout, record in records
            for column in layout.columns([part(value) for value in record])
        ]
    return np.stack(columns, axis=1)


def pack_all(walkers: Sequence[WalkerParams]) -> Array:
    """(N, ROW) the rows of N walkers."""
    return rows_from_own(np.array([own_numbers(params) for params in walkers]))


@functools.lru_cache(maxsize=256)
def packed(params: WalkerParams) -> Array:
    """(1, ROW) the walker's row; everybody's, not to be written to."""
    return pack_all([params])


def pack(params: WalkerParams) -> Array:
    """(ROW,) the walker's row."""
    return packed(params)[0].copy()


def params_of(row: Array) -> WalkerParams:
    """The inverse of `pack`."""
    *numbers, as_published = row[:OWN].tolist()
    known = dict(zip(NUMBERS[:-1], numbers, strict=True))
    knee = {name: known.pop(name) for name in quantities(Knee)}
    return WalkerParams(
        **known,
        knee=Knee(**knee) if knee["shank_length"] else None,
        physics=AS_PUBLISHED if as_published else CONSERVING,
    )


def constants_of(params: WalkerParams) -> Constants:
    """The walker as the formulas take it."""
    return CONSTANTS.of(pack(params)[OWN:LOCKED_CHAIN])


def chains_of(params: WalkerParams) -> Chains:
    """The walker's chains."""
    row = pack(params)
    return Chains(*(CHAIN.of(row[first:]) for first in (LOCKED_CHAIN, FREE_CHAIN, BENT_CHAIN)))
