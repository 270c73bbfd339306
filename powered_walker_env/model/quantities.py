"""A number of a walker or a control: its symbol, unit, label and domain, written on its field.

Command line, axes, tables and error messages read them there; a new number is one line in its
class.
"""

from __future__ import annotations

import dataclasses
import math
from typing import Any, NamedTuple

from powered_walker_env.model.checks import real_number, require


class Domain(NamedTuple):
    """The values that a number may take, and the words an error message has for them."""

    low: float
    high: float
    ends: str  # which of the two belong to it: "", "low", "high"
    need: str
    remedy: str = ""

    def holds(self, value: Any) -> Any:
        """Whether a finite number, or each of an array, lies in the domain."""
        above = value >= self.low if "low" in self.ends else value > self.low
        below = value <= self.high if "high" in self.ends else value < self.high
        return above & below


ANY = Domain(-math.inf, math.inf, "", "be a number")
POSITIVE = Domain(0.0, math.inf, "", "be positive")
NOT_NEGATIVE = Domain(0.0, math.inf, "low", "not be negative")
HIP_ANGLE = Domain(0.0, 2 * math.pi, "", "lie in (0, 2*pi)", "angles are radians")
ANKLE_ANGLE = Domain(-math.pi, math.pi, "high", "lie in (-pi, pi]", "angles are radians")
SLOPE = Domain(-math.pi / 2, math.pi / 2, "", "lie in (-pi/2, pi/2)", "radians, downhill positive")


class Quantity(NamedTuple):
    """What a number is."""

    name: str  # of the field
    symbol: str  # as in the source
    unit: str  # SI; "" for a pure number
    label: str  # in words, as an axis or a help text has it
    domain: Domain

    @property
    def axis(self) -> str:
        """Label and unit, as an axis has them."""
        return f"{self.label}, {self.unit}" if self.unit else self.label


def quantity(
    symbol: str, unit: str, label: str, domain: Domain, default: Any = dataclasses.MISSING
) -> Any:
    """A dataclass field that says what its number is."""
    return dataclasses.field(
        default=default,
        metadata={"symbol": symbol, "unit": unit, "label": label, "domain": domain},
    )


def quantities(cls: Any) -> dict[str, Quantity]:
    """The numbers of a class (or of an instance), in order, by the name of their fields."""
    return {
        field.name: Quantity(field.name, **field.metadata)
        for field in dataclasses.fields(cls)
        if "domain" in field.metadata
    }


def check_numbers(record: Any) -> None:
    """Make every number of a frozen dataclass a float inside its domain.

    Raises:
        ValueError: a number outside; the message names field, need, value and remedy.
        TypeError: something that is no real number.
    """
    for name, number in quantities(record).items():
        value = real_number(name, getattr(record, name))
        object.__setattr__(record, name, value)
        domain = number.domain
        require(domain.holds(value), name, domain.need, value, domain.remedy)


def documented(cls: Any) -> Any:
    """Append the table of a class's numbers to its docstring."""
    rows = [
        f"        {each.name}: {each.symbol}, {each.unit or 'a number'}; {each.label}"
        + ("." if each.domain == ANY else f"; must {each.domain.need}.")
        for each in quantities(cls).values()
    ]
    cls.__doc__ = "\n".join([(cls.__doc__ or "").rstrip(), "", "    Numbers:", *rows, "    "])
    return cls
