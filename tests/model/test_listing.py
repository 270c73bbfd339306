"""The heel strike of the thesis's listing (Appendix C), and where it departs from the text.

`listed_strike` states the equations of `mom.m` and `pow_jump.m` in the thesis's relative
angles, with the distance to the new contact point and the mass matrix as arguments, so
that each departure can be made alone:

1. the distance to the new contact point has L sin β with the wrong sign;
2. the mass matrix is that of the configuration before the strike.

The third departure is the motor's (`test_actuation.py`).
"""

from __future__ import annotations

import cmath
import math
from typing import Any

import numpy as np
import pytest

from powered_walker_env.model.mechanics.chain import kinetic_energy
from powered_walker_env.model.mechanics.heel_strike import heel_strike, new_contact
from powered_walker_env.model.walker import AS_PUBLISHED, CONSERVING, WalkerParams
from tests.helpers import derivation
from tests.helpers.derivation import TO_ABSOLUTE, Array
from tests.helpers.published import limit_cycle
from tests.helpers.samples import (
    as_published,
    constants,
    free_chain,
    landing_state,
    pose,
    random_walkers,
    relative,
    state_of,
)

PUBLISHED_GAIT = limit_cycle(AS_PUBLISHED, 692)


def listed_momenta(q: Array, u: Array, reach: float, p: WalkerParams) -> Array:
    """`mom.m`: momenta about a contact point `reach` ahead, and of the trailing leg at the hip."""
    L, D, R, M, I = p.leg_length, p.foot_length, p.foot_radius, p.leg_mass, p.leg_inertia
    XA, XB, Y = p.com_along, p.leg_length - p.com_along, p.com_across
    (q1, q2, q3), (u1, u2, u3) = q, u
    cos, sin = math.cos, math.sin
    q12, q23, q123 = q1 + q2, q2 + q3, q1 + q2 + q3

    hip = (I - M * (XA * XB - Y**2)) * (u1 + u2)
    hip -= M * D * (XB * cos(q2) + Y * sin(q2)) * u1
    hip -= M * R * (XB * cos(q12) + Y * sin(q12)) * u1

    foot = D * (2 * D + (L + XA) * cos(q2) + 2 * R * cos(q1) - Y * sin(q2) - 2 * reach * sin(q1))
    foot += D * (XB * cos(q23) + Y * sin(q23))
    foot += R * (2 * R + 2 * D * cos(q1) + (L + XA) * cos(q12) - Y * sin(q12))
    foot += R * (XB * cos(q123) + Y * sin(q123))
    stance = L * (L + D * cos(q2) + XB * cos(q3) + Y * sin(q3) + R * cos(q12) - reach * sin(q12))
    stance += XA**2 + Y**2 + D * (XA * cos(q2) - Y * sin(q2)) + R * (XA * cos(q12) - Y * sin(q12))
    stance -= reach * (XA * sin(q12) + Y * cos(q12))
    swing = XB**2 + Y**2 + L * (XB * cos(q3) + Y * sin(q3)) + D * (XB * cos(q23) + Y * sin(q23))
    swing += R * (XB * cos(q123) + Y * sin(q123)) - reach * (XB * sin(q123) - Y * cos(q123))
    walker = M * foot * u1 + (I + M * stance) * (u1 + u2) + (I + M * swing) * (u1 + u2 + u3)
    return np.array([walker, hip])


def reach(q: Array, p: WalkerParams, *, departure: bool) -> float:
    """Distance forward to the new contact point; the departure turns L sin(q1 + q2 + q3)."""
    L, D, lock = p.leg_length, p.foot_length, p.locked_ankle_angle
    swing = q[0] + q[1] + q[2]
    leg = -L * math.sin(swing) if departure else L * math.sin(swing)
    return D * math.sin(q[0]) + L * math.sin(q[0] + q[1]) + leg + D * math.sin(swing - lock)


def listed_strike(y: Array, p: WalkerParams, *, first: bool, second: bool) -> Array:
    """(φ', α', β') after the strike, with departure 1, departure 2, both or neither."""
    q, u = relative(y)
    momenta = listed_momenta(q, u, reach(q, p, departure=first), p)
    after = np.array([q.sum() - p.locked_ankle_angle - math.pi, p.locked_ankle_angle, -q[2]])
    configuration = q if second else after
    matrix, _ = derivation.locked_system(configuration, np.zeros(3), p)
    u1, u3 = np.linalg.solve(matrix, momenta)
    return np.array([u1, u1, u1 + u3])


def rates(y: Array, params: WalkerParams) -> Any:
    """(φ', α', β') after the package's heel strike."""
    return state_of(heel_strike(pose(y), free_chain(params), constants(params)))[3:]


def before_strike(cycle: Any) -> Array:
    q, u = np.array(cycle.pre_heelstrike[:3]), np.array(cycle.pre_heelstrike[3:])
    return np.concatenate([TO_ABSOLUTE @ q, TO_ABSOLUTE @ u])


def symmetric_walker(rng: np.random.Generator, params: WalkerParams) -> WalkerParams:
    """The same walker with its centre of mass on the line from foot to hip."""
    L, D, lock = params.leg_length, params.foot_length, params.locked_ankle_angle
    foot = D * cmath.exp(-1j * lock)  # ankle from foot, in the leg's frame
    centre = rng.uniform(0.2, 0.8) * (L + foot) - foot
    return params.replace(com_along=centre.real, com_across=centre.imag)


def test_as_published_strike_is_the_listings() -> None:
    rng = np.random.default_rng(1)
    for params in random_walkers(1, 200):
        y = landing_state(rng, params)
        expected = listed_strike(y, params, first=True, second=True)
        scale = np.abs(expected).max()
        assert rates(y, as_published(params)) == pytest.approx(expected, abs=5e-14 * scale)


def test_listing_without_its_two_departures_is_the_conserving_strike() -> None:
    rng = np.random.default_rng(2)
    for params in random_walkers(2, 200):
        y = landing_state(rng, params)
        expected = listed_strike(y, params, first=False, second=False)
        scale = np.abs(expected).max()
        assert rates(y, params) == pytest.approx(expected, abs=5e-14 * scale)


def test_departure_1_moves_the_new_contact_point_by_minus_2_L_sin_beta() -> None:
    rng = np.random.default_rng(3)
    for params in random_walkers(3, 100):
        y = landing_state(rng, params)
        right = new_contact(pose(y), constants(params))
        listed = new_contact(pose(y), constants(as_published(params)))
        q, _ = relative(y)
        assert listed - right == pytest.approx(-2j * params.leg_length * math.sin(y[2]), abs=1e-14)
        assert right.imag == pytest.approx(reach(q, params, departure=False), abs=1e-14)
        assert listed.imag == pytest.approx(reach(q, params, departure=True), abs=1e-14)


def test_departure_1_puts_the_new_contact_of_a_symmetric_step_on_the_old_one() -> None:
    """Exactly so without a foot; with one, for all the step's length, within two feet of it."""
    for D in (0.0, 0.1):
        walker = WalkerParams(foot_length=D, foot_radius=0.3, locked_ankle_angle=math.pi)
        for angle in (0.1, 0.3, 0.5):
            y = (angle - math.pi, angle, math.pi - angle, 0.0, 0.0, 0.0)
            step = new_contact(pose(y), constants(walker)).imag
            assert step == pytest.approx(2 * (1 - D) * math.sin(angle), rel=1e-14)
            listed = new_contact(pose(y), constants(as_published(walker)))
            assert listed == pytest.approx(-2j * D * math.sin(angle), abs=1e-15)


def test_departure_1_alone_explains_the_listing_where_both_feet_are_locked() -> None:
    """And departure 2 changes nothing there: both configurations have one mass matrix."""
    rng = np.random.default_rng(4)
    differ = 0
    for plain in random_walkers(4, 100):
        params = symmetric_walker(rng, plain)
        y = landing_state(rng, params, locked=True)
        neither = listed_strike(y, params, first=False, second=False)
        second = listed_strike(y, params, first=False, second=True)
        assert second == pytest.approx(neither, abs=5e-14 * np.abs(neither).max())
        first = listed_strike(y, params, first=True, second=False)
        scale = np.abs(first).max()
        assert rates(y, as_published(params)) == pytest.approx(first, abs=5e-14 * scale)
        differ += bool(np.abs(first - neither).max() > 0.01 * scale)
    assert differ > 90  # in the rest the new stance leg lands near upright (sin β near 0)


def test_departure_2_matters_where_the_stance_foot_is_extended() -> None:
    y = before_strike(PUBLISHED_GAIT)
    params = PUBLISHED_GAIT.params
    both = listed_strike(y, params, first=True, second=True)
    first = listed_strike(y, params, first=True, second=False)
    assert rates(y, params) == pytest.approx(both, rel=1e-12)
    assert abs(first[2] - both[2]) > 0.05 * abs(both[2])


def test_published_gait_keeps_92_percent_of_its_energy_but_36_where_momentum_is_kept() -> None:
    y = before_strike(PUBLISHED_GAIT)

    def kept(params: WalkerParams) -> float:
        c, chain = constants(params), free_chain(params)
        struck = heel_strike(pose(y), chain, c)
        return float(kinetic_energy(struck, chain, c) / kinetic_energy(pose(y), chain, c))

    assert kept(PUBLISHED_GAIT.params) == pytest.approx(0.92, abs=0.005)
    conserving = PUBLISHED_GAIT.params.replace(physics=CONSERVING)
    assert kept(conserving) == pytest.approx(0.36, abs=0.005)
