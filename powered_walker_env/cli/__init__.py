"""The command line: `powered-walker gait`, `branch`, `basin`, `energetics`, `validate` and more.

Each command is a function from parsed arguments to a report, which `running` prints as text
or, with --json, as one JSON object, and saves and draws with --out.
"""

from __future__ import annotations

import argparse
import contextlib
import sys
from collections.abc import Sequence
from importlib.metadata import version

import numpy as np

from powered_walker_env.cli import (
    chances,
    compiling,
    costs,
    exploring,
    published,
    regions,
    robustness,
    studies,
    walking,
)
from powered_walker_env.cli.running import run_command, say_anything, told

PROG = "powered-walker"

__all__ = ["main", "run_command"]


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command; returns the exit status.

    0: done; 1: no gait, or a published value that fails; 2: a bad argument, or a file that
    cannot be written; 3: a fault of the program; 128 and more: stopped by a signal.
    """
    say_anything()
    given = sys.argv[1:] if arguments is None else arguments
    try:
        options = _parser().parse_args([_plain(argument) for argument in given])
    except SystemExit:  # --help, --version, or a usage error
        if status := told(PROG):
            sys.exit(status)
        raise
    return run_command(options.command, options, PROG)


def _plain(argument: str) -> str:
    """-1e-3 as -0.001: argparse takes a negative number for an option unless it is written so."""
    if argument.startswith("-"):
        with contextlib.suppress(ValueError):
            return str(np.format_float_positional(float(argument), trim="-"))
    return argument


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog=PROG, description="A nearly passive powered walker: walks, gaits and what becomes "
        "of them.",
    )  # fmt: skip
    parser.add_argument(
        "--version", action="version", version=f"%(prog)s {version('powered-walker-env')}"
    )
    commands = parser.add_subparsers(required=True, metavar="command")
    families = (
        walking,
        studies,
        regions,
        robustness,
        chances,
        costs,
        published,
        compiling,
        exploring,
    )
    for family in families:
        family.add_commands(commands)
    return parser
