"""The two legs at an impact as bodies in the plane: places and velocities, no mass matrix.

Cartesian coordinates (n1, n2) about the spot where the feet are, with the velocities before
from the geometry of `derivation.py` and those after from rigid bodies: the new stance leg and its
foot turn about the new contact point, the trailing leg turns about the moving hip.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from powered_walker_env.model.walker import WalkerParams
from tests.helpers import derivation as d
from tests.helpers.derivation import Array
from tests.helpers.samples import relative


class Moving(NamedTuple):
    """The two legs at one instant: the new stance leg (`lead`) and the trailing one."""

    hip: Array
    lead: Array  # position of its centre of mass
    trail: Array
    hip_velocity: Array
    lead_velocity: Array
    trail_velocity: Array
    lead_rate: float
    trail_rate: float


def cross(a: Array, b: Array) -> float:
    """The n3 component of a × b."""
    return float(a[0] * b[1] - a[1] * b[0])


def spun(rate: float, arm: Array) -> Array:
    """rate n3 × arm."""
    return rate * np.array([-arm[1], arm[0]])


def before(y: Array, params: WalkerParams) -> tuple[Moving, Array]:
    """The walker just before the strike, and the new contact point under the swing foot."""
    position, velocity = d.kinematics(*relative(y), params)
    points = [d.HIP, d.SWING_LEG, d.STANCE_LEG]
    contact = position[d.SWING_CENTRE] - np.array([params.foot_radius, 0])
    return Moving(*position[points], *velocity[points], y[5], y[4]), contact


def after(walker: Moving, contact: Array, lead_rate: float, trail_rate: float) -> Moving:
    """The same walker with its new stance leg turning about the contact point."""
    hip_velocity = spun(lead_rate, walker.hip - contact)
    trail_velocity = hip_velocity + spun(trail_rate, walker.trail - walker.hip)
    lead_velocity = spun(lead_rate, walker.lead - contact)
    velocities = (hip_velocity, lead_velocity, trail_velocity)
    return Moving(*walker[:3], *velocities, lead_rate, trail_rate)


def momentum_about(contact: Array, walker: Moving, params: WalkerParams) -> float:
    """Angular momentum of both legs about the new contact point."""
    M, I = params.leg_mass, params.leg_inertia
    orbital = cross(walker.lead - contact, walker.lead_velocity)
    orbital += cross(walker.trail - contact, walker.trail_velocity)
    return I * (walker.lead_rate + walker.trail_rate) + M * orbital


def momentum_of_trailing_leg(walker: Moving, params: WalkerParams) -> float:
    """Angular momentum of the trailing leg about the hip."""
    orbital = cross(walker.trail - walker.hip, walker.trail_velocity)
    return params.leg_inertia * walker.trail_rate + params.leg_mass * orbital


def kinetic(walker: Moving, params: WalkerParams) -> float:
    linear = np.sum(walker.lead_velocity**2 + walker.trail_velocity**2)
    angular = walker.lead_rate**2 + walker.trail_rate**2
    return float(0.5 * params.leg_mass * linear + 0.5 * params.leg_inertia * angular)
