"""What is kept of a cell: one JSON file, written whole, from which all else is made."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from agents.runs import write_json
from agents.study.budgets import Budget
from agents.study.cells import Cell

CELLS, RUNS, BUDGET = "cells", "runs", "budget.json"  # in the folder of a study
DONE, REFUSED, FAILED = "done", "refused", "failed"


@dataclass(frozen=True)
class Record:
    """What became of a cell.

    A measure that was refused holds nothing but `refused`, the words.
    """

    cell: Cell
    status: str  # `DONE`; `REFUSED` by the controller or the training; `FAILED`: a fault here
    reason: str = ""  # why it was refused, or failed
    seconds: float = 0.0  # processor time of the measures
    measures: dict[str, dict[str, Any]] = field(default_factory=dict)
    training: dict[str, Any] = field(default_factory=dict)  # strides, seconds, learning curve
    machine: dict[str, Any] = field(default_factory=dict)  # versions, commit

    def get(self, measure: str, name: str) -> Any:
        """One value; None where the measure was refused or is not there."""
        return self.measures.get(measure, {}).get(name)


def path_of(out: Path, cell: Cell) -> Path:
    """Of a cell's file."""
    return out / CELLS / f"{cell.name}.json"


def save_record(out: Path, record: Record) -> None:
    """Write it, whole or not at all."""
    write_json(path_of(out, record.cell), asdict(record))


def load_record(path: Path) -> Record | None:
    """The record in a file; None if there is none, or it is damaged."""
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        return Record(**{**content, "cell": Cell(**content["cell"])})
    except (OSError, KeyError, TypeError, ValueError):
        return None


def load_records(out: Path, every: Iterable[Cell]) -> list[Record]:
    """Those of the cells that were done or refused, in this order."""
    found = [load_record(path_of(out, cell)) for cell in every]
    return [record for record in found if record is not None]


def is_done(out: Path, cell: Cell) -> bool:
    """Whether a cell need not be done again: those refused or failed are asked again."""
    record = load_record(path_of(out, cell))
    return record is not None and record.status == DONE


def open_study(out: Path, budget: Budget) -> None:
    """Make the folder of a study, or find that it is one of the same sizes.

    Raises:
        ValueError: it holds a study of other sizes, or cannot be made.
    """
    try:
        (out / CELLS).mkdir(parents=True, exist_ok=True)
        (out / RUNS).mkdir(exist_ok=True)
    except OSError as error:
        raise ValueError(
            f"the folder {str(out)!r} cannot be made ({error.strerror}); choose another --out"
        ) from error
    path = out / BUDGET
    if not path.is_file():
        write_json(path, budget.plain())
        return
    try:
        before = json.loads(path.read_text(encoding="utf-8"))
    except ValueError:
        before = {}
    if changed := _changed(before, budget.plain()):
        raise ValueError(
            f"{str(out)!r} holds a study of other sizes ({', '.join(changed)}); choose another "
            "--out, or remove it"
        )


def _changed(before: dict[str, Any], now: dict[str, Any]) -> Sequence[str]:
    return [name for name, value in now.items() if before.get(name) != value]
