"""What an actuation scheme is: the phases of a stride, and the numbers that control it."""

from __future__ import annotations

import dataclasses
import functools
import math
from collections.abc import Callable
from operator import attrgetter
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from powered_walker_env.model.knees import bends, encoded
from powered_walker_env.model.phases import Cycle, Joints
from powered_walker_env.model.quantities import ANY, Domain, quantities
from powered_walker_env.model.walker import WalkerParams

#: The kernel's row of a control: a switch angle, rad, and the strength of what acts, SI.
ANGLE, STRENGTH = 0, 1
#: In place of an angle that is never looked at.
NO_SWITCH = math.pi


def powers_any(params: WalkerParams) -> None:
    """Refuse no walker."""


@functools.cache
def _fields_of(control: type | None) -> tuple[str, ...]:
    return () if control is None else tuple(each.name for each in dataclasses.fields(control))


class Scheme(NamedTuple):
    """One way to power a walker; each of ours is a module of this package."""

    name: str
    cycle: Cycle
    control: type | None  # a frozen dataclass of numbers; None: nothing to control
    columns: tuple[int, ...] = ()  # where each of its numbers goes: ANGLE or STRENGTH
    refuse: Callable[[WalkerParams], None] = powers_any  # a ValueError for legs it cannot power

    @property
    def phases(self) -> Cycle:
        """All phases of its walkers, those with a free knee after the cycle's own."""
        return encoded(self.cycle).phases

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
    def positive(self) -> bool:
        """Whether the strength must not be negative."""
        return self.strength is None or self.domains[self.strength].low >= 0.0

    @property
    def domains(self) -> tuple[Domain, ...]:
        """Of each number, as its field in the control has it."""
        if self.control is None:
            return ()
        known = quantities(self.control)
        return tuple(known[name].domain if name in known else ANY for name in self.numbers)

    @property
    def numbers(self) -> tuple[str, ...]:
        """Names of the control's numbers, in order."""
        return _fields_of(self.control)

    def check_walker(self, params: WalkerParams) -> None:
        """Reject a walker that cannot walk by this scheme.

        Raises:
            ValueError: as `refuse` says; a walker with knees whose stride would begin with its
                ankle free, or its motor on.
        """
        self.refuse(params)
        first = self.cycle[0]
        if params.knee is not None and not bends(first):
            raise ValueError(
                f"params must have no knee for scheme {self.name!r}, whose phase {first.name!r} "
                "begins a stride with a free ankle or a motor: knees need a passive swing first"
            )

    def row(self, control: Any) -> tuple[float, float]:
        """A control as the kernel's row."""
        if self.columns == (ANGLE, STRENGTH):
            found: tuple[float, float] = attrgetter(*self.numbers)(control)
            return found
        row = [NO_SWITCH, 0.0]
        # As many names as columns: `register_scheme` sees to it, and `strict` takes its time.
        for name, column in zip(self.numbers, self.columns):  # noqa: B905
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

    def check(self, numbers: NDArray[np.float64]) -> None:
        """Reject (N, k) numbers that are no control's, naming the number and the row.

        Raises:
            ValueError: one that is not finite, or outside its domain.
        """
        for name, column, domain in zip(self.numbers, numbers.T, self.domains, strict=True):
            good = np.isfinite(column) & domain.holds(column)
            if not good.all():
                row = int(np.argmin(good))
                need = domain.need if np.isfinite(column[row]) else "be finite"
                raise ValueError(
                    f"controls: {name} must {need}, got {numbers[row].tolist()} in row {row}"
                )

    def of_numbers(self, numbers: ArrayLike) -> Any:
        """The control with these k numbers; None where there is nothing to control."""
        return self.control_of(self.rows(np.asarray(numbers, np.float64)[np.newaxis])[0])

    def control_of(self, row: Any) -> Any:
        """The inverse of `row`; None where there is nothing to control."""
        if self.control is None:
            return None
        return self.control(*(float(row[column]) for column in self.columns))
