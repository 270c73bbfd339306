"""The unit vector of an angle on lanes: its cosine and sine are as near as they are said to be,
symmetric, and honest about NaN."""

from __future__ import annotations

import math

import numba
import numpy as np
import pytest

from powered_walker_env.compiled.lanes import LANES, eights, load, store, unit
from tests.helpers.derivation import Array
from tests.helpers.lanes import block_of

LARGEST = 1e5  # rad, up to where the accuracy is promised


@numba.njit
def both(block, count):
    """Rows of angles, in place: their sines in the first half, their cosines in the second."""
    m = eights(block)
    for i in range(count):
        along = unit(load(m, i))
        store(m, i, along.imag)
        store(m, count + i, along.real)


def sine_cosine(x: Array) -> tuple[Array, Array]:
    """Of an array of any length."""
    count = -(-len(x) // LANES)
    block, rows = block_of(2 * count)
    rows[:count].flat[: len(x)] = x
    both(block, count)
    return rows[:count].ravel()[: len(x)].copy(), rows[count:].ravel()[: len(x)].copy()


def ulps(found: Array, expected: Array) -> float:
    """The largest error in units in the last place of the true value."""
    return float(np.max(np.abs(found - expected) / np.spacing(np.abs(expected))))


def scattered(rng: np.random.Generator) -> Array:
    """Angles of every size up to the largest."""
    sizes = 10.0 ** rng.uniform(-12, math.log10(LARGEST), 200_000)
    return np.asarray(np.concatenate([
        rng.choice([-1, 1], len(sizes)) * sizes,
        rng.uniform(-LARGEST, LARGEST, 200_000),
        rng.uniform(-7, 7, 200_000),  # where walkers are
    ]))  # fmt: skip


def near_quarters(rng: np.random.Generator) -> Array:
    """Multiples of π/2 and of π/4 and their neighbours, where the reduction cancels most."""
    turns = np.concatenate([np.arange(-200, 201), rng.integers(-127_000, 127_000, 20_000)])
    places = np.concatenate([turns * (math.pi / 4), turns * (math.pi / 2)])
    places = places[np.abs(places) <= LARGEST]
    steps = rng.integers(-3, 4, len(places))
    off = rng.choice([-1, 1], len(places)) * 10.0 ** rng.uniform(-16, -1, len(places))
    shifted = places + off
    return np.concatenate([places, places + steps * np.spacing(np.abs(places)), shifted])


@pytest.mark.parametrize("angles", [scattered, near_quarters])
def test_sine_and_cosine_are_within_two_units_in_the_last_place(angles) -> None:  # type: ignore[no-untyped-def]
    """The library's, to compare with, are themselves within one: it matters for many turns."""
    x = angles(np.random.default_rng(1))
    x = x[(np.abs(x) <= LARGEST) & (x != 0.0)]
    for largest, bound in ((7.0, 2.0), (LARGEST, 3.0)):
        near = x[np.abs(x) <= largest]
        sine, cosine = sine_cosine(near)
        assert ulps(sine, np.sin(near)) <= bound
        assert ulps(cosine, np.cos(near)) <= bound


def test_sine_is_odd_and_cosine_even_bit_for_bit() -> None:
    rng = np.random.default_rng(2)
    x = np.concatenate([scattered(rng), near_quarters(rng)])
    sine, cosine = sine_cosine(x)
    mirrored_sine, mirrored_cosine = sine_cosine(-x)
    np.testing.assert_array_equal(mirrored_sine, -sine)
    np.testing.assert_array_equal(mirrored_cosine, cosine)


def test_small_angles_are_their_sines() -> None:
    tiny = np.array([1e-9, -1e-9, 1e-200, -1e-200, 5e-324, -5e-324, 0.0])
    sine, cosine = sine_cosine(tiny)
    np.testing.assert_array_equal(sine, tiny)
    np.testing.assert_array_equal(np.signbit(sine), np.signbit(tiny))
    np.testing.assert_array_equal(cosine, 1.0)


def test_minus_zero_is_zero() -> None:
    """Its sine is a zero, too, of no sign that is promised: a polynomial's last sum drops it."""
    sine, cosine = sine_cosine(np.full(LANES, -0.0))
    np.testing.assert_array_equal(sine, 0.0)
    np.testing.assert_array_equal(cosine, 1.0)


def test_what_has_no_sine_is_not_a_number_and_spoils_no_neighbour() -> None:
    x = np.array([0.5, math.nan, 1.5, math.inf, 2.5, -math.inf, 3.5, -math.nan])
    sine, cosine = sine_cosine(x)
    calm_sine, calm_cosine = sine_cosine(np.where(np.isfinite(x), x, 0.0))
    np.testing.assert_array_equal(np.isnan(sine), ~np.isfinite(x))
    np.testing.assert_array_equal(np.isnan(cosine), ~np.isfinite(x))
    np.testing.assert_array_equal(sine[::2][:4], calm_sine[::2][:4])
    np.testing.assert_array_equal(cosine[::2], calm_cosine[::2])


def test_far_beyond_any_walker_the_values_are_bounded_by_nothing_but_end_no_process() -> None:
    """A runaway state must not hang or trap, nor spoil its neighbours; that it is wrong there,
    nobody sees. Just beyond what is promised it is still a good sine, also where products are
    rounded before they are subtracted."""
    x = np.concatenate([10.0 ** np.arange(6.0, 309.0), -(10.0 ** np.arange(6.0, 309.0))])
    sine, cosine = sine_cosine(x)
    near = np.abs(x) <= 1e7
    assert np.abs(sine - np.sin(x))[near].max() < 1e-9
    assert np.abs(cosine - np.cos(x))[near].max() < 1e-9
    mixed = np.where(np.arange(len(x)) % 2 == 0, x, 0.5)
    sine, cosine = sine_cosine(mixed)
    np.testing.assert_array_equal(sine[1::2], sine[1])
    assert sine[1] == pytest.approx(math.sin(0.5), rel=1e-15)
    assert cosine[1::2] == pytest.approx(math.cos(0.5), rel=1e-15)


def test_in_python_it_is_the_complex_number() -> None:
    for angle in (0.0, 0.5, -2.0, 4.0):
        assert unit(angle) == complex(math.cos(angle), math.sin(angle))


def test_the_squares_add_up_to_one() -> None:
    sine, cosine = sine_cosine(scattered(np.random.default_rng(4)))
    assert np.abs(sine**2 + cosine**2 - 1.0).max() < 4 * np.finfo(float).eps
