"""Tables as text: aligned for people, CSV for spreadsheets."""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from io import StringIO
from typing import Any

import numpy as np
from numpy.typing import ArrayLike


def aligned(rows: Sequence[Sequence[str]], left: int = 1) -> list[str]:
    """Rows of cells as lines with columns of equal width, two spaces apart.

    Args:
        rows: of any length; a header is a row, and a row of one cell a heading of any width.
        left: columns that begin at the left, as names do; the others end at the right, as
            numbers do.
    """
    tabled = [row for row in rows if len(row) > 1]
    widths = [
        max(len(row[k]) for row in tabled if k < len(row))
        for k in range(max(map(len, tabled), default=0))
    ] or [0]
    return [
        "  ".join(
            cell.ljust(width) if k < left else cell.rjust(width)
            for k, (cell, width) in enumerate(zip(row, widths, strict=False))
        ).rstrip()
        for row in rows
    ]


def csv_text(columns: Mapping[str, ArrayLike]) -> str:
    """Columns of equal length as CSV; floats with all their digits, NaN as an empty cell."""
    text = StringIO()
    writer: Any = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    values = [np.asarray(column).tolist() for column in columns.values()]
    for row in zip(*values, strict=True):
        writer.writerow(["" if value != value else value for value in row])
    return text.getvalue()
