"""One command from start to end: whatever happens, one line and an exit status.

Nothing ends in a traceback (but under `python -X dev`, for those who look for a fault): bad
arguments, full disks, closed pipes, narrow encodings, Ctrl-C and SIGTERM are met here for
every command.
"""

from __future__ import annotations

import argparse
import codecs
import contextlib
import json
import multiprocessing
import os
import signal
import sys
import unicodedata
from collections.abc import Callable, Iterator
from typing import Any

from powered_walker_env.cli.long import check_early
from powered_walker_env.cli.output import PictureError, Report, check_out, finite, put_out
from powered_walker_env.poincare import GaitNotFoundError, LostWorkersError
from powered_walker_env.signals import BY_SIGNAL, stop_signals

NOT_FOUND, USER_ERROR, FAULT = 1, 2, 3
PIPE_CLOSED = BY_SIGNAL + 13
EXPECTED = (ValueError, TypeError, ImportError, OSError, LostWorkersError, PictureError)

SIGNS = {"–": "-", "−": "-", "°": " deg", "·": " ", "√": "sqrt", "≥": ">=", "≤": "<=", "→": "->"}


class _Stopped(KeyboardInterrupt):
    """Ctrl-C or SIGTERM; whatever lets a KeyboardInterrupt clean up does so here, too."""

    def __init__(self, number: int) -> None:
        self.number = number


def run_command(
    command: Callable[[argparse.Namespace], Report],
    options: argparse.Namespace,
    prog: str = "powered-walker",
) -> int:
    """Run a command, save and print its report, or say what was wrong in one line."""
    say_anything()
    try:
        with _stoppable():
            check_out(options)
            check_early(options)
            report = put_out(options, command(options))
            data = json.dumps(finite(report.data), indent=2) if options.json else None
            return told(prog, data or report.text) or report.status
    except GaitNotFoundError as error:
        return failed(prog, str(error), NOT_FOUND)
    except MemoryError as error:
        return failed(prog, f"not enough memory: {error}; ask for less", USER_ERROR)
    except EXPECTED as error:
        return failed(prog, str(error), USER_ERROR)
    except KeyboardInterrupt as error:
        number = getattr(error, "number", signal.SIGINT)
        word = "interrupted" if number == signal.SIGINT else "terminated"
        resumable = getattr(options, "resumable", False) and options.out
        hint = "; the same command goes on from here" if resumable else ""
        return failed(prog, f"{word}{hint}", BY_SIGNAL + number)
    except Exception as error:
        if sys.flags.dev_mode:
            raise
        kind = type(error).__name__
        return failed(prog, f"this is a fault of the program, please report it: {kind}: {error}",
                      FAULT)  # fmt: skip


def failed(prog: str, message: str, status: int) -> int:
    """Say what was wrong in one line; the status."""
    with contextlib.suppress(OSError):
        print(f"{prog}: " + " ".join(message.split()), file=sys.stderr, flush=True)
    return status


def told(prog: str, text: str | None = None) -> int:
    """Print a text, and what is still to be written; 0, or the status if that is impossible."""
    try:
        if text is not None:
            print(text)
        if sys.stdout is not None:
            sys.stdout.flush()
    except BrokenPipeError:
        return _abandon(PIPE_CLOSED)
    except OSError as error:
        return failed(prog, f"the output cannot be written: {error}", _abandon(USER_ERROR))
    return 0


def _abandon(status: int) -> int:
    """Send what stdout still holds nowhere, or the interpreter complains as it ends."""
    with contextlib.suppress(OSError, ValueError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    return status


@contextlib.contextmanager
def _stoppable() -> Iterator[None]:
    """Ctrl-C and SIGTERM stop the command; a second one ends everything at once."""
    stopped: _Stopped | None = None

    def stop(number: int, frame: Any) -> None:
        nonlocal stopped
        if stopped:
            for worker in multiprocessing.active_children():
                worker.kill()
            os._exit(BY_SIGNAL + number)
        stopped = _Stopped(number)
        raise stopped

    with stop_signals(stop):
        try:
            yield
        except Exception as error:
            if stopped:  # what broke while things were put away is no fault of the user's
                raise stopped from error
            raise


def say_anything() -> None:
    """Let stdout spell what its encoding has no letter for: α as alpha, – as -."""
    codecs.register_error("spelled", _spelled)
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="spelled")


def _spelled(error: UnicodeError) -> tuple[str, int]:
    assert isinstance(error, UnicodeEncodeError)
    return "".join(map(_spell, error.object[error.start : error.end])), error.end


def _spell(letter: str) -> str:
    if letter in SIGNS:
        return SIGNS[letter]
    plain = unicodedata.normalize("NFKD", letter).encode("ascii", "ignore").decode()
    if plain or unicodedata.combining(letter):
        return plain
    words = unicodedata.name(letter, "?").split()
    return words[-1].lower() if "LETTER" in words else "?"
