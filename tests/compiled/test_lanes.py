"""Lanes: each of the eight does what numpy does with its numbers, whatever the others hold."""

from __future__ import annotations

import math

import numba
import numpy as np
import pytest

from powered_walker_env.compiled.lanes import (
    LANES,
    at_lane_0,
    bits,
    blend,
    eights,
    load,
    mask_of,
    rows_from,
    store,
    table,
    unit,
    where,
    zero,
)
from tests.helpers.derivation import Array
from tests.helpers.lanes import block_of, through

EPS = np.finfo(float).eps
SPECIAL = [math.nan, math.inf, -math.inf, 0.0, -0.0, 5e-324, -1e308, 1e308, 1.0, -1.0]
compiled = numba.njit(error_model="numpy")  # divisions by zero give inf, as in the kernel


def draw(rng: np.random.Generator) -> Array:
    """Numbers of all sizes and signs, two of them special."""
    values = rng.normal(size=LANES) * 10.0 ** rng.integers(-5, 6, LANES)
    values[rng.choice(LANES, 2, replace=False)] = rng.choice(SPECIAL, 2)
    return np.asarray(values)


@compiled
def arithmetic(block):
    m = eights(block)
    a, b = load(m, 0), load(m, 1)
    store(m, 2, a + b)
    store(m, 3, a - b)
    store(m, 4, a * b)
    store(m, 5, a / b)
    store(m, 6, a + 2.5)
    store(m, 7, 2.5 - a)
    store(m, 8, 3 * a)
    store(m, 9, a / 3)
    store(m, 10, 1.0 / a)
    store(m, 11, -a)
    store(m, 12, abs(a))
    store(m, 13, math.sqrt(a))


def arithmetic_by_numpy(a: Array, b: Array) -> Array:
    return np.array([
        a + b, a - b, a * b, a / b, a + 2.5, 2.5 - a, 3 * a, a / 3, 1.0 / a, -a, abs(a), np.sqrt(a),
    ])  # fmt: skip


@compiled
def comparisons(block):
    m = eights(block)
    a, b = load(m, 0), load(m, 1)
    store(m, 2, where(a < b, 1.0, 0.0))
    store(m, 3, where(a <= b, 1.0, 0.0))
    store(m, 4, where(a > b, 1.0, 0.0))
    store(m, 5, where(a >= b, 1.0, 0.0))
    store(m, 6, where(a == b, 1.0, 0.0))
    store(m, 7, where(a < 0.5, 1.0, 0.0))
    store(m, 8, where(a > 0, 1.0, 0.0))
    store(m, 9, where((a < b) & (a > 0.0), 1.0, 0.0))
    store(m, 10, where((a < b) | (a > 0.0), 1.0, 0.0))
    store(m, 11, where(~(a < b), 1.0, 0.0))


def comparisons_by_numpy(a: Array, b: Array) -> Array:
    less = a < b
    return np.array([
        less, a <= b, a > b, a >= b, a == b, a < 0.5, a > 0, less & (a > 0), less | (a > 0), ~less,
    ], dtype=float)  # fmt: skip


@compiled
def choices(block):
    m = eights(block)
    a, b = load(m, 0), load(m, 1)
    store(m, 2, where(a < b, a, b))
    store(m, 3, where(a < b, a, 0.0))
    store(m, 4, where(a < b, 1, b))
    store(m, 5, where(at_lane_0(a) < 0.0, a, b))  # one truth for all


def choices_by_numpy(a: Array, b: Array) -> Array:
    less = a < b
    chosen = a if a[0] < 0.0 else b
    return np.array([np.where(less, a, b), np.where(less, a, 0.0), np.where(less, 1, b), chosen])


@compiled
def sums_with_zero(block):
    m = eights(block)
    a, b, none = load(m, 0), load(m, 1), zero()
    turned = complex(a, none) + unit(none)
    store(m, 2, a + none * b)
    store(m, 3, none - a)
    store(m, 4, b + none / a)
    store(m, 5, where(a < b, a, none))
    store(m, 6, turned.real)
    store(m, 7, turned.imag + (complex(none, none) * a).real)


def sums_with_zero_by_numpy(a: Array, b: Array) -> Array:
    return np.array([a, 0.0 - a, b, np.where(a < b, a, 0.0), a + 1.0, np.zeros(LANES)])


FUNCTIONS = {
    "arithmetic": (arithmetic, arithmetic_by_numpy),
    "comparisons": (comparisons, comparisons_by_numpy),
    "choices": (choices, choices_by_numpy),
    "sums with zero": (sums_with_zero, sums_with_zero_by_numpy),
}


@pytest.mark.parametrize("name", FUNCTIONS)
def test_lanes_do_what_numpy_does_bit_for_bit(name: str) -> None:
    ours, theirs = FUNCTIONS[name]
    rng = np.random.default_rng(1)
    for _ in range(300):
        a, b = draw(rng), draw(rng)
        with np.errstate(all="ignore"):
            expected = theirs(a, b)
        found = through(ours, len(expected), a, b)
        np.testing.assert_array_equal(found, expected)
        known = ~np.isnan(expected)  # the sign of a NaN has no meaning
        np.testing.assert_array_equal(np.signbit(found)[known], np.signbit(expected)[known])


@compiled
def everything(block):
    """A long formula of real and complex numbers, as the mechanics has them."""
    m = eights(block)
    a, b = load(m, 0), load(m, 1)
    z = complex(a, b) * complex(b, 0.5) + a * complex(1.0, a)
    w = where(z.real < z.imag, math.sqrt(abs(z.real)) / b, z.imag - a * b)
    store(m, 2, w * z.real - a * b * z.imag)


def test_a_lane_s_result_is_its_own_whatever_its_neighbours_hold() -> None:
    rng = np.random.default_rng(2)
    for _ in range(100):
        a, b = rng.normal(size=(2, LANES))
        (plain,) = through(everything, 1, a, b)
        for lane in range(LANES):
            others = np.arange(LANES) != lane
            for wild in (draw(rng), np.full(LANES, math.nan)):
                (found,) = through(everything, 1, np.where(others, wild, a), np.where(others, a, b))
                assert found[lane] == plain[lane]
        shift = rng.permutation(LANES)
        np.testing.assert_array_equal(through(everything, 1, a[shift], b[shift])[0], plain[shift])


@compiled
def planes(block):
    m = eights(block)
    a, b = load(m, 0), load(m, 1)
    z, w = complex(a, b), complex(load(m, 2), load(m, 3))
    for i, value in enumerate((
        z + w, z - w, z * w, z + a, a - z, z * a, a * z, z * 2.5, 3 * z, z - 2, 2.5 + z,
        complex(a, 1.5), complex(2, b),
    )):  # fmt: skip
        store(m, 4 + 2 * i, value.real)
        store(m, 5 + 2 * i, value.imag)


def test_planes_are_complex_numbers() -> None:
    """Sums bit for bit; of the products each part to the rounding of its two terms."""
    rng = np.random.default_rng(3)
    for _ in range(100):
        rows = rng.normal(size=(4, LANES)) * 10.0 ** rng.integers(-3, 4, (4, LANES))
        a, b, c, d = rows
        z, w = a + 1j * b, c + 1j * d
        expected = np.array([
            z + w, z - w, z * w, z + a, a - z, z * a, a * z, z * 2.5, 3 * z, z - 2, 2.5 + z,
            a + 1.5j, 2 + 1j * b,
        ])  # fmt: skip
        found = through(planes, 2 * len(expected), *rows).reshape(-1, 2, LANES)
        gap = np.abs(found - np.stack([expected.real, expected.imag], axis=1))
        terms = np.array([abs(a * c) + abs(b * d), abs(a * d) + abs(b * c)])
        assert (gap[2] <= 2 * EPS * terms).all()
        assert gap[[0, 1, *range(3, len(expected))]].max() == 0.0


@compiled
def blended(block):
    m = eights(block)
    a, b = load(m, 0), load(m, 1)
    store(m, 2, b)
    blend(m, 2, a > 0.0, a)
    store(m, 3, b)
    blend(m, 3, a > 0.0, 2.5)
    store(m, 4, b)
    blend(m, 4, a > 0.0, 3)


def test_a_blend_writes_where_its_mask_holds() -> None:
    rng = np.random.default_rng(7)
    for _ in range(100):
        a, b = draw(rng), draw(rng)
        expected = [np.where(a > 0.0, new, b) for new in (a, 2.5, 3.0)]
        np.testing.assert_array_equal(through(blended, 3, a, b), expected)


@compiled
def round_trip(number):
    return bits(mask_of(number))


@compiled
def which(block):
    m = eights(block)
    return bits(load(m, 0) > 0.0)


def test_bits_are_the_truths_lane_0_lowest_and_masks_come_back_from_them() -> None:
    rng = np.random.default_rng(4)
    for number in range(1 << LANES):
        assert round_trip(number) == number
    assert round_trip((1 << 40) + 3) == 3  # further bits are nobody's
    for _ in range(100):
        block, rows = block_of(1)
        rows[0] = draw(rng)
        assert which(block) == sum(1 << lane for lane in range(LANES) if rows[0, lane] > 0.0)


@compiled
def copy(block, source, to):
    m = eights(block)
    later = rows_from(m, 2)
    store(later, to - 2, load(m, source))
    return at_lane_0(load(m, source))


@pytest.mark.parametrize("offset", range(LANES + 1))
def test_rows_are_read_and_written_where_they_are_however_the_memory_begins(offset: int) -> None:
    whole = np.zeros(8 * LANES)
    block = whole[offset:]
    start = -block.ctypes.data % (8 * LANES) // 8
    rows = block[start : start + 6 * LANES].reshape(6, LANES)
    rows[:] = np.arange(6 * LANES).reshape(6, LANES)
    before = rows.copy()
    assert copy(block, 1, 4) == before[1, 0]
    before[4] = before[1]
    np.testing.assert_array_equal(rows, before)
    assert whole.sum() == before.sum()  # nothing was written beside the rows


@compiled
def read(array, row, column):
    return table(array)[row, column]


@compiled
def read_later(array, first, row, column):
    return rows_from(table(array), first)[row, column]


@compiled
def write(array, row, column, value):
    rows = table(array)
    rows[row, column] = value
    rows[row, column] += 1


def test_a_table_is_its_array() -> None:
    array = np.random.default_rng(5).normal(size=(7, 5))
    for row in range(7):
        for column in range(5):
            assert read(array, row, column) == array[row, column]
            for first in range(row + 1):
                assert read_later(array, first, row - first, column) == array[row, column]
    expected = array.copy()
    for row, column, value in ((0, 0, 2.5), (6, 4, -1.0), (3, 2, 7)):
        write(array, row, column, value)
        expected[row, column] = value + 1
    np.testing.assert_array_equal(array, expected)


def test_a_flat_array_is_a_table_of_one_column() -> None:
    flat = np.random.default_rng(6).normal(size=9)
    assert [read(flat, i, 0) for i in range(9)] == flat.tolist()


def test_outside_of_compiled_code_where_is_a_choice() -> None:
    assert where(True, 1.0, 2.0) == 1.0
    assert where(False, 1.0, 2.0) == 2.0
