"""The next step as a chance: walkers disturbed at every step, on a grid of their section.

- where do steps lead? `grid`, `law`, and from exact strides and their `noise`, `steps`;
- how long does a walker walk, under any policy? `passage`, with plain `walks` beside it;
- how long could it walk at best? `optimum`, by dynamic `programming`, and its policy as one of
  the `tables`. The compiled `sums` are behind both.
"""

from powered_walker_env.poincare.stochastic.grid import Grid
from powered_walker_env.poincare.stochastic.law import Law
from powered_walker_env.poincare.stochastic.noise import StepNoise
from powered_walker_env.poincare.stochastic.optimum import Optimum, optimum
from powered_walker_env.poincare.stochastic.passage import FirstPassage, first_passage
from powered_walker_env.poincare.stochastic.steps import step_law
from powered_walker_env.poincare.stochastic.tables import TablePolicy
from powered_walker_env.poincare.stochastic.walks import Walks, disturbed_walks

__all__ = [
    "FirstPassage",
    "Grid",
    "Law",
    "Optimum",
    "StepNoise",
    "TablePolicy",
    "Walks",
    "disturbed_walks",
    "first_passage",
    "optimum",
    "step_law",
]
