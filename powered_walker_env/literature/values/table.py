"""The table of published values, by kind of origin: for people, spreadsheets and programs."""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Sequence
from typing import Any

from powered_walker_env.literature.values.published import Kind
from powered_walker_env.literature.values.rows import Row
from powered_walker_env.tabular import aligned, csv_text

COLUMNS = ("quantity", "published", "here", "difference", "allowed", "")


def table_text(rows: Sequence[Row]) -> str:
    """A table for each kind, by walker and source; with a summary below."""
    head, *lines = aligned([COLUMNS, *(_cells(row) for row in rows)])
    told = sorted(zip(rows, lines, strict=True), key=lambda pair: list(Kind).index(pair[0].kind))
    text = []
    for kind, of_kind in itertools.groupby(told, lambda pair: pair[0].kind):
        text += [kind.upper(), "", head]
        for _, group in itertools.groupby(of_kind, lambda pair: (pair[0].walker, pair[0].source)):
            pairs = list(group)
            text += ["", pairs[0][0].walker, f"  [{pairs[0][0].source}]"]
            for row, line in pairs:
                text += [line, *(f"      {note}" for note in (row.differs, row.remark) if note)]
        text += ["", ""]
    return "\n".join([*text, *summary(rows)])


def summary(rows: Sequence[Row]) -> list[str]:
    """How many agree, how many do not: of each kind, and of all."""
    lines = []
    for title, counts in [*_by_kind(rows).items(), ("in all", _counts(rows))]:
        lines.append(
            f"{title}: {counts['values']} values, {counts['agree']} agree, "
            f"{counts['differ_explained']} differ for the reasons given, {counts['fail']} fail"
        )
    return lines


def table_data(rows: Sequence[Row]) -> dict[str, Any]:
    """The table as plain data, ready for JSON (None for a difference from nothing found)."""
    return {"rows": [_plain(row) for row in rows], **_counts(rows), "by_kind": _by_kind(rows)}


def table_csv(rows: Sequence[Row]) -> str:
    """The table as CSV, one line per value."""
    names = [field.name for field in dataclasses.fields(Row)] + ["verdict"]
    return csv_text({name: [str(getattr(row, name)) for row in rows] for name in names})


def _counts(rows: Sequence[Row]) -> dict[str, int]:
    return {
        "values": len(rows),
        "agree": sum(row.agrees for row in rows),
        "differ_explained": sum(row.passes and not row.agrees for row in rows),
        "fail": sum(not row.passes for row in rows),
    }


def _by_kind(rows: Sequence[Row]) -> dict[str, dict[str, int]]:
    """The same of each kind that there is, by its title."""
    kinds = [kind for kind in Kind if any(row.kind is kind for row in rows)]
    return {kind: _counts([row for row in rows if row.kind is kind]) for kind in kinds}


def _cells(row: Row) -> tuple[str, ...]:
    return (
        f"  {row.quantity}", row.published, row.ours, f"{row.difference:.1e}",
        f"{row.within:.1e}", row.verdict,
    )  # fmt: skip


def _plain(row: Row) -> dict[str, Any]:
    difference = row.difference if math.isfinite(row.difference) else None
    verdict = {"difference": difference, "passes": row.passes, "verdict": row.verdict}
    return dataclasses.asdict(row) | verdict
