"""Lanes with tangents: values as without, tangents as differences of sixth order."""

from __future__ import annotations

import math

import numba
import numpy as np

from powered_walker_env.compiled.lanes import LANES, dual, eights, load, store, unit, where
from tests.helpers.derivation import Array
from tests.helpers.differences import central
from tests.helpers.lanes import through

compiled = numba.njit(error_model="numpy")


@compiled
def real(block):
    """Rows: a, b, their tangents; then each value and its tangent."""
    m = eights(block)
    p, q = load(m, 0), load(m, 1)
    a, b = dual(p, load(m, 2)), dual(q, load(m, 3))
    for i, found in enumerate((
        a + b, a - b, a * b, a / b, -a, abs(a), math.sqrt(a * a + 1.0), 2.5 * a, a * 3, a / 2.0,
        1.0 / a, 3 - a, a + 1.5, a + q, q - a, a * q, a / q, q / a,
        where(a < b, a, b), where(a > 0.0, a * b, 1.0), where(p < q, 2, b), where(a >= b, p, b),
    )):  # fmt: skip
        store(m, 4 + 2 * i, found.value)
        store(m, 5 + 2 * i, found.tangent)


def real_by_numpy(a: Array, b: Array, p: Array, q: Array) -> Array:
    """The same; p and q are a and b as they do not change, and choose."""
    return np.array([
        a + b, a - b, a * b, a / b, -a, abs(a), np.sqrt(a * a + 1.0), 2.5 * a, a * 3, a / 2.0,
        1.0 / a, 3 - a, a + 1.5, a + q, q - a, a * q, a / q, q / a,
        np.where(p < q, a, b), np.where(p > 0, a * b, 1.0), np.where(p < q, 2, b),
        np.where(p >= q, p, b),
    ])  # fmt: skip


@compiled
def planes(block):
    m = eights(block)
    p, q = load(m, 0), load(m, 1)
    a, b = dual(p, load(m, 2)), dual(q, load(m, 3))
    z, w, flat = complex(a, b), complex(b, 0.5), complex(p, q)
    for i, found in enumerate((
        z + w, z - w, z * w, z * a, b * z, z * 2.5, 3 * z, z + 1.0, flat * z, z - flat, a + z,
        unit(a), unit(a * b), z * unit(b), dual(flat, complex(load(m, 2), load(m, 3))),
        complex(a, q), where(a < b, z, w), where(p < q, z, flat), -1.0 * z + (0.5 + 2.0j),
    )):  # fmt: skip
        store(m, 4 + 4 * i, found.real.value)
        store(m, 5 + 4 * i, found.imag.value)
        store(m, 6 + 4 * i, found.real.tangent)
        store(m, 7 + 4 * i, found.imag.tangent)


def planes_by_numpy(a: Array, b: Array, p: Array, q: Array) -> Array:
    z, w, flat = a + 1j * b, b + 0.5j, p + 1j * q
    return np.array([
        z + w, z - w, z * w, z * a, b * z, z * 2.5, 3 * z, z + 1.0, flat * z, z - flat, a + z,
        np.exp(1j * a), np.exp(1j * a * b), z * np.exp(1j * b), z,
        a + 1j * q, np.where(p < q, z, w), np.where(p < q, z, flat), -z + (0.5 + 2.0j),
    ])  # fmt: skip


@compiled
def parts(block):
    """Value and tangent of a complex number as complex numbers."""
    m = eights(block)
    z = dual(complex(load(m, 0), load(m, 1)), complex(load(m, 2), load(m, 3)))
    store(m, 4, z.value.real)
    store(m, 5, z.value.imag)
    store(m, 6, z.tangent.real)
    store(m, 7, z.tangent.imag)


def draw(rng: np.random.Generator) -> Array:
    """a, b and their tangents; no value near zero, where a quotient or an absolute value turns."""
    rows = rng.normal(size=(4, LANES))
    rows[:2] += np.sign(rows[:2]) * 0.3
    return rows


def tangents(function, rows: Array) -> Array:  # type: ignore[no-untyped-def]
    a, b, da, db = rows
    tries = [central(lambda h: function(a + h * da, b + h * db, a, b), h) for h in (3e-3, 1e-3)]
    return np.array(tries)


def test_real_numbers_follow_the_rules_of_differentiation() -> None:
    rng = np.random.default_rng(1)
    for _ in range(100):
        rows = draw(rng)
        expected = real_by_numpy(*rows[:2], *rows[:2])
        found = through(real, 2 * len(expected), *rows).reshape(-1, 2, LANES)
        np.testing.assert_allclose(found[:, 0], expected, rtol=4e-16, atol=4e-16)
        gap = np.abs(tangents(real_by_numpy, rows) - found[:, 1]).min(axis=0)
        assert (gap < 1e-8 * (1.0 + np.abs(found[:, 1]))).all()


def test_complex_numbers_follow_the_rules_of_differentiation() -> None:
    rng = np.random.default_rng(2)
    for _ in range(100):
        rows = draw(rng)
        expected = planes_by_numpy(*rows[:2], *rows[:2])
        found = through(planes, 4 * len(expected), *rows).reshape(-1, 4, LANES)
        np.testing.assert_allclose(found[:, 0] + 1j * found[:, 1], expected, rtol=0, atol=2e-14)
        moved = found[:, 2] + 1j * found[:, 3]
        gap = np.abs(tangents(planes_by_numpy, rows) - moved).min(axis=0)
        assert (gap < 1e-9 * (1.0 + np.abs(moved))).all()


def test_parts_of_a_complex_number_are_what_it_was_made_of() -> None:
    rows = draw(np.random.default_rng(3))
    np.testing.assert_array_equal(through(parts, 4, *rows), rows)


def test_a_lane_s_tangent_is_its_own_whatever_its_neighbours_hold() -> None:
    rng = np.random.default_rng(4)
    rows = draw(rng)
    plain = through(planes, 76, *rows)
    for lane in range(LANES):
        wild = rng.choice([math.nan, math.inf, 1e300], size=rows.shape)
        wild[:, lane] = rows[:, lane]
        np.testing.assert_array_equal(through(planes, 76, *wild)[:, lane], plain[:, lane])
