"""`python -m benchmarks`: how fast, how exactly, and beside whom."""

from __future__ import annotations

import argparse
import contextlib
import importlib.metadata
import json
import os
import platform
import re
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from benchmarks.environments import IDS, environments
from benchmarks.precision import RTOLS, check_rtols, precision
from benchmarks.processors import processors
from benchmarks.roofline import roofline
from benchmarks.scaling import scaling
from benchmarks.startup import startup
from benchmarks.strides import Problem, make_problem
from benchmarks.timing import Section
from benchmarks.training import training
from powered_walker_env.cli import run_command
from powered_walker_env.cli.output import Progress, Report, figures, finite
from powered_walker_env.files import write_text
from powered_walker_env.results import versions
from powered_walker_env.simulation.threads import cores

OPTIONAL = ("gymnasium", "heyoka", "stable-baselines3")
#: What is measured, from the problem, the tolerances and the seconds.
SECTIONS: dict[str, Callable[[Problem, Sequence[float], float], Section]] = {
    "precision": precision,
    "roofline": lambda problem, _, seconds: roofline(problem, seconds),
    "scaling": lambda problem, _, seconds: scaling(problem, seconds),
    "environments": lambda problem, _, seconds: environments(problem.name, seconds),
    "startup": lambda *_: startup(),
    "training": lambda problem, *_: training(problem.name),
    "processors": lambda problem, _, seconds: processors(problem, seconds),
}


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the benchmarks; returns the exit status."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks",
        description="Measure speed and accuracy beside other integrators, and what the machine "
        "allows.",
    )
    add = parser.add_argument
    add("--json", action="store_true", help="print one JSON object")
    add("--preset", default="camp1997", choices=IDS, help="(default %(default)s)")
    add("--only", nargs="+", choices=SECTIONS, metavar="SECTION", default=list(SECTIONS),
        help=f"some of {', '.join(SECTIONS)}; all if left out")  # fmt: skip
    add("--rtol", type=float, nargs="+", default=RTOLS,
        help="tolerances at which methods are compared "
        f"(default {' '.join(f'{rtol:.0e}' for rtol in RTOLS)})")  # fmt: skip
    add("--seconds", type=float, default=1.0,
        help="spent on each measurement (default %(default)s)")  # fmt: skip
    add("--out", metavar="FOLDER", help="write bench.json, bench.txt and the plots there; made")
    add("--overwrite", action="store_true", help="replace files that exist")
    return run_command(_bench, parser.parse_args(arguments), prog=parser.prog)


def _bench(options: argparse.Namespace) -> Report:
    if not 0 < options.seconds < float("inf"):
        raise ValueError(f"--seconds must be positive and finite, got {options.seconds!r}")
    check_rtols(options.rtol)
    _check_folder(options)
    ran_on, problem = machine(), make_problem(options.preset)
    chosen, found = [name for name in SECTIONS if name in options.only], {}
    with Progress("benchmarks") as progress:
        for done, name in enumerate(chosen):
            progress(done, len(chosen), float("nan"))
            found[name] = SECTIONS[name](problem, options.rtol, options.seconds)
    told = "\n".join(f"{name}: {value}" for name, value in ran_on.items())
    text = "\n\n".join([told, *(section.text for section in found.values())])
    data = {"machine": ran_on, "preset": options.preset, "seconds": options.seconds}
    data |= {name: section.data for name, section in found.items()}
    if options.out is None:
        return Report(text, data)
    return Report(*_written(Path(options.out), text, data, found))


def machine() -> dict[str, Any]:
    """Processor, cores, load and versions."""
    try:
        described = Path("/proc/cpuinfo").read_text(encoding="utf-8")
    except OSError:  # another system than Linux
        described = ""
    name = re.search(r"^model name\s*: (.*)$", described, re.MULTILINE)
    found = dict(versions())  # the original is shared
    for other in OPTIONAL:
        with contextlib.suppress(importlib.metadata.PackageNotFoundError):
            found[other] = importlib.metadata.version(other)
    return {
        "processor": name[1] if name else platform.processor() or platform.machine(),
        "cores": cores(),
        "load": os.getloadavg()[0] if hasattr(os, "getloadavg") else None,
        "versions": found,
    }


def _check_folder(options: argparse.Namespace) -> None:
    """Find out before the work begins whether its results can be put where they should go."""
    if options.out is None:
        return
    folder = Path(options.out)
    if folder.exists() and not folder.is_dir():
        raise FileExistsError(f"{str(folder)!r} is not a folder; choose another name")
    if folder.exists() and not options.overwrite:
        raise FileExistsError(
            f"{str(folder)!r} exists already; choose another --out, or --overwrite"
        )
    if not folder.absolute().parent.is_dir():
        raise FileNotFoundError(f"the folder {str(folder.parent)!r} does not exist; make it first")
    figures()


def _written(
    folder: Path, text: str, data: dict[str, Any], found: dict[str, Section]
) -> tuple[str, dict[str, Any]]:
    """The report as text and JSON, then the plots with their numbers; each file whole."""
    folder.mkdir(exist_ok=True)
    written = [folder / "bench.txt", folder / "bench.json"]
    write_text(written[0], text + "\n")
    write_text(written[1], json.dumps(finite(data), indent=2) + "\n")
    for section in found.values():
        for name, drawing in section.draw().items():
            written += figures().save_drawing(drawing, folder / name)
    files = [str(path) for path in written]
    return f"{text}\n\nwritten: {', '.join(files)}", {**data, "written": files}


if __name__ == "__main__":
    sys.exit(main())
