"""Records: one declaration says which numbers there are, and where they lie.

A record is a `NamedTuple` whose fields are floats, complex numbers or truths. From it follow the
columns of a row that packs it, the rows of a table of lanes that holds eight of it, and the
functions that load them. A record of `Table`s (`Annotated[Table, n]` for n rows) is a map of a
block of memory. To add a number is to add a field.
"""

from __future__ import annotations

import typing
from collections.abc import Sequence
from typing import Any, Generic, NamedTuple, TypeVar

import numpy as np

from powered_walker_env.compiled.lanes.loading import duals_of, lane_of, lanes_of, view_of
from powered_walker_env.compiled.lanes.tables import Table

R = TypeVar("R")


class Place(NamedTuple):
    """Where a field lies."""

    name: str
    kind: type  # float, complex, bool or Table
    first: int  # column of a row, or row of a table of lanes
    size: int


class Layout(Generic[R]):
    """The places of a record's fields, one after another, and what loads them.

    Attributes:
        size: numbers in all.
        places: of the fields, by name.
        view: in kernels, `view(table)`: the record of tables in the first rows of a table.
        lanes: in kernels, `lanes(table)`: the record of eight, as lanes.
        lane: in kernels, `lane(table, i)`: that of one lane, as plain numbers.
        duals: in kernels, `duals(lanes, table)`: a record of lanes with its tangents from a table.
    """

    def __init__(self, record: type[R]) -> None:
        self.record = record
        self.places: dict[str, Place] = {}
        self.size = 0
        for name, hint in typing.get_type_hints(record, include_extras=True).items():
            kind, *more = typing.get_args(hint) or (hint,)
            size = more[0] if more else {complex: 2}.get(kind, 1)
            self.places[name] = Place(name, kind, self.size, size)
            self.size += size
        self.view: Any = view_of(self)
        self.lanes: Any = lanes_of(self)
        self.lane: Any = lane_of(self)
        self.duals: Any = duals_of(self)

    def __getitem__(self, name: str) -> int:
        """The first column, or row, of a field."""
        return self.places[name].first

    def slice(self, name: str) -> slice:
        """All columns of a field."""
        place = self.places[name]
        return slice(place.first, place.first + place.size)

    def columns(self, record: Sequence[Any]) -> list[Any]:
        """The numbers of a record in order, complex ones as two; each may be an array."""
        numbers: list[Any] = []
        for place, value in zip(self.places.values(), record, strict=True):
            numbers += [np.real(value), np.imag(value)] if place.kind is complex else [value]
        return numbers

    def of(self, row: Any) -> R:
        """The record that a row of plain numbers packs."""
        values = []
        for place in self.places.values():
            number = float(row[place.first])
            if place.kind is complex:
                values.append(complex(number, float(row[place.first + 1])))
            else:
                values.append(place.kind(number) if place.kind is bool else number)
        return self.record(*values)


__all__ = ["Layout", "Place", "Table"]
