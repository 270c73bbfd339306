"""What the commands share: one-line errors, `key:value` arguments, environments, stopping."""

from __future__ import annotations

import argparse
import contextlib
import signal
import sys
import warnings
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from types import FrameType
from typing import Any

import gymnasium as gym
import yaml

from powered_walker_env import ENVIRONMENTS, GaitNotFoundError
from powered_walker_env.signals import STOPPING, status_of_stop, stop_signals

CONFIGS = Path(__file__).parent.parent / "configs"
ROUND_FOOT = "PoweredWalkerRoundFoot-v0"
USER_ERROR = 2  # an exit status, as argparse has it
#: What a user can put right; the message says what and how.
_USERS = (ValueError, TypeError, ImportError, OSError, MemoryError, GaitNotFoundError)


def exit_status(command: Callable[[], None]) -> int:
    """Run a command; what the user can put right is one line on stderr and status 2.

    SIGTERM is Ctrl-C, but for the status: 143 in place of 130.
    """
    warnings.formatwarning = lambda message, *_, **__: f"note: {message}\n"
    try:
        with stop_signals(signal.default_int_handler):
            command()
    except (*_USERS, gym.error.Error) as error:
        print("error: " + " ".join(str(error).split()), file=sys.stderr)
        return USER_ERROR
    except KeyboardInterrupt as stopped:
        print(str(stopped) or "interrupted", file=sys.stderr)
        return status_of_stop()
    return 0


@contextlib.contextmanager
def polite_stop(request: Callable[[], None]) -> Iterator[None]:
    """Ctrl-C (or SIGTERM) asks once, and interrupts the second time."""

    def handle(number: int, frame: FrameType | None) -> None:
        request()
        for again in STOPPING:
            signal.signal(again, signal.default_int_handler)
        print("\nstopping after this rollout; again to stop at once", file=sys.stderr)

    with stop_signals(handle):
        yield


def pairs(texts: Sequence[str] | None) -> dict[str, Any]:
    """`["disturbance:rough", "effort_weight:0.1"]` as a dictionary; values are YAML.

    Raises:
        ValueError: a text without a colon, or a value that is not YAML.
    """
    result: dict[str, Any] = {}
    for text in texts or ():
        key, colon, value = text.partition(":")
        if not colon or not key:
            raise ValueError(f"arguments must look like key:value, got {text!r}")
        try:
            result[key] = yaml.safe_load(value)
        except yaml.YAMLError as error:
            raise ValueError(f"the value of {key!r} must be YAML, got {value!r}") from error
    return result


def read_yaml(path: Path) -> Any:
    """The content of a YAML file (UTF-8).

    Raises:
        ValueError: a file that cannot be read, or is not YAML.
    """
    try:
        return yaml.safe_load(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise ValueError(f"the configuration {str(path)!r} cannot be read: {error}") from error
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise ValueError(f"the configuration {str(path)!r} is not YAML: {error}") from error


def add_env_arguments(parser: argparse.ArgumentParser, default: str | None = ROUND_FOOT) -> None:
    """The options `--env` and `--env-kwargs`; default None shows whether it was given."""
    parser.add_argument(
        "--env",
        default=default,
        metavar="ID",
        help=f"environment: {', '.join(ENVIRONMENTS)}, or one of your own of the same class, "
        f"as module:ID (default: {ROUND_FOOT})",
    )
    parser.add_argument(
        "--env-kwargs",
        nargs="+",
        metavar="KEY:VALUE",
        help="arguments of the environment, as in disturbance:rough reward:contraction",
    )


def positive_int(text: str) -> int:
    """An argparse type: an integer of at least 1; `2e5` is one, too."""
    try:
        number = float(text)
        whole = number >= 1 and number == int(number)
    except (ValueError, OverflowError):
        whole = False
    if not whole:
        raise argparse.ArgumentTypeError(f"must be a positive integer, got {text!r}")
    return int(number)


def natural_int(text: str) -> int:
    """An argparse type: an integer of at least 0."""
    if not text.isdecimal():
        raise argparse.ArgumentTypeError(f"must be an integer of at least 0, got {text!r}")
    return int(text)
