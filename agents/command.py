"""What the commands share: user errors without tracebacks, `key:value` arguments, environments."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import gymnasium as gym
import yaml

from powered_walker_env import ENVIRONMENTS, PoweredWalkerVectorEnv

CONFIGS = Path(__file__).parent.parent / "configs"
ROUND_FOOT = "PoweredWalkerRoundFoot-v0"
EPISODE_SEED = 10_000  # of evaluations: the small seeds are those of trainings
USER_ERROR = 2  # exit status, as argparse has it


class UserError(Exception):
    """Something the user can put right; the message says what and how."""


def exit_status(command: Callable[[], None]) -> int:
    """Run a command; a user error goes to stderr and makes the status 2."""
    try:
        command()
    except UserError as error:
        print(f"error: {error}", file=sys.stderr)
        return USER_ERROR
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        return 130
    return 0


def make_walkers(env_id: str, count: int, **env_kwargs: Any) -> PoweredWalkerVectorEnv:
    """N walkers of a registered environment.

    Raises:
        UserError: an unknown environment, one of another package, or arguments it does
            not take.
    """
    try:
        envs = gym.make_vec(
            env_id, count, vectorization_mode="vector_entry_point", **env_kwargs
        ).unwrapped
    except (ValueError, TypeError, gym.error.Error) as error:
        raise UserError(
            f"environment {env_id!r} with {env_kwargs or 'no arguments'}: {error}"
        ) from error
    if not isinstance(envs, PoweredWalkerVectorEnv):
        raise UserError(f"env must be one of {', '.join(ENVIRONMENTS)}, got {env_id!r}")
    return envs


def pairs(texts: Sequence[str] | None) -> dict[str, Any]:
    """`["disturbance:rough", "effort_weight:0.1"]` as a dictionary; values are YAML.

    Raises:
        UserError: a text without a colon, or a value that is not YAML.
    """
    result: dict[str, Any] = {}
    for text in texts or ():
        key, colon, value = text.partition(":")
        if not colon or not key:
            raise UserError(f"arguments must look like key:value, got {text!r}")
        try:
            result[key] = yaml.safe_load(value)
        except yaml.YAMLError as error:
            raise UserError(f"the value of {key!r} must be YAML, got {value!r}") from error
    return result


def add_env_arguments(parser: argparse.ArgumentParser, default: str | None = ROUND_FOOT) -> None:
    """The options `--env` and `--env-kwargs`; default None shows whether it was given."""
    parser.add_argument(
        "--env",
        default=default,
        metavar="ID",
        help=f"environment: {', '.join(ENVIRONMENTS)}, or one of your own of the same class "
        f"(default: {ROUND_FOOT})",
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
    except ValueError:
        number = 0.0
    if number < 1 or number != int(number):
        raise argparse.ArgumentTypeError(f"must be a positive integer, got {text!r}")
    return int(number)


def natural_int(text: str) -> int:
    """An argparse type: an integer of at least 0."""
    if not text.isdecimal():
        raise argparse.ArgumentTypeError(f"must be an integer of at least 0, got {text!r}")
    return int(text)
