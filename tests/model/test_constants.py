"""The row that a walker is to the kernels: what is in it, and its derivatives."""

from __future__ import annotations

import cmath
import math

import numpy as np
import pytest

from powered_walker_env import PRESETS, WalkerParams
from powered_walker_env.model.knee import Knee
from powered_walker_env.model.mechanics.packing import (
    BENT_CHAIN,
    CHAIN,
    CONSTANTS,
    LOCKED_CHAIN,
    NUMBERS,
    OWN,
    ROW,
    chains_of,
    constants_of,
    own_numbers,
    pack,
    pack_all,
    params_of,
    row_tangents,
    rows_from_own,
)
from powered_walker_env.model.quantities import quantities
from powered_walker_env.model.walker import AS_PUBLISHED, CONSERVING
from tests.helpers.derivation import Array
from tests.helpers.differences import central
from tests.helpers.samples import kneed, kneed_walkers, random_walkers, sprung

WALKERS = [preset.params for preset in PRESETS.values()]
WALKERS += [*random_walkers(1, 20), *kneed_walkers(1, 20)]
SIMPLEST = PRESETS["simplest"].params
OF_KNEE = tuple(quantities(Knee))
MASSLESS = SIMPLEST.replace(foot_length=0.1, foot_radius=0.2, locked_ankle_angle=2.5)


def test_a_row_has_every_number_of_a_walker_and_gives_it_back() -> None:
    assert (*quantities(WalkerParams), *quantities(Knee), "as_published") == NUMBERS
    for params in WALKERS:
        assert params_of(pack(params)) == params
        assert pack(params)[:OWN].tolist() == own_numbers(params)


def test_a_row_is_its_parts_in_order_each_of_its_size() -> None:
    for params in WALKERS:
        row, chains = pack(params), chains_of(params)
        columns = [
            *own_numbers(params), *CONSTANTS.columns(constants_of(params)),
            *(column for chain in chains for column in CHAIN.columns(chain)),
        ]  # fmt: skip
        assert row.tolist() == columns
        assert len(row) == ROW == BENT_CHAIN + CHAIN.size
        assert OWN + CONSTANTS.size == LOCKED_CHAIN


def test_rows_of_many_are_those_of_each_bit_for_bit() -> None:
    together = pack_all(WALKERS)
    for params, row in zip(WALKERS, together, strict=True):
        np.testing.assert_array_equal(row, pack(params))


def test_a_packed_row_is_its_receiver_s_own() -> None:
    row = pack(SIMPLEST)
    row[:] = 0.0
    assert pack(SIMPLEST).any()


@pytest.mark.parametrize("physics", [CONSERVING, AS_PUBLISHED])
def test_constants_are_what_the_walker_s_numbers_say(physics: str) -> None:
    for walker in random_walkers(2, 20, physics=physics, torque_limit=3.0):
        p, c = walker, constants_of(walker)
        foot = p.foot_length * cmath.exp(-1j * p.locked_ankle_angle)
        assert (
            p.leg_length, p.foot_length, p.foot_radius, p.leg_mass, p.leg_inertia
        ) == (c.L, c.D, c.R, c.M, c.I)  # fmt: skip
        assert c.ankle_to_com == complex(p.com_along, p.com_across)
        assert c.ankle_to_com + c.hip_to_com == pytest.approx(p.leg_length, rel=1e-15)
        assert c.g == pytest.approx(p.gravity * cmath.exp(-1j * p.slope), rel=1e-15)
        assert c.retracted == pytest.approx(foot, rel=1e-15)
        assert c.reach * c.lean == pytest.approx(p.leg_length + foot, rel=1e-15)
        assert abs(c.lean) == pytest.approx(1.0, rel=1e-15)
        assert c.droop == (1.0 if physics == CONSERVING else -1.0) / p.no_load_speed
        assert c.as_published is (physics == AS_PUBLISHED)
        assert (c.torque_limit, c.hip_stiffness) == (3.0, p.hip_stiffness)
        assert constants_of(p.replace(torque_limit=0.0)).torque_limit == math.inf


def test_a_foot_s_centre_at_the_hip_harms_no_other_number() -> None:
    c = constants_of(WalkerParams(foot_length=1.0, locked_ankle_angle=math.pi, torque_limit=1.0))
    assert c.reach < 1e-15
    assert abs(c.lean) == 1.0
    assert np.isfinite(CONSTANTS.columns(c)).all()


def tangents_by_differences(own: Array, change: Array) -> Array:
    """(ROW,) of one walker's row; a limit that is infinite does not change."""

    def along(h: float) -> Array:
        row = rows_from_own((own + h * change)[np.newaxis])[0]
        return np.where(np.isinf(row), 0.0, row)

    size = np.abs(own[change != 0.0]).max() or 1.0
    return central(along, 1e-3 * size)


@pytest.mark.parametrize("physics", [CONSERVING, AS_PUBLISHED])
@pytest.mark.parametrize("limit", [0.0, 5.0])
@pytest.mark.parametrize("number", NUMBERS[:-1])
def test_derivatives_of_a_row_by_each_number_are_those_of_differences(
    number: str, limit: float, physics: str
) -> None:
    rng = np.random.default_rng(3)
    change = np.eye(OWN)[NUMBERS.index(number)]
    if number == "torque_limit" and limit == 0.0:
        change = 0.0 * change  # none at all: no small limit is near it
    walkers = [sprung(p, rng) for p in random_walkers(3, 5, torque_limit=limit, physics=physics)]
    walkers = [kneed(p, rng) for p in walkers]
    own = np.array([own_numbers(params) for params in walkers])
    found = row_tangents(own, change)
    for one, by in zip(own, found, strict=True):
        expected = tangents_by_differences(one, change) if change.any() else np.zeros(ROW)
        np.testing.assert_allclose(by, expected, rtol=1e-9, atol=1e-9 * np.abs(expected).max())
    if number in ("no_load_speed", "slope", "leg_length", "shank_length", "shank_inertia"):
        assert np.count_nonzero(found[0, OWN:]) > 0


@pytest.mark.parametrize(
    "together",
    [("leg_length", "com_along"), *((n,) for n in NUMBERS[:-1] if n not in (
        "leg_length", "com_along", "com_across", "leg_inertia", "torque_limit", *OF_KNEE))],
    ids="-".join,
)  # fmt: skip
def test_derivatives_of_a_massless_walker_s_row_stay_in_its_limit(
    together: tuple[str, ...],
) -> None:
    own = np.array(own_numbers(MASSLESS))
    change = np.sum([np.eye(OWN)[NUMBERS.index(name)] for name in together], axis=0)
    expected = tangents_by_differences(own, change)
    found = row_tangents(own[np.newaxis], change)[0]
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-9)


def test_derivatives_along_several_numbers_add_up() -> None:
    rng = np.random.default_rng(4)
    own = np.array([own_numbers(params) for params in random_walkers(4, 3)])
    change = np.append(rng.normal(size=OWN - 1), 0.0)
    parts = [row_tangents(own, part * one) for part, one in zip(change, np.eye(OWN), strict=True)]
    total = np.sum(parts, axis=0)
    np.testing.assert_allclose(row_tangents(own, change), total, rtol=1e-12, atol=1e-12)
