"""Train a policy by an evolution strategy: CMA-ES on the numbers of a small network.

Each generation draws some candidates, lets all of them walk the same episodes of the environment
in one batch, and moves to those with the greatest returns (`evolution_learner`). No gradient, no
value function: it takes a hundred times the strides of PPO, and the walker walks them in minutes.
Everything goes to `runs/NAME/`.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

from agents.command import exit_status
from agents.evolution_learner import ALGO, EvolutionLearner, Settings
from agents.own_training import own_parser, run_command


def parser() -> argparse.ArgumentParser:
    """The command line."""
    return own_parser("evolution", ALGO, __doc__, resumes=True)


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command."""
    run_command(parser(), Settings, ALGO, EvolutionLearner, arguments)


if __name__ == "__main__":
    sys.exit(exit_status(main))
