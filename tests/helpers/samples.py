"""Random walkers and states, far more general than the presets, for tests of laws."""

from __future__ import annotations

import cmath
import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from powered_walker_env.model.mechanics.chain import Pose, pose_of
from powered_walker_env.model.mechanics.constants import Constants
from powered_walker_env.model.mechanics.links import Chain
from powered_walker_env.model.mechanics.packing import chains_of, constants_of
from powered_walker_env.model.powering import MOTOR, SCHEMES, scheme_of
from powered_walker_env.model.presets import PRESETS
from powered_walker_env.model.walker import AS_PUBLISHED, CONSERVING, WalkerParams
from tests.helpers.derivation import TO_RELATIVE, Array

#: Presets that are powered, which environments take; those with Camp's motor; and the others.
POWERED = [name for name, preset in PRESETS.items() if preset.control is not None]
MOTORS = [name for name in POWERED if scheme_of(PRESETS[name].control) is MOTOR]
#: Names of the schemes that leave something to decide.
DECIDING = [name for name, known in SCHEMES.items() if known.control is not None]
PASSIVE = [name for name in PRESETS if name not in POWERED]


def constants(params: WalkerParams) -> Constants:
    """The walker as the kernels take it."""
    return constants_of(params)


def locked_chain(params: WalkerParams) -> Chain:
    """Its links with the ankle locked."""
    return chains_of(params).locked


def free_chain(params: WalkerParams) -> Chain:
    """Its links with the ankle free."""
    return chains_of(params).free


def pose(y: Any) -> Pose:
    """The pose (φ, α, β, φ', α', β') with its unit vectors."""
    return pose_of(*(float(number) for number in y))


def state_of(pose: Pose) -> Array:
    """The inverse of `pose`."""
    return np.array(pose[:6])


def as_published(params: WalkerParams) -> WalkerParams:
    """The same walker with the physics of the listing."""
    return params.replace(physics=AS_PUBLISHED)


def random_walker(rng: np.random.Generator, **fixed: Any) -> WalkerParams:
    """Round foot, inertia, off-axis centre of mass, slope: nothing is zero unless `fixed`."""
    length = rng.uniform(0.5, 2.0)
    fields: dict[str, Any] = {
        "leg_length": length,
        "foot_length": length * rng.uniform(0.05, 0.3),
        "foot_radius": length * rng.uniform(0.05, 0.5),
        "locked_ankle_angle": rng.uniform(-math.pi, math.pi),
        "leg_mass": 10 ** rng.uniform(-1, 3),
        "com_along": length * rng.uniform(0.2, 0.8),
        "com_across": length * rng.uniform(-0.2, 0.2),
        "gravity": rng.uniform(1.0, 20.0),
        "slope": rng.uniform(-0.3, 0.3),
        "no_load_speed": rng.uniform(1.0, 100.0),
        "physics": CONSERVING,
    }
    fields["leg_inertia"] = fields["leg_mass"] * (length * rng.uniform(0.1, 0.4)) ** 2
    return WalkerParams(**(fields | fixed))


def random_walkers(seed: int, number: int, **fixed: Any) -> Iterator[WalkerParams]:
    """`number` different walkers."""
    rng = np.random.default_rng(seed)
    for _ in range(number):
        yield random_walker(rng, **fixed)


def kneed(params: WalkerParams, rng: np.random.Generator) -> WalkerParams:
    """The same walker but for its leg, which is put together from a thigh and a shank."""
    thigh = params.leg_length * rng.uniform(0.3, 0.7)
    shank = params.leg_length - thigh
    masses = params.leg_mass * rng.dirichlet([2.0, 2.0, 1.0])

    def segment(name: str, length: float, mass: float) -> dict[str, float]:
        return {
            f"{name}_length": length,
            f"{name}_mass": mass,
            f"{name}_com_along": length * rng.uniform(0.2, 0.8),
            f"{name}_com_across": length * rng.uniform(-0.2, 0.2),
            f"{name}_inertia": mass * (length * rng.uniform(0.1, 0.4)) ** 2,
        }

    made = WalkerParams.from_kneed_leg(
        hip_mass=masses[0],
        **segment("thigh", thigh, masses[1]),
        **segment("shank", shank, masses[2]),
    )
    leg = ("leg_length", "leg_mass", "leg_inertia", "com_along", "com_across", "knee")
    return params.replace(**{name: getattr(made, name) for name in leg})


def kneed_walkers(seed: int, number: int, **fixed: Any) -> Iterator[WalkerParams]:
    """`number` different walkers with knees."""
    rng = np.random.default_rng(1000 + seed)
    for params in random_walkers(seed, number, **fixed):
        yield kneed(params, rng)


def sprung(params: WalkerParams, rng: np.random.Generator) -> WalkerParams:
    """The same walker with a spring between its legs, up to MgL per radian."""
    weight = params.leg_mass * params.gravity
    return params.replace(hip_stiffness=weight * params.leg_length * rng.uniform(0.1, 1.0))


def random_motion(rng: np.random.Generator) -> Array:
    """(φ, α, β, φ', α', β') anywhere."""
    return np.concatenate([rng.uniform(-math.pi, math.pi, 3), rng.uniform(-3.0, 3.0, 3)])


def locked_motion(rng: np.random.Generator, params: WalkerParams) -> Array:
    """The same with the ankle at its stop, at rest."""
    y = random_motion(rng)
    y[0], y[3] = y[1] - params.locked_ankle_angle, y[4]
    return y


def relative(y: Array) -> tuple[Array, Array]:
    """The thesis's (q1, q2, q3) and (u1, u2, u3) of an absolute state."""
    return TO_RELATIVE @ y[:3], TO_RELATIVE @ y[3:]


def landing_state(rng: np.random.Generator, params: WalkerParams, *, locked: bool = False) -> Array:
    """A state in which the swing foot touches flat ground ahead of the stance foot.

    Stance leg and foot are drawn, the swing leg's angle β solves zero clearance,
    D cos φ + L cos α + |K| cos(β + arg K) = 0 with K = L + D e^{−i·lock}.
    """
    L, D, lock = params.leg_length, params.foot_length, params.locked_ankle_angle
    leg = L + D * cmath.exp(-1j * lock)
    while True:
        y = random_motion(rng)
        y[1] = rng.uniform(-0.2, 0.8)
        y[0] = y[1] - lock if locked else rng.uniform(-math.pi, math.pi)
        if locked:
            y[3] = y[4]
        height = (D * math.cos(y[0]) + L * math.cos(y[1])) / abs(leg)
        if abs(height) >= 1:
            continue
        y[2] = math.pi - math.acos(height) - cmath.phase(leg)
        if -1.0 < y[2] - math.pi < y[1] - 0.05:  # the other root has the legs together
            return y


def derivative(function: Any, y: Array, direction: Array) -> float:
    """Derivative along `direction` by the five-point stencil.

    Over a thousandth of a radian its truncation (h⁴/30 of a fifth derivative) and its
    rounding (1e-16/h) are both about 1e-13 for functions of order one.
    """
    h = 1e-3 / float(np.abs(direction).max())
    near = function(y + h * direction) - function(y - h * direction)
    far = function(y + 2 * h * direction) - function(y - 2 * h * direction)
    return float((8 * near - far) / (12 * h))


def scheme_arguments(name: str) -> dict[str, Any]:
    """Arguments of an environment with that scheme, all JSON-able."""
    for preset, known in PRESETS.items():
        if scheme_of(known.control).name == name:
            return {"preset": preset}
    walker = PRESETS["toe-off"]  # whenever the push comes, the gait is the same
    return {
        "params": walker.params.to_dict(),
        "scheme": name,
        "control": [0.1],
        "gait": list(walker.state),
    }
