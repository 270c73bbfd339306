"""States: each function does one thing to six numbers, with or without tangents."""

from __future__ import annotations

import numba
import numpy as np
import pytest
from numba.core.errors import TypingError

from powered_walker_env.compiled.lanes import (
    LANES,
    SIZE,
    blend_state,
    dual,
    dual_state,
    eights,
    load,
    load_like,
    load_state,
    plus,
    scaled,
    selected,
    store_state,
    tangents_of,
    zero,
)
from tests.helpers.derivation import Array
from tests.helpers.lanes import through

compiled = numba.njit(error_model="numpy")
A, B, OUT = 0, SIZE, 2 * SIZE + 1
FACTOR = 2 * SIZE


@compiled
def states(block):
    m = eights(block)
    a, b, by = load_state(m, A), load_state(m, B), load(m, FACTOR)
    store_state(m, OUT, plus(a, by, b))
    store_state(m, OUT + SIZE, plus(a, 2.5, b))
    store_state(m, OUT + 2 * SIZE, scaled(by, a))
    store_state(m, OUT + 3 * SIZE, scaled(2, a))
    store_state(m, OUT + 4 * SIZE, selected(by > 0.0, a, b))
    store_state(m, OUT + 5 * SIZE, b)
    blend_state(m, OUT + 5 * SIZE, by > 0.0, a)


@compiled
def dual_states(block):
    m = eights(block)
    a, b, by = load_state(m, A), load_state(m, B), load(m, FACTOR)
    both = dual_state(a, b)  # a with the tangents b
    for i, found in enumerate((
        plus(both, by, both), plus(both, 2.5, a), plus(a, by, both),
        selected(by > 0.0, both, dual_state(b, a)), both,
    )):  # fmt: skip
        store_state(m, OUT + 2 * i * SIZE, found)
        store_state(m, OUT + (2 * i + 1) * SIZE, tangents_of(found))
    store_state(m, OUT + 10 * SIZE, b)
    blend_state(m, OUT + 10 * SIZE, by > 0.0, both)


@pytest.fixture
def rows() -> Array:
    """Two states and a factor, of both signs."""
    numbers = np.random.default_rng(1).normal(size=(OUT, LANES))
    numbers[FACTOR, :2] = 0.5, -1.5
    return numbers


def close(found: Array, expected: list[Array]) -> None:
    """To rounding, which a fused product has less of."""
    np.testing.assert_allclose(found.reshape(-1, SIZE, LANES), expected, rtol=0, atol=4e-16 * 8)


def test_a_state_is_its_six_numbers(rows: Array) -> None:
    a, b, by = rows[A:B], rows[B:FACTOR], rows[FACTOR]
    chosen = np.where(by > 0.0, a, b)
    assert 0 < np.count_nonzero(by > 0.0) < LANES
    expected = [a + by * b, a + 2.5 * b, by * a, 2.0 * a, chosen, chosen]
    close(through(states, 6 * SIZE, *rows), expected)


def test_a_dual_state_carries_its_tangents_along(rows: Array) -> None:
    a, b, by = rows[A:B], rows[B:FACTOR], rows[FACTOR]
    up = by > 0.0
    expected = [
        a + by * a, b + by * b, 3.5 * a, b, a + by * a, by * b,
        np.where(up, a, b), np.where(up, b, a), a, b, np.where(up, a, b),
    ]  # fmt: skip
    close(through(dual_states, 11 * SIZE, *rows), expected)


def test_a_factor_with_a_tangent_is_refused_as_it_would_be_lost() -> None:
    @compiled
    def wrong(block):
        m = eights(block)
        a = load_state(m, A)
        store_state(m, OUT, plus(a, dual(load(m, FACTOR), 1.0), a))

    with pytest.raises(TypingError, match="plus"):
        wrong(np.zeros(8 * (OUT + SIZE + 1)))


@compiled
def states_of_two_links(block):
    m = eights(block)
    a, b, by = load_state(m, A), load_state(m, B), load(m, FACTOR)
    two = (a[0], zero(), a[2], a[3], zero(), a[5])
    like = load_like(two, m, B)
    store_state(m, OUT, two)
    store_state(m, OUT + SIZE, like)
    store_state(m, OUT + 2 * SIZE, plus(two, by, like))
    store_state(m, OUT + 3 * SIZE, plus(two, 2.5, b))
    store_state(m, OUT + 4 * SIZE, scaled(by, two))


def test_what_is_known_to_be_zero_is_not_looked_at(rows: Array) -> None:
    a, b, by = rows[A:B], rows[B:FACTOR], rows[FACTOR]
    there = np.array([1.0, 0.0, 1.0, 1.0, 0.0, 1.0])[:, np.newaxis]
    two, like = a * there, b * there
    expected = [two, like, two + by * like, two + 2.5 * b, by * two]
    close(through(states_of_two_links, 5 * SIZE, *rows), expected)
