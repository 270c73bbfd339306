"""`python -m benchmarks`: how fast, how exactly, and beside whom."""

from __future__ import annotations

import argparse
import dataclasses
import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from benchmarks.environments import CROWD, environment_of, environments
from benchmarks.machine import machine
from benchmarks.precision import RTOLS, check_rtols, precision
from benchmarks.problem import Problem, make_problem
from benchmarks.roofline import roofline
from benchmarks.scaling import scaling
from benchmarks.startup import startup
from benchmarks.tables import (
    environments_text,
    machine_text,
    precision_text,
    roofline_text,
    scaling_text,
    startup_text,
)
from benchmarks.timing import check_seconds
from powered_walker_env.cli import run_command
from powered_walker_env.cli.output import Progress, Report, figures, finite
from powered_walker_env.files import write_text
from powered_walker_env.model.presets import PRESETS
from powered_walker_env.model.walker import CONSERVING

SECTIONS = ("precision", "roofline", "scaling", "environments", "startup")
WALKERS = [
    name
    for name, preset in PRESETS.items()
    if preset.params.physics == CONSERVING and preset.control is not None
]


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the benchmarks; returns the exit status."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks",
        description="Measure speed and accuracy beside other integrators, and what the machine "
        "allows.",
    )
    _add_arguments(parser)
    return run_command(_bench, parser.parse_args(arguments), prog=parser.prog)


def _add_arguments(bench: argparse.ArgumentParser) -> None:
    bench.add_argument("--json", action="store_true", help="print one JSON object")
    bench.add_argument(
        "--preset", default=WALKERS[0], choices=WALKERS, help="(default %(default)s)"
    )
    bench.add_argument(
        "--only", nargs="+", choices=SECTIONS, metavar="SECTION", default=SECTIONS,
        help=f"some of {', '.join(SECTIONS)}; all if left out",
    )  # fmt: skip
    bench.add_argument(
        "--rtol", type=float, nargs="+", default=RTOLS,
        help="tolerances at which methods are compared "
        f"(default {' '.join(f'{rtol:.0e}' for rtol in RTOLS)})",
    )  # fmt: skip
    bench.add_argument(
        "--seconds", type=float, default=1.0,
        help="spent on each measurement (default %(default)s)",
    )  # fmt: skip
    bench.add_argument(
        "--walkers", type=int, default=CROWD,
        help="in the largest batch of environments (default %(default)s)",
    )  # fmt: skip
    bench.add_argument(
        "--out", metavar="FOLDER", help="write bench.json, bench.txt and the plots there; made"
    )
    bench.add_argument("--overwrite", action="store_true", help="replace files that exist")
    bench.add_argument("--no-plot", action="store_true", help="write the numbers only")


def _bench(options: argparse.Namespace) -> Report:
    check_seconds(options.seconds)
    check_rtols(options.rtol)
    if options.walkers < 1:
        raise ValueError(f"--walkers must be at least 1, got {options.walkers!r}")
    if "environments" in options.only:
        environment_of(options.preset)
    _check_folder(options)
    ran_on = machine()
    found, texts = _measure(options)
    report = Report(
        "\n\n".join([machine_text(ran_on), *texts.values()]),
        {"machine": ran_on, "preset": options.preset, "seconds": options.seconds}
        | {name: dataclasses.asdict(result) for name, result in found.items()},
    )
    return report if options.out is None else _write(options, report, found)


def _measure(options: argparse.Namespace) -> tuple[dict[str, Any], dict[str, str]]:
    """What the sections asked for found, and their tables."""
    seconds = options.seconds
    work: dict[str, tuple[Callable[[Problem], Any], Callable[[Any], str]]] = {
        "precision": (lambda p: precision(p, options.rtol, seconds), precision_text),
        "roofline": (lambda p: roofline(p, seconds), roofline_text),
        "scaling": (lambda p: scaling(p, seconds), scaling_text),
        "environments": (
            lambda p: environments(p.name, seconds, options.walkers), environments_text,
        ),
        "startup": (lambda _: startup(), startup_text),
    }  # fmt: skip
    chosen = [name for name in SECTIONS if name in options.only]
    found, texts = {}, {}
    problem = make_problem(options.preset)
    with Progress("bench") as progress:
        for i, name in enumerate(chosen):
            progress(i, len(chosen), float("nan"))
            measure, tell = work[name]
            found[name] = measure(problem)
            texts[name] = tell(found[name])
    return found, texts


def _check_folder(options: argparse.Namespace) -> None:
    """Find out before the work begins whether its results can be put where they should go."""
    if options.out is None:
        return
    folder = Path(options.out)
    if folder.exists() and not options.overwrite:
        raise FileExistsError(
            f"{str(folder)!r} exists already; choose another --out, or --overwrite"
        )
    if folder.exists() and not folder.is_dir():
        raise FileExistsError(f"{str(folder)!r} is not a folder; choose another name")
    if not folder.absolute().parent.is_dir():
        raise FileNotFoundError(f"the folder {str(folder.parent)!r} does not exist; make it first")
    if not options.no_plot:
        figures()


def _write(options: argparse.Namespace, report: Report, found: dict[str, Any]) -> Report:
    """The report as text and JSON, the plots with their numbers; each file whole."""
    folder = Path(options.out)
    folder.mkdir(exist_ok=True)
    written = [folder / "bench.txt", folder / "bench.json"]
    write_text(written[0], report.text + "\n")
    write_text(written[1], json.dumps(finite(report.data), indent=2) + "\n")
    if not options.no_plot:
        from benchmarks.drawings import precision_figure, scaling_figure

        if "precision" in found:
            drawing = precision_figure(found["precision"])
            written += figures().save_drawing(drawing, folder / "work_precision")
        if "scaling" in found:
            written += figures().save_drawing(scaling_figure(found["scaling"]), folder / "scaling")
    files = [str(path) for path in written]
    return Report(
        f"{report.text}\n\nwritten: {', '.join(files)}", {**report.data, "written": files}
    )
