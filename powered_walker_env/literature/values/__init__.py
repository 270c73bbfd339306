"""Every published value that the package reproduces, as lines of one table.

    rows = validate()            # about ten seconds; validate(long=True) for the cascades too
    print(table_text(rows))

One small module per family computes its values (`wheel`, `passive`, `simplest`, `compass`,
`mcgeer`, `kneed`, `toe_off`, `thesis`; `cascades` for those that take long); `published` reads the
values themselves, with their sources; `rows` compares. A value that does not come out stays in the
table, with the reason. To add a family: a module with a `FAMILY`, and a line in `FAMILIES`.
"""

from __future__ import annotations

from collections.abc import Sequence

from powered_walker_env.literature.clock import Clock, Progress
from powered_walker_env.literature.values import (
    compass,
    kneed,
    mcgeer,
    passive,
    simplest,
    thesis,
    toe_off,
    wheel,
)
from powered_walker_env.literature.values.published import Kind
from powered_walker_env.literature.values.rows import Family, Row
from powered_walker_env.literature.values.table import table_csv, table_data, table_text

#: All families, by name.
FAMILIES: dict[str, Family] = {
    module.FAMILY.name: module.FAMILY
    for module in (wheel, passive, simplest, compass, mcgeer, kneed, toe_off, thesis)
}


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
    rows, clock = [], Clock(len(families), progress)
    for name in families:
        rows += FAMILIES[name].rows(long)
        clock.tick()
    return rows


__all__ = [
    "FAMILIES",
    "Family",
    "Kind",
    "Row",
    "table_csv",
    "table_data",
    "table_text",
    "validate",
]
