"""What an actuation scheme is: the phases of a stride, and the numbers that control it."""

from __future__ import annotations

import dataclasses
import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from powered_walker_env.model.phases import Cycle, Joints

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
    def strength(self) -> int | None:
        """Which of the numbers is the strength of what acts; None: nothing does."""
        return self.columns.index(STRENGTH) if STRENGTH in self.columns else None

    @property
    def switches(self) -> bool:
        """Whether a stride has a switch, the section of the thesis."""
        return ANGLE in self.columns

    @property
    def moves_ankle(self) -> bool:
        """Whether the foot ever turns; else it stays locked for the whole stride."""
        return any(phase.joints == Joints.ANKLE_FREE for phase in self.cycle)

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
        if self.columns == (ANGLE, STRENGTH):
            return numbers
        rows = np.empty((len(numbers), 2))
        rows[:] = NO_SWITCH, 0.0
        rows[:, self.columns] = numbers
        return rows

    def of_numbers(self, numbers: ArrayLike) -> Any:
        """The control with these k numbers; None where there is nothing to control."""
        return self.control_of(self.rows(np.asarray(numbers, np.float64)[np.newaxis])[0])

    def control_of(self, row: Any) -> Any:
        """The inverse of `row`; None where there is nothing to control."""
        if self.control is None:
            return None
        return self.control(*(float(row[column]) for column in self.columns))
