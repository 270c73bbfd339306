"""Records: from one declaration follow rows, tables of lanes, loads and columns."""

from __future__ import annotations

from typing import Annotated, Any, NamedTuple

import numba
import numpy as np
import pytest

from powered_walker_env.compiled.lanes import LANES, Table, eights, load, rows_from, store, where
from powered_walker_env.compiled.records import Layout
from tests.helpers.derivation import Array
from tests.helpers.lanes import block_of

compiled = numba.njit(error_model="numpy")


class Small(NamedTuple):
    """A record of each kind of number."""

    mass: float
    place: complex
    heavy: bool


class Grown(NamedTuple):
    """The same with a field more, in the middle."""

    mass: float
    spin: complex
    place: complex
    heavy: bool


def test_places_follow_one_another_in_the_order_of_the_fields() -> None:
    layout = Layout(Small)
    assert (layout.size, layout["mass"], layout["place"], layout["heavy"]) == (4, 0, 1, 3)
    assert layout.slice("place") == slice(1, 3)
    assert [place.name for place in layout.places.values()] == list(Small._fields)


def test_a_field_that_is_added_appears_in_columns_rows_and_places() -> None:
    layout, grown = Layout(Small), Layout(Grown)
    assert grown.size == layout.size + 2
    assert (grown["spin"], grown["place"], grown["heavy"]) == (1, 3, 5)
    record = Grown(2.0, 3.0 - 4.0j, 1.0 + 5.0j, True)
    assert grown.columns(record) == [2.0, 3.0, -4.0, 1.0, 5.0, True]
    assert grown.of(np.array([2.0, 3.0, -4.0, 1.0, 5.0, 1.0])) == record
    assert layout.columns(Small(2.0, 1.0 + 5.0j, False)) == [2.0, 1.0, 5.0, False]


def test_columns_may_be_arrays_and_a_row_gives_plain_python_numbers() -> None:
    layout = Layout(Small)
    columns = layout.columns(Small(np.arange(3.0), 1j * np.ones(3), np.zeros(3, bool)))
    np.testing.assert_array_equal(np.stack(columns[:3]), [[0, 1, 2], [0, 0, 0], [1, 1, 1]])
    back = layout.of(np.array([1.0, 2.0, 3.0, 0.0]))
    assert [type(value) for value in back] == [float, complex, bool]
    assert back == Small(1.0, 2.0 + 3.0j, False)


def small_sum(record: Any) -> Any:
    """One number from every field."""
    return where(record.heavy, record.mass, 10.0) + record.place.real + 2.0 * record.place.imag


def grown_sum(record: Any) -> Any:
    return (
        where(record.heavy, record.mass, 10.0) + record.place.real + 2.0 * record.place.imag
        + 100.0 * record.spin.real + 1000.0 * record.spin.imag
    )  # fmt: skip


def compiled_sums(layout: Layout[Any], total: Any) -> tuple[Any, Any]:
    """In kernels: the sum of eight records, and of the one in a lane."""
    lanes, lane, plain = layout.lanes, layout.lane, numba.njit(total)

    @compiled
    def of_eight(block, size):
        m = eights(block)
        store(m, size, plain(lanes(m)))

    @compiled
    def of_one(block, i):
        record = lane(eights(block), i)
        base = record.mass if record.heavy else 10.0
        return base + record.place.real + 2.0 * record.place.imag

    return of_eight, of_one


@pytest.mark.parametrize(("record", "total"), [(Small, small_sum), (Grown, grown_sum)])
def test_kernels_load_every_field_of_eight_records_and_of_one(record: Any, total: Any) -> None:
    layout, rng = Layout(record), np.random.default_rng(1)
    of_eight, of_one = compiled_sums(layout, total)
    block, rows = block_of(layout.size + 1)
    rows[: layout.size] = rng.normal(size=(layout.size, LANES))
    rows[layout["heavy"]] = rng.integers(2, size=LANES)
    of_eight(block, layout.size)
    for i in range(LANES):
        known = layout.of(rows[:, i])
        assert rows[layout.size, i] == pytest.approx(total(known), rel=1e-15)
        assert of_one(block, i) == pytest.approx(small_sum(known), rel=1e-15)


def test_kernels_load_a_record_with_its_tangents_and_truths_have_none() -> None:
    layout, rng = Layout(Small), np.random.default_rng(2)
    lanes, duals, size = layout.lanes, layout.duals, layout.size

    @compiled
    def derivative(block):
        m = eights(block)
        record = duals(lanes(m), rows_from(m, size))
        product = record.place * record.mass
        found = where(record.heavy, product.real, product.imag)
        store(m, 2 * size, found.value)
        store(m, 2 * size + 1, found.tangent)

    block, rows = block_of(2 * size + 2)
    rows[: 2 * size] = rng.normal(size=(2 * size, LANES))
    derivative(block)
    for i in range(LANES):
        value, by = layout.of(rows[:size, i]), layout.of(rows[size : 2 * size, i])
        product = value.place * value.mass
        change = by.place * value.mass + value.place * by.mass
        pick = (lambda z: z.real) if rows[layout["heavy"], i] > 0.0 else (lambda z: z.imag)
        assert rows[2 * size, i] == pytest.approx(pick(product), rel=1e-15)
        assert rows[2 * size + 1, i] == pytest.approx(pick(change), rel=1e-14)


class Memory(NamedTuple):
    """A map of a block of memory."""

    first: Table
    many: Annotated[Table, 3]
    last: Table


def test_a_record_of_tables_maps_a_block_of_memory() -> None:
    layout = Layout(Memory)
    view = layout.view
    assert (layout.size, layout["many"], layout["last"]) == (5, 1, 4)

    @compiled
    def write(block):
        memory = view(eights(block))
        store(memory.last, 0, load(memory.first, 0) + load(memory.many, 2))
        memory.many[1, 0] = memory.many[0, 1]

    block, rows = block_of(layout.size)
    rows[:] = np.arange(rows.size).reshape(rows.shape)
    before: Array = rows.copy()
    write(block)
    before[4] = before[0] + before[3]
    before[2, 0] = before[1, 1]
    np.testing.assert_array_equal(rows, before)
