"""The chain of links: both modes against Kane's method, and the laws that their solutions keep."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from powered_walker_env.model.mechanics import chain, locking
from powered_walker_env.model.walker import WalkerParams
from tests.helpers import derivation
from tests.helpers.derivation import TO_ABSOLUTE, TO_RELATIVE, Array
from tests.helpers.samples import (
    constants,
    free_chain,
    locked_chain,
    pose,
    random_motion,
    random_walkers,
    relative,
    sprung,
)

THESIS = WalkerParams(slope=0.01)
REVERSED = np.array([1.0, 1, 1, -1, -1, -1])


def draws(seed: int, number: int = 100) -> Iterator[tuple[WalkerParams, Array, float]]:
    """Walkers (the thesis's among them), motions, and torques like the leg's weight times L."""
    rng = np.random.default_rng(seed)
    for params in [THESIS] * 20 + list(random_walkers(seed, number)):
        torque = rng.uniform(-1, 1) * params.leg_mass * params.gravity * params.leg_length
        yield params, random_motion(rng), torque


def hip_draws(seed: int) -> Iterator[tuple[WalkerParams, Array, float, float]]:
    """The same with springs between the legs, and a torque at the hip as large as the ankle's."""
    rng = np.random.default_rng(1000 + seed)
    for params, y, torque in draws(seed):
        yield sprung(params, rng), y, torque, rng.uniform(-1, 1) * abs(torque)


def at_rest_in_the_ankle(y: Array, params: WalkerParams) -> Array:
    """The same motion with the ankle at its stop."""
    alpha, dalpha = y[1], y[4]
    return np.array([alpha - params.locked_ankle_angle, *y[1:3], dalpha, dalpha, y[5]])


def locked_draws(seed: int) -> Iterator[tuple[WalkerParams, Array, float, float]]:
    """Those with a hip, their ankles locked."""
    for params, y, torque, hip in hip_draws(seed):
        yield params, at_rest_in_the_ankle(y, params), torque, hip


def square(m: chain.Mass) -> Array:
    """The whole matrix from its upper triangle."""
    return np.array([[m.m11, m.m12, m.m13], [m.m12, m.m22, m.m23], [m.m13, m.m23, m.m33]])


def mass_matrix(y: Array, params: WalkerParams) -> Array:
    return square(chain.mass_matrix_at(pose(y), free_chain(params), constants(params)))


def bias(y: Array, params: WalkerParams) -> Array:
    at, c = pose(y), constants(params)
    coupled = chain.couplings(at.foot, at.stance, at.swing, free_chain(params), c)
    return np.array(chain.bias(coupled, *y[3:], free_chain(params), c))


def free(y: Array, torque: float, params: WalkerParams, hip: float = 0.0) -> Array:
    """(φ'', α'', β'') with the ankle free."""
    return np.array(chain.accelerations(y, torque, hip, free_chain(params), constants(params)))


def locked(y: Array, params: WalkerParams, hip: float = 0.0, torque: float = 0.0) -> Array:
    """(α'', β'') with the ankle locked; what of y is not the chain's is not used."""
    of_chain = (y[0], 0.0, y[2], y[3], 0.0, y[5])
    first, none, last = chain.accelerations(
        of_chain, torque, hip, locked_chain(params), constants(params)
    )
    assert none == 0.0
    return np.array([first, last])


def assert_close(ours: Any, theirs: Any, tolerance: float) -> None:
    """Two vectors differ by less than `tolerance` of the second one's length."""
    assert np.linalg.norm(np.subtract(ours, theirs)) <= tolerance * np.linalg.norm(theirs)


def test_mass_matrix_and_bias_are_those_of_kanes_method() -> None:
    for params, y, torque in draws(1):
        matrix, forcing = derivation.powered_system(*relative(y), torque, params)
        assert_close(mass_matrix(y, params), TO_RELATIVE.T @ matrix @ TO_RELATIVE, 1e-14)
        forces = torque * np.array([1, -1, 0])
        assert_close(forces - bias(y, params), TO_RELATIVE.T @ forcing, 2e-14)


def test_free_accelerations_are_those_of_kanes_method() -> None:
    for params, y, torque in draws(2):
        matrix, forcing = derivation.powered_system(*relative(y), torque, params)
        rounding = 1e-15 * np.linalg.cond(matrix)  # of a linear solution; below 1e-11 but for
        expected = TO_ABSOLUTE @ np.linalg.solve(matrix, forcing)  # the thesis's short foot
        assert_close(free(y, torque, params), expected, rounding)


def test_free_accelerations_with_a_hip_spring_and_a_hip_torque_are_those_of_kanes_method() -> None:
    for params, y, torque, hip in hip_draws(2):
        matrix, forcing = derivation.powered_system(*relative(y), torque, params, hip)
        rounding = 1e-15 * np.linalg.cond(matrix)
        expected = TO_ABSOLUTE @ np.linalg.solve(matrix, forcing)
        assert_close(free(y, torque, params, hip), expected, rounding)


def test_locked_accelerations_with_a_hip_spring_and_a_hip_torque_are_those_of_kanes() -> None:
    for params, y, _, hip in locked_draws(3):
        q, u = relative(y)
        du1, du3 = np.linalg.solve(*derivation.locked_system(q, u, params, hip))
        assert_close(locked(y, params, hip), (du1, du1 + du3), 5e-14)


def test_locked_accelerations_are_those_of_kanes_method() -> None:
    for params, motion, _ in draws(3):
        y = at_rest_in_the_ankle(motion, params)
        q, u = relative(y)
        du1, du3 = np.linalg.solve(*derivation.locked_system(q, u, params))
        assert_close(locked(y, params), (du1, du1 + du3), 5e-14)


def test_kinetic_energy_is_half_m_v_squared_of_the_centres_of_mass_and_their_spin() -> None:
    for params, y, _ in draws(4):
        expected = derivation.energies(*relative(y), params)
        kinetic = chain.kinetic_energy(pose(y), free_chain(params), constants(params))
        assert kinetic == pytest.approx(expected.kinetic, rel=1e-14)


def test_potential_energy_is_the_weight_times_the_height_against_gravity() -> None:
    for params, y, _ in draws(5):
        scale = params.leg_mass * params.gravity * params.leg_length
        expected = derivation.energies(*relative(y), params)
        potential = chain.potential_energy(pose(y), free_chain(params), constants(params))
        assert potential == pytest.approx(expected.potential, abs=1e-14 * scale)
        total = chain.energy(pose(y), free_chain(params), constants(params))
        both = expected.kinetic + expected.potential
        assert total == pytest.approx(both, rel=1e-14, abs=1e-14 * scale)


def test_mass_matrix_is_positive_definite() -> None:
    for params, y, _ in draws(6):
        assert np.linalg.eigvalsh(mass_matrix(y, params))[0] > 0


def test_energy_grows_at_the_rate_of_the_torques_power_along_the_free_flow() -> None:
    for params, y, torque in draws(7):
        q, u = relative(y)
        acceleration = TO_RELATIVE @ free(y, torque, params)
        terms = derivation.energies(q, u, params).gradient * np.concatenate([u, acceleration])
        power = torque * (y[3] - y[4])  # on the foot forward, on the leg back
        assert terms.sum() == pytest.approx(power, abs=1e-14 * np.abs(terms).sum())


def test_energy_with_a_hip_spring_grows_at_the_rate_of_both_torques_power() -> None:
    for params, y, torque, hip in hip_draws(7):
        q, u = relative(y)
        expected = derivation.energies(q, u, params)
        scale = params.leg_mass * params.gravity * params.leg_length
        total = chain.energy(pose(y), free_chain(params), constants(params))
        both = expected.kinetic + expected.potential
        assert total == pytest.approx(both, rel=2e-14, abs=2e-14 * scale)
        acceleration = TO_RELATIVE @ free(y, torque, params, hip)
        terms = expected.gradient * np.concatenate([u, acceleration])
        power = torque * (y[3] - y[4]) + hip * (y[5] - y[4])
        assert terms.sum() == pytest.approx(power, abs=1e-14 * np.abs(terms).sum())


def test_hip_spring_is_slack_with_the_legs_together_and_pulls_them_together_otherwise() -> None:
    params = THESIS.replace(hip_stiffness=50.0)
    for alpha, apart in ((0.3, 0.0), (0.3, 0.4), (-0.2, -0.5)):
        y = (alpha - 2.0, alpha, alpha + math.pi + apart, 0.0, 0.0, 0.0)
        bend = chain.hip_bend(*y[:3], free_chain(params))
        assert bend == pytest.approx(apart, abs=1e-15)
        pull, slack = free(y, 0.0, params), free(y, 0.0, params.replace(hip_stiffness=0.0))
        expected = free(y, 0.0, params.replace(hip_stiffness=0.0), -50.0 * apart)
        assert pull == pytest.approx(expected, abs=1e-12 * np.abs(expected).max())
        assert (np.abs(pull - slack).max() > 1.0) == (apart != 0.0)
        stopped = (alpha - params.locked_ankle_angle, 0.0, y[2])
        assert chain.hip_bend(*stopped, locked_chain(params)) == pytest.approx(apart, abs=1e-15)


def test_energy_is_kept_along_the_locked_flow() -> None:
    for params, motion, _ in draws(8):
        y = at_rest_in_the_ankle(motion, params)
        q, u = relative(y)
        ddalpha, ddbeta = locked(y, params)
        flow = np.concatenate([u, [ddalpha, 0, ddbeta - ddalpha]])
        terms = derivation.energies(q, u, params).gradient * flow
        assert terms.sum() == pytest.approx(0, abs=1e-14 * np.abs(terms).sum())


def test_mirrored_walker_moves_as_its_mirror_image() -> None:
    for params, y, torque in draws(10):
        image = params.replace(
            com_across=-params.com_across,
            slope=-params.slope,
            locked_ankle_angle=-params.locked_ankle_angle,
        )
        assert_close(free(-y, -torque, image), -free(y, torque, params), 1e-15)
        assert_close(locked(-y, image), -locked(y, params), 1e-15)


def test_motion_run_backwards_has_the_same_accelerations() -> None:
    for params, y, torque, hip in hip_draws(11):
        back = REVERSED * y
        assert_close(free(back, torque, params, hip), free(y, torque, params, hip), 1e-15)
        assert_close(locked(back, params, hip), locked(y, params, hip), 1e-15)


def test_heavier_walker_moves_alike_and_a_larger_one_slower_by_the_root_of_its_size() -> None:
    mass, size = 4.0, 2.0  # powers of two: nothing is rounded but the rates
    for params, y, torque in draws(12):
        lengths = {
            name: size * getattr(params, name)
            for name in ("leg_length", "foot_length", "foot_radius", "com_along", "com_across")
        }
        scaled = params.replace(
            leg_mass=mass * params.leg_mass,
            leg_inertia=mass * size**2 * params.leg_inertia,
            **lengths,
        )
        slower = np.concatenate([y[:3], y[3:] / math.sqrt(size)])
        conditioning = 1e-15 * np.linalg.cond(mass_matrix(y, params))
        expected = free(y, torque, params) / size
        assert_close(free(slower, torque * mass * size, scaled), expected, conditioning)
        assert_close(locked(slower, scaled), locked(y, params) / size, 2e-14)


def test_locked_walker_is_the_free_one_with_the_torque_that_holds_the_ankle() -> None:
    for params, motion, _ in draws(13):
        y = at_rest_in_the_ankle(motion, params)
        unit = params.leg_mass * params.gravity * params.leg_length
        slack, pushed = free(y, 0.0, params), free(y, unit, params)
        response = pushed - slack
        torque = -(slack[0] - slack[1]) / (response[0] - response[1])
        held = slack + torque * response
        conditioning = 1e-15 * np.linalg.cond(mass_matrix(y, params))
        tolerance = conditioning * (np.linalg.norm(slack) + np.linalg.norm(torque * response))
        assert held == pytest.approx([locked(y, params)[0], *locked(y, params)], abs=tolerance)


def test_hip_much_heavier_than_the_feet_gives_garcias_simplest_walker() -> None:
    """Garcia, Chatterjee, Ruina and Coleman 1998, in their angles θ = −α and φ = s − α."""
    rng = np.random.default_rng(14)
    ratio = 1e-6  # foot to hip; what it leaves out is of this order
    for _ in range(50):
        alpha, s, gamma = rng.uniform(-0.5, 0.5, 3)
        dalpha, ds = rng.uniform(-1, 1, 2)
        params = WalkerParams.from_composite_leg(
            hip_mass=0.5,
            foot_mass=ratio,
            foot_length=0.0,
            locked_ankle_angle=math.pi,
            gravity=1.0,
            slope=gamma,
        )
        motion = np.array([alpha - math.pi, alpha, s + math.pi, dalpha, dalpha, ds])
        theta, phi, dtheta = -alpha, s - alpha, -dalpha
        ddtheta = math.sin(theta - gamma)
        ddphi = ddtheta + dtheta**2 * math.sin(phi) - math.cos(theta - gamma) * math.sin(phi)
        ddalpha = -ddtheta
        expected = [ddalpha, ddphi + ddalpha]
        assert locked(motion, params) == pytest.approx(expected, abs=2 * ratio)


def test_the_locked_chain_is_the_free_one_with_the_rows_and_columns_of_foot_and_leg_added() -> None:
    """The lock of any two links (`locking.py`), as a plastic impact has it, and in the flow."""
    for params, y, _, hip in locked_draws(15):
        c, at = constants(params), pose(y)
        whole = chain.mass_matrix_at(at, free_chain(params), c)
        pair = locking.ankle_locked(whole)
        of_chain = chain.couplings(at.foot, 1.0 + 0j, at.swing, locked_chain(params), c)
        found = square(chain.mass_matrix(of_chain, locked_chain(params), c))
        assert_close(found, square(pair), 1e-14)
        b1, none, b3 = chain.bias(of_chain, y[3], 0.0, y[5], locked_chain(params), c)
        foot, leg, swing_leg = bias(y, params)
        assert none == 0.0
        assert_close((b1, b3), (foot + leg, swing_leg), 5e-14)
        spring = hip - c.hip_stiffness * chain.hip_bend(*y[:3], free_chain(params))
        expected = np.linalg.solve(
            square(pair)[np.ix_([0, 2], [0, 2])], [-spring - b1, spring - b3]
        )
        assert_close(locked(y, params, hip), expected, 5e-14)


def test_a_torque_at_a_locked_ankle_moves_nothing() -> None:
    for params, y, torque, hip in locked_draws(16):
        np.testing.assert_array_equal(locked(y, params, hip, torque), locked(y, params, hip))


def test_momenta_are_the_mass_matrix_times_the_rates_and_solve_gives_the_rates_back() -> None:
    for params, y, _ in draws(17):
        c = constants(params)
        m = chain.mass_matrix_at(pose(y), free_chain(params), c)
        momenta = chain.momenta(m, *y[3:], c)
        assert_close(momenta, square(m) @ y[3:], 1e-15)
        conditioning = 1e-15 * np.linalg.cond(square(m))
        assert_close(chain.solve(m, *momenta, c), y[3:], conditioning)
