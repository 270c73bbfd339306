"""What disturbs every step, and the draws that stand for it before a landing."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from powered_walker_env.model.checks import real_number, require, whole_number
from powered_walker_env.simulation.strides import Array


@dataclass(frozen=True)
class StepNoise:
    """What disturbs every step, as standard deviations of normal draws; 0 is none.

    Raises:
        ValueError: negative or not finite.
    """

    push: float = 0.0  # rad/s, on both leg rates after every heel strike, independent
    step_height: float = 0.0  # m, rise of the ground at every step, independent of the one before
    strength: float = 0.0  # share of the control's strength, at every stride

    def __post_init__(self) -> None:
        for name in ("push", "step_height", "strength"):
            value = real_number(name, getattr(self, name))
            require(value >= 0, name, "not be negative", value)
            object.__setattr__(self, name, value)

    @property
    def level(self) -> bool:
        """Whether the ground is."""
        return self.step_height == 0.0


class Branches(NamedTuple):
    """Draws before the landing, with their shares."""

    height: Array  # (B,) m
    factor: Array  # (B,) of the strength
    share: Array  # (B,)


def branches_of(noise: StepNoise, count: int) -> Branches:
    """The draws that stand for the noise before a landing: `count` of each kind that there is.

    Equal spaces over ±4 standard deviations with the normal law's masses: a fall sets in at a
    height, which Gauss and Hermite's few points would see or miss.
    """
    axes = []
    for size in (noise.step_height, noise.strength):
        n = whole_number("branches", count, 2) if size > 0 else 1
        edges = np.linspace(-4.0, 4.0, n + 1)
        mass = np.diff([0.5 * math.erf(edge / math.sqrt(2.0)) for edge in edges])
        axes.append(
            (size * 0.5 * (edges[1:] + edges[:-1]) if n > 1 else np.zeros(1), mass / mass.sum())
        )
    (heights, first), (factors, second) = axes
    grids = np.meshgrid(heights, 1.0 + factors, indexing="ij")
    return Branches(grids[0].ravel(), grids[1].ravel(), np.outer(first, second).ravel())
