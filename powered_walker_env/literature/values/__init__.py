"""Every published value that the package reproduces, in one table.

    rows = validate()            # about ten seconds; validate(long=True) for the cascades too
    print(table_text(rows))

One small module per family computes its values (`wheel`, `passive`, `simplest`, `compass`,
`mcgeer`, `toe_off`, `thesis`; `cascades` for those that take long); `published.json` and
`limit_cycles.json` hold the values themselves, with their sources; `checks` compares. A value
that does not come out stays in the table, with the reason. To add a family: a module with
`rows(long)`, and a line in `FAMILIES`.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence

from powered_walker_env.literature.values import (
    compass,
    mcgeer,
    passive,
    simplest,
    thesis,
    toe_off,
    wheel,
)
from powered_walker_env.literature.values.checks import Row
from powered_walker_env.literature.values.tables import table_csv, table_data, table_text

#: The lines of each family; the argument asks for those that take long, too.
FAMILIES: dict[str, Callable[[bool], list[Row]]] = {
    module.FAMILY: module.rows
    for module in (wheel, passive, simplest, compass, mcgeer, toe_off, thesis)
}

#: Called as the work goes on: families done, families in all, seconds left.
Progress = Callable[[int, int, float], None]


def validate(
    only: Sequence[str] | None = None,
    *,
    long: bool = False,
    progress: Progress | None = None,
) -> list[Row]:
    """Compute what has been published, and compare.

    Args:
        only: families, names of `FAMILIES`; all if left out.
        long: the cascades and the end of walking, too (a minute or two).
        progress: called after each family.

    Raises:
        ValueError: an unknown family.
    """
    families = list(FAMILIES) if only is None else list(only)
    for name in families:
        if name not in FAMILIES:
            raise ValueError(f"family must be one of {', '.join(FAMILIES)}, got {name!r}")
    rows: list[Row] = []
    began = time.monotonic()
    for done, name in enumerate(families):
        if progress is not None:
            left = (time.monotonic() - began) / done * (len(families) - done) if done else math.nan
            progress(done, len(families), left)
        rows += FAMILIES[name](long)
    return rows


__all__ = ["FAMILIES", "Progress", "Row", "table_csv", "table_data", "table_text", "validate"]
