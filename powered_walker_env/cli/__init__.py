"""The command line: `powered-walker gait`, `branch`, `basin`, `energetics`, `validate` and more.

Each command is a function from parsed arguments to a report that can be printed as text
or, with --json, as one JSON object; with --out what was found is saved and drawn.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from importlib.metadata import version
from types import FrameType

from powered_walker_env.cli import energetics, regions, studies, validate, walking
from powered_walker_env.cli.output import Report, finite
from powered_walker_env.poincare import GaitNotFoundError

NOT_FOUND, USER_ERROR, BY_SIGNAL = 1, 2, 128


class _Stopped(KeyboardInterrupt):
    """Ctrl-C or SIGTERM."""

    def __init__(self, number: int) -> None:
        self.number = number


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
        with _stoppable():
            report = command(options)
    except GaitNotFoundError as error:
        return _failed(prog, str(error), NOT_FOUND)
    except (ValueError, TypeError, ImportError, OSError) as error:
        return _failed(prog, str(error), USER_ERROR)
    except KeyboardInterrupt as error:
        number = getattr(error, "number", signal.SIGINT)
        word = "interrupted" if number == signal.SIGINT else "terminated"
        resumable = getattr(options, "resumable", False) and options.out
        hint = "; the same command goes on from here" if resumable else ""
        return _failed(prog, f"{word}{hint}", BY_SIGNAL + number)
    text = json.dumps(finite(report.data), indent=2) if options.json else report.text
    print(text)
    return report.status


@contextlib.contextmanager
def _stoppable() -> Iterator[None]:
    """Ctrl-C and SIGTERM stop the command; a second one ends it at once, and its workers."""
    if threading.current_thread() is not threading.main_thread():
        yield  # signals come to the main thread only
        return
    stopping = False

    def stop(number: int, _: FrameType | None) -> None:
        nonlocal stopping
        if stopping:
            os._exit(BY_SIGNAL + number)
        stopping = True
        raise _Stopped(number)

    before = {number: signal.signal(number, stop) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


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
