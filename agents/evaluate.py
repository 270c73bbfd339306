"""Evaluate controllers and saved policies on equal disturbances.

Episode i of every controller has the same seed, so all meet the same pushes; they differ
by what they make of them.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from agents.command import add_env_arguments, exit_status, natural_int, pairs, positive_int
from agents.runs import write_json
from powered_walker_env.controllers import (
    EPISODE_SEED,
    comparison,
    comparison_text,
    evaluate,
    load_controller,
)
from powered_walker_env.controllers.evaluation import task_of
from powered_walker_env.controllers.loading import KINDS
from powered_walker_env.files import check_writable


def parser() -> argparse.ArgumentParser:
    """The command line."""
    result = argparse.ArgumentParser(prog="python -m agents.evaluate", description=__doc__)
    result.add_argument(
        "controllers",
        nargs="+",
        metavar="CONTROLLER",
        help=f"{KINDS}; the others are compared with the first",
    )
    add_env_arguments(result)
    result.add_argument(
        "--disturbance",
        nargs="+",
        metavar="LEVEL",
        help="levels: none, light, rough, light-ground, ... (default: the environment's own)",
    )
    result.add_argument(
        "--episodes", type=positive_int, default=200, help="of each (default: %(default)s)"
    )
    result.add_argument(
        "--seed",
        type=natural_int,
        default=EPISODE_SEED,
        help="of the first episode (default: %(default)s, none of a training's)",
    )
    result.add_argument("--out", type=Path, metavar="FILE", help="write the results there as JSON")
    result.add_argument("--overwrite", action="store_true", help="replace FILE if it exists")
    return result


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command."""
    options = parser().parse_args(arguments)
    if options.out is not None:
        check_writable([options.out], options.overwrite)
    env_kwargs = pairs(options.env_kwargs)
    if options.disturbance and "disturbance" in env_kwargs:
        raise ValueError("give the disturbance by --disturbance or --env-kwargs, not by both")
    named = [{"disturbance": level} for level in options.disturbance or ()]
    cases = [{**env_kwargs, **case} for case in named or [{}]]
    tasks = [task_of(options.env, **case) for case in cases]  # says now what is wrong with them
    chosen = [[load_controller(text, task, options.env) for text in options.controllers]
              for task in tasks]  # fmt: skip
    results = []
    for case, controllers in zip(cases, chosen, strict=True):
        evaluations = {}
        for text, (name, controller) in zip(options.controllers, controllers, strict=True):
            label = f"{name} ({text})" if name in evaluations else name
            evaluations[label] = evaluate(
                controller, options.env, options.episodes, options.seed, **case
            )
        level = case.get("disturbance", "as registered")
        print(comparison_text(evaluations, f"{options.env}, disturbance {level}"))
        results.append(comparison(evaluations))
    if options.out is not None:
        write_json(options.out, results)
        print(f"results: {options.out}")


if __name__ == "__main__":
    sys.exit(exit_status(main))
