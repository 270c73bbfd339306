"""`powered-walker explore`: a walker to play with, in the browser."""

from __future__ import annotations

import argparse
import sys
import webbrowser
from typing import Any

from powered_walker_env.cli.options import add_command, add_preset
from powered_walker_env.cli.output import Report
from powered_walker_env.envs.arguments import TaskArguments
from powered_walker_env.envs.setup import make_task

PORTS = 65535


def add_commands(commands: Any) -> None:
    """Add this family's commands."""
    explore = add_command(
        commands, "explore", _explore,
        "play with a walker in the browser: push it, change it, see what follows; until Ctrl-C",
    )  # fmt: skip
    add_preset(explore, "round-foot")
    explore.add_argument(
        "--controller", action="append", default=[], metavar="SOURCE",
        help="offer one more than the package has: a policy (.npz), a model of "
        "Stable-Baselines3 (.zip), the folder of a training, or module:function; may be given "
        "more than once",
    )  # fmt: skip
    explore.add_argument(
        "--port", type=int, default=0, help="of this machine (default: any that is free)"
    )
    explore.add_argument("--no-browser", action="store_true", help="do not open a browser")


def _explore(options: argparse.Namespace) -> Report:
    from powered_walker_env.explore.choice import Choice
    from powered_walker_env.explore.server import import_bokeh, serve

    if not 0 <= options.port <= PORTS:
        raise ValueError(f"--port must lie in 0 to {PORTS}, got {options.port!r}")
    import_bokeh()
    choice = Choice.of_preset(options.preset)
    _check_controllers(options.controller, options.preset)

    def ready(address: str) -> None:
        print(f"explore at {address} (Ctrl-C ends it)", file=sys.stderr, flush=True)
        if not options.no_browser:
            webbrowser.open(address)

    serve(choice, options.controller, options.port, ready=ready)
    return Report("", {})


def _check_controllers(sources: list[str], preset: str) -> None:
    """Refuse a controller that cannot be loaded before there is a page.

    Raises:
        ValueError, TypeError, OSError, ImportError: as `load_controller`.
    """
    from powered_walker_env.controllers import load_controller

    for source in sources:
        load_controller(source, make_task(TaskArguments(preset=preset)))
