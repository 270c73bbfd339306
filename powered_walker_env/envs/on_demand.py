"""Infos of a batch, one a walker, put together when somebody looks at them.

A batch tells its numbers as arrays; who wants a dictionary of each walker at each step looks
into few of them, and to make them all takes as long as a thousand strides.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from numpy.typing import NDArray

Columns = Mapping[str, NDArray[Any]]  # (N,) or (N, k) each; not written to any more


def row_of(columns: Columns, row: int) -> dict[str, Any]:
    """The info of one walker: Python's numbers, and arrays."""
    return {
        name: values.item(row) if values.ndim == 1 else values[row].copy()
        for name, values in columns.items()
    }


class WalkerInfo(dict[str, Any]):
    """`row_of` on demand.

    What is set beforehand has precedence. A copy, pickled or not, is a plain dictionary.
    """

    __slots__ = ("_columns", "_row")

    def __init__(self, columns: Columns, row: int) -> None:
        self._columns: Columns | None = columns
        self._row = row

    def _fill(self) -> None:
        columns, self._columns = self._columns, None
        for name, value in row_of(columns or {}, self._row).items():
            dict.setdefault(self, name, value)

    def __missing__(self, name: str) -> Any:
        if self._columns is None or name not in self._columns:
            raise KeyError(name)
        self._fill()
        return self[name]

    def get(self, name: Any, default: Any = None) -> Any:
        """The entry, or the default; a name that no column has leaves the row as it is."""
        if self._columns is not None and name in self._columns:
            self._fill()
        return dict.get(self, name, default)

    def copy(self) -> dict[str, Any]:
        """A plain dictionary."""
        return dict(self)

    def __reduce__(self) -> Any:
        return dict, (dict(self),)


def _looks(name: str) -> Any:
    """A method of dictionaries that needs all entries."""
    method = getattr(dict, name)

    def look(self: WalkerInfo, *arguments: Any) -> Any:
        for each in (self, *arguments):
            if isinstance(each, WalkerInfo):
                each._fill()
        return method(self, *arguments)

    look.__name__, look.__doc__ = name, method.__doc__
    return look


for _name in (
    "__contains__", "__delitem__", "__eq__", "__ior__", "__iter__", "__len__", "__ne__", "__or__",
    "__repr__", "__reversed__", "__ror__", "clear", "items", "keys", "pop", "popitem", "setdefault",
    "values",
):  # fmt: skip
    setattr(WalkerInfo, _name, _looks(_name))


def infos_of(columns: Columns) -> list[dict[str, Any]]:
    """The info of every walker."""
    count = len(next(iter(columns.values())))
    return [WalkerInfo(columns, row) for row in range(count)]
