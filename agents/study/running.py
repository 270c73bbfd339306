"""All cells of a study, on all cores: trained, measured, kept; again, what is left."""

from __future__ import annotations

import functools
import time
import traceback
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

from agents.runs import alone, provenance
from agents.study.budgets import Budget
from agents.study.cells import Cell
from agents.study.measures import measured
from agents.study.records import (
    DONE,
    FAILED,
    REFUSED,
    RUNS,
    Record,
    is_done,
    open_study,
    save_record,
)
from agents.study.subject import Subject
from agents.study.training import Training, own_pickles, trained
from powered_walker_env.controllers import load_controller
from powered_walker_env.controllers.evaluation import task_of
from powered_walker_env.poincare import run_pieces
from powered_walker_env.simulation.threads import at_most

LOCK = ".lock"
LATER = "later"  # the status of a cell that was not begun
Note = Callable[[int, int, float], None]


class End(NamedTuple):
    """What became of a cell in this run."""

    name: str
    status: str
    reason: str


@dataclass(frozen=True)
class Plan:
    """How a study is run."""

    budget: Budget
    out: Path
    deadline: float = float("inf")  # s of `time.time`, after which no cell is begun


def run_study(
    every: Sequence[Cell], plan: Plan, jobs: int = 2, progress: Note | None = None
) -> list[End]:
    """Do the cells that are not done yet; each is kept as soon as it is.

    Args:
        progress: called after each with cells done, cells in all, seconds left.

    Raises:
        ValueError: a folder of another study, or one in which a study is running.
    """
    open_study(plan.out, plan.budget)
    with alone(plan.out / LOCK, f"a study is running in {str(plan.out)!r}"):
        left = [cell for cell in every if not is_done(plan.out, cell)]
        work = functools.partial(run_cell, plan=plan)
        return run_pieces(work, left, jobs=jobs, progress=progress) if left else []


def run_cell(cell: Cell, plan: Plan) -> End:
    """One cell: trained, measured, kept. Its own faults are kept, too, and stop no other."""
    if time.time() >= plan.deadline:
        return End(cell.name, LATER, "")
    with at_most(1), own_pickles():
        record = _record(cell, plan)
    save_record(plan.out, record)
    return End(cell.name, record.status, record.reason)


def _record(cell: Cell, plan: Plan) -> Record:
    training: dict[str, Any] = {}
    machine, began = provenance(), time.process_time()
    try:
        task = task_of(cell.env_id, **cell.env_kwargs)
        source: Any = cell.controller
        if cell.learns:
            done: Training = trained(cell, plan.budget, plan.out / RUNS)
            training, source = done.plain(), done.folder
            began = time.process_time()
        _, controller = load_controller(source, task, cell.env_id)
    except (TypeError, ValueError, FileNotFoundError, ImportError) as error:
        return Record(cell, REFUSED, _words(error), training=training, machine=machine)
    except Exception:
        return Record(cell, FAILED, traceback.format_exc(), training=training, machine=machine)
    try:
        found = measured(Subject(cell, task, controller, plan.budget.of(cell.controller)))
    except Exception:
        return Record(cell, FAILED, traceback.format_exc(), training=training, machine=machine)
    seconds = time.process_time() - began
    return Record(cell, DONE, "", seconds, found, training, machine)


def _words(error: Exception) -> str:
    return " ".join(str(error).split())
