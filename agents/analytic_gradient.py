"""Train a policy by gradients through the walker itself: an analytic policy gradient.

Some walkers walk a few strides under the policy and the environment's pushes, with the exact
derivatives of every stride. The policy then takes many steps down the gradient of what
these walks, and those before, cost to first order (`segments`), and the walkers go
on. No value function, no reward, no exploration. Everything goes to `runs/NAME/`.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

from agents.command import exit_status
from agents.gradient_learner import ALGO, GradientLearner, Settings
from agents.own_training import own_parser, run_command


def parser() -> argparse.ArgumentParser:
    """The command line."""
    return own_parser("analytic_gradient", ALGO, __doc__)


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command."""
    run_command(parser(), Settings, ALGO, GradientLearner, arguments)


if __name__ == "__main__":
    sys.exit(exit_status(main))
