"""The command line: `powered-walker gait`, `branch`, `basin`, `energetics`, `validate` and more.

Each command is a function from parsed arguments to a report that can be printed as text
or, with --json, as one JSON object; with --out what was found is saved and drawn.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable, Sequence
from importlib.metadata import version

from powered_walker_env.cli import energetics, regions, studies, validate, walking
from powered_walker_env.cli.output import Report, finite
from powered_walker_env.poincare import GaitNotFoundError
from powered_walker_env.poincare.work.interruption import interruptible

NOT_FOUND, USER_ERROR, INTERRUPTED = 1, 2, 130


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command; returns the exit status (2 for a bad argument, 1 for no or a bad result)."""
    options = _parser().parse_args(arguments)
    return run_command(options.command, options)


def run_command(
    command: Callable[[argparse.Namespace], Report],
    options: argparse.Namespace,
    prog: str = "powered-walker",
) -> int:
    """Run a command and print its report, or what was wrong in one line."""
    try:
        with interruptible():
            report = command(options)
    except GaitNotFoundError as error:
        return _failed(prog, str(error), NOT_FOUND)
    except (ValueError, TypeError, ImportError, OSError) as error:
        return _failed(prog, str(error), USER_ERROR)
    except KeyboardInterrupt:
        resumable = getattr(options, "resumable", False) and options.out
        hint = "; the same command goes on from here" if resumable else ""
        return _failed(prog, f"interrupted{hint}", INTERRUPTED)
    text = json.dumps(finite(report.data), indent=2) if options.json else report.text
    print(text)
    return report.status


def _failed(prog: str, message: str, status: int) -> int:
    print(f"{prog}: " + " ".join(message.split()), file=sys.stderr)
    return status


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="powered-walker",
        description="A nearly passive powered walker: walks, gaits and what becomes of them.",
    )
    parser.add_argument(
        "--version", action="version", version=f"%(prog)s {version('powered-walker-env')}"
    )
    commands = parser.add_subparsers(required=True, metavar="command")
    for family in (walking, studies, regions, energetics, validate):
        family.add_commands(commands)
    return parser
