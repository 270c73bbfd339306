"""The table of published values for people, for spreadsheets and for programs."""

from __future__ import annotations

import csv
import dataclasses
import io
import itertools
import math
from collections.abc import Sequence
from typing import Any

from powered_walker_env.literature.values.checks import Row

COLUMNS = ("quantity", "published", "here", "difference", "allowed", "")


def table_text(rows: Sequence[Row]) -> str:
    """The table by walker and source, with a summary below."""
    cells = [_cells(row) for row in rows]
    widths = [max(len(c[i]) for c in [COLUMNS, *cells]) for i in range(len(COLUMNS))]
    lines = [_line(COLUMNS, widths)]
    for (walker, source), group in itertools.groupby(rows, lambda row: (row.walker, row.source)):
        lines += ["", walker, f"  [{source}]"]
        for row in group:
            lines.append(_line(_cells(row), widths))
            lines += [f"      {note}" for note in (row.differs, row.remark) if note]
    return "\n".join([*lines, "", summary(rows)])


def summary(rows: Sequence[Row]) -> str:
    """One line: how many agree, how many do not."""
    agree = sum(row.agrees for row in rows)
    explained = sum(row.passes and not row.agrees for row in rows)
    failed = sum(not row.passes for row in rows)
    return (
        f"{len(rows)} values: {agree} agree, {explained} differ for the reasons given, "
        f"{failed} fail"
    )


def _cells(row: Row) -> tuple[str, ...]:
    return (
        f"  {row.quantity}", row.published, row.ours, f"{row.difference:.1e}",
        f"{row.within:.1e}", row.verdict,
    )  # fmt: skip


def _line(cells: Sequence[str], widths: Sequence[int]) -> str:
    name, *values, verdict = cells
    middle = "  ".join(f"{v:>{w}}" for v, w in zip(values, widths[1:-1], strict=True))
    return f"{name:<{widths[0]}}  {middle}  {verdict}".rstrip()


def table_data(rows: Sequence[Row]) -> dict[str, Any]:
    """The table as plain data, ready for JSON (None for a difference from nothing found)."""
    return {
        "rows": [_plain(row) for row in rows],
        "values": len(rows),
        "agree": sum(row.agrees for row in rows),
        "differ_explained": sum(row.passes and not row.agrees for row in rows),
        "fail": sum(not row.passes for row in rows),
    }


def _plain(row: Row) -> dict[str, Any]:
    difference = row.difference if math.isfinite(row.difference) else None
    verdict = {"difference": difference, "passes": row.passes, "verdict": row.verdict}
    return dataclasses.asdict(row) | verdict


def table_csv(rows: Sequence[Row]) -> str:
    """The table as CSV, one line per value."""
    text = io.StringIO()
    names = [field.name for field in dataclasses.fields(Row)]
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow([*names, "verdict"])
    for row in rows:
        writer.writerow([*(getattr(row, name) for name in names), row.verdict])
    return text.getvalue()
