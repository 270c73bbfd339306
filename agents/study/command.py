"""Run the control study, or what is left of it; then tables, figures and policies.

Every cell is a file in OUT/cells, every training a run in OUT/runs. Ctrl-C loses what is under way
only back to its last checkpoint; the same command goes on.
"""

from __future__ import annotations

import argparse
import time
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

from tqdm import tqdm

from agents.command import positive_int
from agents.runs import RUNS
from agents.study.budgets import FULL, SMALL
from agents.study.cells import Cell, cells, chosen
from agents.study.publishing import publish, report
from agents.study.records import FAILED, is_done, load_records
from agents.study.running import LATER, End, Plan, run_study

MINUTES = 120


def parser() -> argparse.ArgumentParser:
    """The command line."""
    result = argparse.ArgumentParser(
        prog="python -m agents.study", description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )  # fmt: skip
    result.add_argument("--out", type=Path, help="its folder (default: runs/study, or study-small)")
    result.add_argument(
        "--jobs", type=positive_int, default=2, help="cells at once (default: %(default)s)"
    )
    result.add_argument(
        "--only", nargs="+", metavar="TEXT",
        help="cells with one of these in their names, as in RoundFoot-v0-light or ppo",
    )  # fmt: skip
    result.add_argument("--small", action="store_true", help="tiny budgets: a trial of the code")
    result.add_argument(
        "--minutes", type=positive_int, default=MINUTES,
        help="after which no cell is begun (default: %(default)s)",
    )  # fmt: skip
    result.add_argument("--list", action="store_true", help="list the cells, and do none")
    result.add_argument(
        "--publish", action="store_true",
        help="put tables and figures into docs/benchmark, policies into the package, the commands "
        "into agents/README.md",
    )  # fmt: skip
    return result


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command.

    Raises:
        ValueError: bad arguments, or cells that failed.
    """
    options = parser().parse_args(arguments)
    budget = SMALL if options.small else FULL
    if options.small and options.publish:
        raise ValueError("--publish must be left out with --small, whose results mean nothing")
    out = options.out or RUNS / ("study-small" if options.small else "study")
    every = cells(budget)
    some = chosen(every, options.only)
    if options.list:
        _list(out, some)
        return
    began = time.monotonic()
    plan = Plan(budget, out, time.time() + 60.0 * options.minutes)
    with tqdm(total=len(some), unit=" cells", disable=None) as bar:

        def progress(done: int, total: int, _: float) -> None:
            bar.total = total
            bar.update(done - bar.n)

        try:
            ends = run_study(some, plan, options.jobs, progress)
        except KeyboardInterrupt:
            raise KeyboardInterrupt("stopped; the same command goes on") from None
    records = load_records(out, every)
    print(_told(ends, len(records), len(every), (time.monotonic() - began) / 60.0))
    print(f"tables and figures: {report(records, budget, out)}")
    failed = [end for end in ends if end.status == FAILED]
    if options.publish:
        for path in publish(records, budget, out):
            print(path)
    if failed:
        raise ValueError(
            f"{len(failed)} cells failed, {failed[0].name} first: {failed[0].reason.strip()}"
        )


def _list(out: Path, some: Sequence[Cell]) -> None:
    for cell in some:
        print(f"{'done' if is_done(out, cell) else 'left'}  {cell.name}")


def _told(ends: Sequence[End], kept: int, total: int, minutes: float) -> str:
    counts = Counter(end.status for end in ends)
    lines = [f"{minutes:.1f} minutes; cells kept: {kept} of {total}"]
    lines += [f"  {count} {status}" for status, count in sorted(counts.items())]
    if counts[LATER]:
        lines.append("  the time is up: the same command goes on")
    lines += [
        f"  {end.name}: {end.reason}" for end in ends if end.status not in (LATER, FAILED)
        and end.reason
    ]  # fmt: skip
    return "\n".join(lines)
