"""What all contenders have to solve: one stride each from scattered starts near a gait."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchmarks.equations import Constants, constants
from powered_walker_env.model.powering.motor import Control
from powered_walker_env.model.presets import preset
from powered_walker_env.model.walker import WalkerParams
from powered_walker_env.simulation.strides import TIGHTEST, stride_batch

Array = NDArray[np.float64]

SPREAD = (0.003, 0.003, 0.01, 0.01)  # rad, rad/s: within the basins of the presets
STARTS = 16  # at which errors are measured
MANY = 1024  # strides in a batch: enough for every lane of every core, little memory
SEED = 1997


@dataclass(frozen=True, eq=False)
class Problem:
    """A walker, its starts, and where they lead."""

    name: str
    params: WalkerParams
    control: Control
    starts: Array  # (MANY, 4) post-strike states
    ends: Array  # (MANY, 4) the next ones, to rounding: by the package at its tightest

    @property
    def constants(self) -> Constants:
        """For the equations of the others."""
        return constants(self.params, self.control)

    @property
    def controls(self) -> Array:
        """(2,) switch angle and stall torque."""
        return np.array([self.control.switch_angle, self.control.stall_torque])

    def error(self, ends: Array) -> float:
        """Largest component by which ends of the first starts are off; NaN counts as infinite."""
        off = np.abs(np.asarray(ends) - self.ends[: len(ends)])
        return float(np.where(np.isnan(off), np.inf, off).max())


def make_problem(name: str) -> Problem:
    """The problem at a preset.

    Raises:
        ValueError: no such preset, a passive walker, or the physics of the listing.
    """
    params, control, state, _ = preset(name)
    if type(control) is not Control:
        raise ValueError(f"preset must be a walker with the motor, got {name!r}")
    constants(params, control)
    rng = np.random.default_rng(SEED)
    candidates = np.array(state) + np.array(SPREAD) * rng.uniform(-1, 1, (2 * MANY, 4))
    batch = stride_batch(
        candidates, (control.switch_angle, control.stall_torque), params, rtol=TIGHTEST
    )
    rows = np.flatnonzero(batch.walked)[:MANY]
    if len(rows) < MANY:
        raise ValueError(
            f"preset must walk from the states around its gait, got {name!r}, "
            f"where {len(rows)} of {len(candidates)} do"
        )
    return Problem(name, params, control, candidates[rows], np.ascontiguousarray(batch.state[rows]))
