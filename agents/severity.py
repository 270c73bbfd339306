"""How hard the disturbances are, and how large each must be to be as hard as the pushes.

    python -m agents.severity          # the levels of the registered environments
    python -m agents.severity --find   # what they would have to be, found anew
    python -m agents.severity --env PoweredWalkerKneed-v0  # of these environments alone

Pushes are given; a level of another kind is as hard as the pushes of that level: the
geometric mean of 1 + the strides survived is the same. (The arithmetic mean would be
ruled by rare long walks. Of slope and parameters, drawn once per episode, some draws lie
so near the nominal walker that it walks all 100 strides: to have its mean, the other
draws would have to be walkers that nothing can make walk.)

Measured is the open loop; under sensor noise, which it does not feel, the LQR. The level
of sensor noise is not set so, but as large as the push in units of the observation.
"""

from __future__ import annotations

import argparse
import functools
import itertools
import json
import math
import sys
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from agents.command import exit_status, positive_int
from powered_walker_env import ENVIRONMENTS, Disturbance
from powered_walker_env.controllers import (
    EPISODE_SEED,
    Controller,
    Estimate,
    Evaluation,
    evaluate,
    load_controller,
)
from powered_walker_env.controllers.evaluation import task_of
from powered_walker_env.controllers.loading import LQR_NAME, OPEN_LOOP
from powered_walker_env.envs.disturbances import KINDS
from powered_walker_env.envs.levels import LEVELS
from powered_walker_env.tabular import aligned

EPISODES = 1000
LARGEST = 1.0  # size at which a search begins, in any kind's unit: more than any walker bears
HALVINGS, BISECTIONS = 40, 8  # down to 1e-12 of the largest size; then to 0.3 %


class Severity(NamedTuple):
    """How hard a disturbance of one kind and size is."""

    env_id: str
    level: str  # "light" or "rough"
    kind: str
    size: float  # the standard deviation, in the kind's unit
    controller: str
    target: float  # strides of a typical walk under the pushes of the level
    strides: float  # the same under this
    mean: Estimate  # strides survived, with its 95 % confidence interval
    to_the_end: float  # share of the episodes that lasted to the limit


def typical(walks: Evaluation) -> float:
    """Strides of a typical walk: the geometric mean of 1 + strides, less 1."""
    return math.expm1(float(np.log1p(walks.strides).mean()))


def size_for(target: float, strides: Callable[[float], float], largest: float) -> float:
    """The size at which `strides`, a falling function of it, comes down to `target`.

    The largest size is returned where that is still easier than the target.
    """
    if strides(largest) >= target:
        return largest
    low, high = largest / 2, largest
    for _ in range(HALVINGS):
        if strides(low) >= target:
            break
        low, high = low / 2, low
    for _ in range(BISECTIONS):
        middle = math.sqrt(low * high)
        low, high = (middle, high) if strides(middle) >= target else (low, middle)
    return math.sqrt(low * high)


def severities(
    env_id: str,
    episodes: int = EPISODES,
    seed: int = EPISODE_SEED,
    *,
    find: bool = True,
    **env_kwargs: Any,
) -> list[Severity]:
    """How hard all levels of all kinds are, at the sizes found anew or at those they have.

    Args:
        env_id: a registered environment of this package's class.
        **env_kwargs: arguments of the environment.
    """
    env_kwargs.pop("disturbance", None)

    def walks_under(controller: Controller, kind: str, size: float) -> Evaluation:
        return evaluate(controller, env_id, episodes, seed, **env_kwargs, disturbance={kind: size})

    def typical_under(controller: Controller, kind: str, size: float) -> float:
        return typical(walks_under(controller, kind, size))

    def level_of(name: str) -> Disturbance:
        return task_of(env_id, **env_kwargs, disturbance=name).disturbance

    task = task_of(env_id, **env_kwargs)
    rows = []
    for level, kind in itertools.product(LEVELS[1:], KINDS):
        size = getattr(level_of(f"{level}-{kind}"), kind)
        word = LQR_NAME if kind == "sensor" else OPEN_LOOP
        name, controller = load_controller(word, task)
        target = typical_under(controller, "push", level_of(level).push)
        if find:
            size = size_for(target, functools.partial(typical_under, controller, kind), LARGEST)
        walks = walks_under(controller, kind, size)
        rows.append(
            Severity(
                env_id,
                level,
                kind,
                size,
                name,
                target,
                typical(walks),
                walks.mean_strides,
                walks.survived / episodes,
            )
        )
    return rows


def severity_text(env_id: str, episodes: int, rows: Sequence[Severity]) -> str:
    """The table of one environment."""
    head = ("disturbance", "size", "of", "strides [95 %]", "typical", "pushed", "to the end")
    cells = [
        (
            f"{row.level}-{row.kind}",
            f"{row.size:.2g}",
            row.controller,
            row.mean.text(),
            f"{row.strides:.1f}",
            f"{row.target:.1f}",
            f"{100 * row.to_the_end:.0f} %",
        )
        for row in rows
    ]
    return "\n".join([f"{env_id}, {episodes} episodes each", *aligned([head, *cells]), ""])


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command."""
    parser = argparse.ArgumentParser(
        prog="python -m agents.severity", description=(__doc__ or "").split("\n\n")[0]
    )
    parser.add_argument("--find", action="store_true", help="find the levels anew")
    parser.add_argument(
        "--env",
        nargs="+",
        default=list(ENVIRONMENTS),
        metavar="ID",
        help="environments of this package's class (default: all registered by it)",
    )
    parser.add_argument("--json", action="store_true", help="print JSON")
    parser.add_argument(
        "--episodes", type=positive_int, default=EPISODES, help="of each (default: %(default)s)"
    )
    options = parser.parse_args(arguments)
    tables = []
    for env_id in options.env:
        rows = severities(env_id, options.episodes, find=options.find)
        tables += [{**row._asdict(), "mean": row.mean._asdict()} for row in rows]
        if not options.json:
            print(severity_text(env_id, options.episodes, rows), flush=True)
    if options.json:
        print(json.dumps({"episodes": options.episodes, "severities": tables}, indent=2))


if __name__ == "__main__":
    sys.exit(exit_status(main))
