"""Arguments of commands that take long: where their pieces run, and how finely curves are followed.

What is wrong with them is said before anything is computed.
"""

from __future__ import annotations

import argparse

from powered_walker_env.poincare.branches.arclength import check_step
from powered_walker_env.poincare.work import check_workers


def add_running(parser: argparse.ArgumentParser) -> None:
    """Arguments that choose where pieces of work run."""
    parser.add_argument(
        "--backend", default="loky", choices=("loky", "threading", "dask", "ray"),
        help="what runs the pieces (default %(default)s: processes on this machine)",
    )  # fmt: skip
    parser.add_argument("--address", help="of a running Dask or Ray cluster")
    parser.add_argument("--jobs", type=int, help="workers; all cores if left out")


def add_longest_step(parser: argparse.ArgumentParser, default: float | None = None) -> None:
    """The argument that says how finely a curve of gaits is followed."""
    usual = "" if default is None else " (default %(default)s)"
    parser.add_argument(
        "--step", type=float, default=default, dest="longest_step", metavar="STEP",
        help=f"longest step, as a share of the bounds' widths{usual}",
    )  # fmt: skip


def check_early(options: argparse.Namespace) -> None:
    """Refuse workers and steps that there cannot be before the gait is looked for.

    Raises:
        ValueError: naming the argument.
    """
    if "backend" in options:
        check_workers(options.backend, options.address, options.jobs)
    if "longest_step" in options:
        check_step(options.longest_step)
