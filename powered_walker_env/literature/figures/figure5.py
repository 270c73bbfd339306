"""The search for figure 5: its caption gives a largest multiplier of 0.61 and no parameters.

Section 8 says what it shows: a stable gait whose foot does not extend monotonely, but
rises and falls, sometimes more than once.
"""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from powered_walker_env.literature.figures.studies import Figure6, control_of, upper_part
from powered_walker_env.model.powering.motor import Control
from powered_walker_env.poincare import Gait, GaitNotFoundError, find_gait
from powered_walker_env.poincare.energy.assumptions import STILL
from powered_walker_env.poincare.energy.contact import foot_motion
from powered_walker_env.simulation.strides import Array

RADIUS_5 = 0.61  # largest multiplier, as printed
NEARLY_STABLE = 1.1  # multiplier up to which the search goes on to a gait's neighbours
SCAN = 25  # gaits along the branch between which 0.61 is looked for
COLUMNS = ("switch_angle_rad", "stall_torque_N_m", "spectral_radius", "overrun_rad", "reversals")


@dataclass(frozen=True, eq=False)
class Candidate:
    """A stable gait that could be figure 5."""

    gait: Gait
    overrun: float  # rad, how far its foot falls back past its stop
    reversals: int  # times its ankle turns round while the motor runs
    solved: str  # the number of the control solved for a multiplier of 0.61; empty if none is


@dataclass(frozen=True, eq=False)
class Figure5:
    """Stable gaits whose foot does not extend monotonely."""

    on_branch: Candidate  # at figure 4's switch angle, the nearest to 0.61
    at_torque: Candidate | None  # 0.61 at one stall torque, the foot turning most often
    searched: Array  # (n, 5): the numbers of `COLUMNS` of every gait found

    @property
    def drawn(self) -> Candidate:
        """The one that turns more often."""
        other = self.at_torque
        if other is not None and other.reversals > self.on_branch.reversals:
            return other
        return self.on_branch

    @property
    def stable(self) -> Array:
        """(n, 5) the stable gaits found."""
        return self.searched[self.searched[:, 2] < 1.0]

    @property
    def not_monotone(self) -> Array:
        """(n, 5) of them, those whose foot does not extend monotonely."""
        return self.stable[(self.stable[:, 4] > 0) | (self.stable[:, 3] > STILL)]


def figure_5(figure: Figure6, nodes: int, step: Callable[[], None]) -> Figure5:
    """Look for a spectral radius of 0.61 with a foot that turns round.

    First along figure 6's own branch, then over a lattice of switch angles and stall
    torques around figure 4, from each gait to its neighbours while they are nearly stable.

    Args:
        nodes: of the lattice, at most.
        step: called after each.
    """
    searched = _flood(figure.gait, figure.setting.lattice, nodes, step)
    found = Figure5(_nearest_on_branch(figure), None, searched)
    return dataclasses.replace(found, at_torque=_turning_most(figure.gait, found.not_monotone))


def _candidate(gait: Gait, solved: str = "") -> Candidate:
    return Candidate(gait, *foot_motion(gait), solved)


def _nearest_on_branch(figure: Figure6) -> Candidate:
    """The gait with a foot that falls back whose radius is 0.61, or comes nearest to it."""
    at, (low, high) = upper_part(figure.gait, figure.branch), figure.stable_range
    high = high if figure.falling_back is None else figure.falling_back.stall_torque
    torques = np.linspace(low + 1e-2 * (high - low), high, SCAN)
    excess = np.array([at(t).spectral_radius - RADIUS_5 for t in torques.tolist()])
    crossings = np.flatnonzero(excess[:-1] * excess[1:] < 0)
    if not len(crossings):
        return _candidate(at(float(torques[np.argmin(np.abs(excess))])))
    left, right = torques[crossings[-1]], torques[crossings[-1] + 1]
    root = float(brentq(lambda t: at(t).spectral_radius - RADIUS_5, left, right, xtol=1e-8))
    return _candidate(at(root), "stall torque")


def _turning_most(start: Gait, rows: Array) -> Candidate | None:
    """Between two neighbours of the lattice at one stall torque, the gait of radius 0.61.

    Of all such pairs, the one whose feet turn most often, then nearest to figure 4.
    """
    nominal = control_of(start)
    pairs = []
    for torque in np.unique(rows[:, 1]):
        column = rows[rows[:, 1] == torque]
        column = column[np.argsort(column[:, 0])]
        for left, right in itertools.pairwise(column):
            if (left[2] - RADIUS_5) * (right[2] - RADIUS_5) < 0:
                away = abs(torque - nominal.stall_torque), abs(left[0] - nominal.switch_angle)
                pairs.append((-min(left[4], right[4]), *away, left, right))
    if not pairs:
        return None
    *_, left, right = min(pairs, key=lambda pair: pair[:3])
    params, guess = start.params, _reach(start, left)

    def at(switch_angle: float) -> Gait:
        return find_gait(params, Control(switch_angle, float(left[1])), guess.state)

    root = brentq(lambda s: at(s).spectral_radius - RADIUS_5, left[0], right[0], xtol=1e-10)
    return _candidate(at(float(root)), "switch angle")


def _reach(start: Gait, row: Array, steps: int = 10) -> Gait:
    """The gait at a row of the search, by small steps of the control from `start`."""
    first, gait = np.array(dataclasses.astuple(control_of(start))), start
    for share in np.linspace(0, 1, steps + 1)[1:]:
        control = Control(*(first + share * (row[:2] - first)).tolist())
        gait = find_gait(gait.params, control, gait.state)
    return gait


def _flood(gait: Gait, lattice: tuple[float, float], nodes: int, step: Callable[[], None]) -> Array:
    """Gaits on a lattice of (switch angle, stall torque), the nearest to figure 4 first."""
    centre = np.array(dataclasses.astuple(control_of(gait)))
    waiting, seen, rows = [(0.0, (0, 0), gait)], {(0, 0)}, [_row(gait)]
    while waiting and len(seen) < nodes:
        waiting.sort(key=lambda item: item[0])
        _, (i, j), near = waiting.pop(0)
        for node in ((i + 1, j), (i - 1, j), (i, j + 1), (i, j - 1)):
            if node in seen or len(seen) >= nodes:
                continue
            seen.add(node)
            found = _neighbour(near, centre + np.array(node) * lattice)
            step()
            if found is None:
                continue
            rows.append(_row(found))
            if found.spectral_radius < NEARLY_STABLE:
                waiting.append((math.hypot(*node), node, found))
    return np.array(rows)


def _neighbour(near: Gait, control: Array) -> Gait | None:
    try:
        return find_gait(near.params, Control(*control.tolist()), near.state)
    except (GaitNotFoundError, ValueError):
        return None


def _row(gait: Gait) -> tuple[float, ...]:
    overrun, reversals = foot_motion(gait)
    return (*dataclasses.astuple(control_of(gait)), gait.spectral_radius, overrun, float(reversals))
