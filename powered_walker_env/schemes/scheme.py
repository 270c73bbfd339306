"""What an actuation scheme is: the phases of a stride, and the numbers that control it."""

from __future__ import annotations

import dataclasses
import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from powered_walker_env.phases import Cycle

#: The kernel's row of a control: a switch angle, rad, and the strength of what acts, SI.
ANGLE, STRENGTH = 0, 1
NO_SWITCH = math.pi  # in place of an angle that is never looked at


class Scheme(NamedTuple):
    """One way to power a walker; each is a module of this package."""

    name: str
    cycle: Cycle
    control: type | None  # a frozen dataclass of numbers; None: nothing to control
    columns: tuple[int, ...] = ()  # where each of its numbers goes: ANGLE or STRENGTH
    positive: bool = True  # must the strength not be negative

    @property
    def numbers(self) -> tuple[str, ...]:
        """Names of the control's numbers, in order."""
        if self.control is None:
            return ()
        return tuple(field.name for field in dataclasses.fields(self.control))

    def row(self, control: Any) -> tuple[float, float]:
        """A control as the kernel's row."""
        row = [NO_SWITCH, 0.0]
        for name, column in zip(self.numbers, self.columns, strict=True):
            row[column] = getattr(control, name)
        return row[ANGLE], row[STRENGTH]

    def rows(self, numbers: NDArray[np.float64]) -> NDArray[np.float64]:
        """(N, 2) the kernel's rows of (N, k) numbers."""
        rows = np.empty((len(numbers), 2))
        rows[:] = NO_SWITCH, 0.0
        rows[:, self.columns] = numbers
        return rows

    def control_of(self, row: Any) -> Any:
        """The inverse of `row`; None where there is nothing to control."""
        if self.control is None:
            return None
        return self.control(*(float(row[column]) for column in self.columns))
