"""Find the best that any controller can do at an environment, and save it as a table.

Dynamic programming on the walker's section; the file is numpy's, holds no code, and is a
controller to `agents.evaluate`. The tables that come with the package were made by

    python -m agents.optimum --env ID --out FILE.npz
    python -m agents.optimum --env ID --env-kwargs disturbance:rough --out FILE.npz

with `--shape 72 30 8` on the thesis's walker and as published under rough pushes, `--shape 96 40 8`
as published under light ones, `--shape 24 --calm 0.005` on round feet under rough pushes, `--calm
0.005` there under light ones, and with the default with knees: 48 x 20 x 6 nodes where the map is
far from normal, 18 x 18 x 18 where it is not. Three to six minutes of one core of a server of 2026
each.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from tqdm import tqdm

from agents.command import add_env_arguments, exit_status, natural_int, pairs, positive_int
from powered_walker_env.controllers.evaluation import task_of
from powered_walker_env.controllers.optimal import find_optimum
from powered_walker_env.files import check_writable
from powered_walker_env.poincare.stochastic.programming import CALM
from powered_walker_env.results import save_result


def parser() -> argparse.ArgumentParser:
    """The command line."""
    result = argparse.ArgumentParser(
        prog="python -m agents.optimum", description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )  # fmt: skip
    add_env_arguments(result)
    result.add_argument(
        "--objective", choices=("return", "strides"), default="return",
        help="what is to be greatest (default: %(default)s)",
    )  # fmt: skip
    result.add_argument(
        "--shape", type=positive_int, nargs="+", metavar="N",
        help="nodes along the three axes, the one that decides where a step leads first, or one "
        "count for all (default: 48 20 6, or 18 where the map is even)",
    )  # fmt: skip
    result.add_argument(
        "--counts", type=positive_int, default=9,
        help="values of each number of the control tried at first, odd (default: %(default)s)",
    )  # fmt: skip
    result.add_argument(
        "--push-points", type=positive_int, nargs=2, metavar="N",
        help="that stand for the pushes, along that axis and across it (default: 31 3, or 15 15 "
        "where the map is even)",
    )  # fmt: skip
    result.add_argument(
        "--calm", type=float, default=CALM, metavar="REWARD",
        help="that a half range more of a control must be worth (default: %(default)s)",
    )  # fmt: skip
    result.add_argument("--seed", type=natural_int, default=0, help="of the walks that place it")
    result.add_argument("--out", type=Path, metavar="FILE", help="save the table there, .npz")
    result.add_argument("--overwrite", action="store_true", help="replace FILE if it exists")
    return result


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command."""
    options = parser().parse_args(arguments)
    if options.out is not None:
        if options.out.suffix != ".npz":
            raise ValueError(f"--out must end in .npz, got {str(options.out)!r}")
        check_writable([options.out], options.overwrite)
    kwargs = pairs(options.env_kwargs)
    task = task_of(options.env, **kwargs)
    with tqdm(unit=" strides", unit_scale=True, disable=None) as bar:

        def progress(done: int, total: int) -> None:
            bar.total = total
            bar.update(done - bar.n)

        found = find_optimum(
            task, objective=options.objective, counts=options.counts,
            shape=options.shape * 3 if len(options.shape or []) == 1 else options.shape,
            push_points=tuple(options.push_points) if options.push_points else None,
            calm=options.calm, seed=options.seed, progress=progress,
        )  # fmt: skip
    mean, error = found.walked
    print(f"{options.env}, {options.objective} of {found.horizon} strides")
    print(f"  by the table       {found.value:.4g} ± {found.error:.2g} (refinement, and walks)")
    how = "looking a stride ahead" if found.looks_ahead else "the table"
    print(f"  as walked          {mean:.4g} ± {error:.2g} (standard error; {how})")
    print(f"  at most            {found.upper:.4g}, if the best came of all that leaves the grid")
    if options.out is not None:
        settings = {"env_id": options.env, "env_kwargs": kwargs, "objective": options.objective}
        print(f"table: {save_result(found, options.out, settings)}")


if __name__ == "__main__":
    sys.exit(exit_status(main))
