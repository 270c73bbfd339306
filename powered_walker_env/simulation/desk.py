"""Memory that strides are computed in, kept from one to the next.

To make an array takes Python longer than a hundredth of a stride, so a lone stride makes none.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from typing import Generic, TypeVar

import numpy as np

from powered_walker_env.simulation.kernel import workspace_for
from powered_walker_env.simulation.record import RESULTS

T = TypeVar("T")
_WRITE = struct.Struct("6d").pack_into


class Desk:
    """Where one stride is computed.

    Attributes:
        workspace: of the kernel; states: (1, 4); controls: (1, 2); results: (1, RESULTS), and
        row: (RESULTS,) the same.
    """

    __slots__ = ("_numbers", "controls", "results", "row", "states", "workspace")

    def __init__(self) -> None:
        self.workspace, self._numbers = workspace_for(), np.empty(6)
        self.states, self.controls = self._numbers[np.newaxis, :4], self._numbers[np.newaxis, 4:]
        self.row = np.empty(RESULTS)
        self.results = self.row[np.newaxis]

    def lay(self, a: float, s: float, da: float, ds: float, angle: float, strength: float) -> None:
        """Write the state and the control of a stride."""
        _WRITE(self._numbers.data, 0, a, s, da, ds, angle, strength)


class Kept(Generic[T]):
    """Things of a kind that are not in use: taken and put back by any thread."""

    def __init__(self, make: Callable[[], T]) -> None:
        self._make = make
        self._free: list[T] = []
        self.put_back = self._free.append

    def take(self) -> T:
        """One that nobody uses, or a new one."""
        try:
            return self._free.pop()
        except IndexError:
            return self._make()


DESKS, WORKSPACES = Kept(Desk), Kept(workspace_for)
