"""What is the simplest control that still walks? Fewer and fewer measured numbers, and none.

For each walker at its level of pushes: every pair of one number and one action at the gain that
walks longest in trials, every subset of the four numbers to all actions, and in how many strides
deadbeat control is possible. Trials are walks that no evaluation uses.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Sequence
from typing import Any

from agents.command import exit_status
from agents.study.asking import answered, parser
from powered_walker_env.controllers import deadbeat_answer, few_numbers_table, one_number_table
from powered_walker_env.controllers.evaluation import task_of

FILE = "ladder.json"


def rungs(env_id: str) -> dict[str, Any]:
    """The tables of one walker; gains are of observations and actions as the id has them."""
    began, task = time.process_time(), task_of(env_id)
    back = deadbeat_answer(task)
    return {
        "pairs": [
            {"number": row.number, "action": row.action, "gain": round(row.gain, 4),
             "strides": round(row.strides, 2), "radius": round(row.spectral_radius, 4)}
            for row in one_number_table(task, "strides")
        ],
        "subsets": [
            {"numbers": list(row.numbers), "strides": round(row.strides, 2),
             "radius": round(row.spectral_radius, 4), "gain": row.gain.round(4).tolist()}
            for row in few_numbers_table(task)
        ],
        "deadbeat": {
            "strides": back.strides, "rank": back.rank, "controllable": back.controllable,
            "dimensions": list(back.dimensions),
            "feedback_within_bounds": back.feedback_share,
            "pushes_undone_within_bounds": {str(n): back.share(n) for n in back.needed},
        },
        "seconds": round(time.process_time() - began, 1),
    }  # fmt: skip


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command."""
    options = parser("ladder", __doc__).parse_args(arguments)
    answered(options.out, FILE, options.env, rungs)


if __name__ == "__main__":
    sys.exit(exit_status(main))
