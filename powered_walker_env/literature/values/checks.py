"""A published value against ours: how far apart, and whether the printed digits hold."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from powered_walker_env.literature.values.published import PRINTED, Printed
from powered_walker_env.poincare import GaitNotFoundError

SHOWN = 12  # significant digits of our values; differences are of the whole numbers
ROUNDING = 1e-6  # relative slack of a half unit, so that a value on its edge counts as equal

#: A family's checks by the names that `published.json` uses; each computes one number.
Measures = Mapping[str, Callable[[], complex]]


@dataclass(frozen=True)
class Row:
    """One line of the table."""

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


def text_of(value: complex) -> str:
    """A number to 12 digits; real if it is."""
    if value.imag == 0.0:
        return f"{value.real:.{SHOWN}g}"
    return f"{value.real:.{SHOWN}g}{value.imag:+.{SHOWN}g}j"


def compare(entry: Printed, ours: complex, exact: complex | None = None) -> Row:
    """The line of one printed value, or of one known more exactly than it is shown."""
    difference = abs(ours - (entry.value if exact is None else exact))
    return Row(
        family=entry.family,
        walker=entry.walker,
        source=entry.source,
        quantity=entry.quantity,
        published=entry.printed,
        ours=text_of(complex(ours)),
        difference=float(difference),
        within=entry.within,
        agrees=bool(difference <= entry.within * (1.0 + ROUNDING)),
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
        if entry.family != family or (entry.long and not long):
            continue
        try:
            ours = complex(measures[entry.name]())
        except GaitNotFoundError:
            ours = complex(np.nan)
        rows.append(compare(entry, ours))
    return rows


def digits_row(
    family: str,
    walker: str,
    source: str,
    quantity: str,
    published: complex,
    ours: complex,
    within: float,
) -> Row:
    """The line of a value that its source has in full precision, good to `within`."""
    entry = Printed(family, walker, source, "", quantity, text_of(published), within, "", "", False)
    return compare(entry, ours, published)
