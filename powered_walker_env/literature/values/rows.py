"""A published value against ours: how far apart, and whether the printed digits hold."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from powered_walker_env.literature.values.published import PRINTED, Kind, Origin, Printed
from powered_walker_env.poincare import Gait, GaitNotFoundError

SHOWN = 12  # significant digits of our values; differences are of the whole numbers
ROUNDING = 1e-6  # relative slack of a half unit, so that a value on its edge counts as equal

#: A family's checks by the names that `published.json` uses; each computes one number.
Measures = Mapping[str, Callable[[], complex]]

#: A quantity, its published value in full precision, and ours.
Pair = tuple[str, complex, complex]


@dataclass(frozen=True)
class Row:
    """One line of the table."""

    kind: Kind
    family: str
    walker: str
    source: str
    quantity: str
    published: str  # as printed
    ours: str
    difference: float
    within: float  # what the printed precision allows
    agrees: bool
    differs: str  # the reason given beforehand why it does not come out
    remark: str

    @property
    def passes(self) -> bool:
        """It agrees, or differs as explained; what was explained away must not agree."""
        return self.agrees != bool(self.differs) and math.isfinite(self.difference)

    @property
    def verdict(self) -> str:
        """In a word."""
        if self.passes:
            return "agrees" if self.agrees else "differs, explained"
        return "AGREES, though said to differ" if self.agrees else "DIFFERS"


class Family(NamedTuple):
    """Walkers whose values are computed alike."""

    name: str
    measures: Measures  # of the values printed
    known: Callable[[], list[Row]] = list  # lines of values known in full precision

    def rows(self, long: bool = False) -> list[Row]:
        """All its lines; those that take long only if asked for."""
        return self.known() + printed_rows(self.name, self.measures, long)


def text_of(value: complex) -> str:
    """A number to 12 digits; real if it is."""
    if value.imag == 0.0:
        return f"{value.real:.{SHOWN}g}"
    return f"{value.real:.{SHOWN}g}{value.imag:+.{SHOWN}g}j"


def compare(entry: Printed, ours: complex, exact: complex | None = None) -> Row:
    """The line of one printed value, or of one known more exactly than it is shown."""
    difference = abs(ours - (entry.value if exact is None else exact))
    return Row(
        **vars(entry.origin),
        quantity=entry.quantity,
        published=entry.printed,
        ours=text_of(complex(ours)),
        difference=float(difference),
        within=entry.allowed,
        agrees=bool(difference <= entry.allowed * (1.0 + ROUNDING)),
        differs=entry.differs,
        remark=entry.remark,
    )


def printed_rows(family: str, measures: Measures, long: bool) -> list[Row]:
    """The lines of a family's printed values, those that take long only if asked for.

    A walker that is not found where a source has one is a line that differs (NaN), not the
    end of the table.
    """
    rows = []
    for entry in PRINTED:
        if entry.origin.family != family or (entry.long and not long):
            continue
        try:
            ours = complex(measures[entry.name]())
        except GaitNotFoundError:
            ours = complex(np.nan)
        rows.append(compare(entry, ours))
    return rows


def digits_rows(origin: Origin, pairs: Iterable[Pair], within: float) -> list[Row]:
    """The lines of values that their source has in full precision, good to `within`."""
    return [
        compare(Printed(origin, "", quantity, text_of(published), within), ours, published)
        for quantity, published, ours in pairs
    ]


def multipliers(published: Sequence[complex], gait: Gait, least: float = 0.0) -> list[Pair]:
    """Published multipliers, each beside the nearest of ours; one of each conjugate pair, and
    none that is zero to `least`."""
    return [
        (f"multiplier {number + 1}", value, min(gait.multipliers, key=lambda m: abs(m - value)))
        for number, value in enumerate(published)
        if value.imag >= 0.0 and abs(value) >= least
    ]
