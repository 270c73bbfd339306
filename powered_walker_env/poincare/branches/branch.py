"""A branch: gaits along one parameter, as arrays, with its special points."""

from __future__ import annotations

import itertools
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from powered_walker_env.model.powering import AnyControl, Policy
from powered_walker_env.model.state import natural_units
from powered_walker_env.model.walker import WalkerParams
from powered_walker_env.poincare.branches.arclength import CurveEnd, Solution
from powered_walker_env.poincare.branches.special_points import SpecialKind, SpecialPoint
from powered_walker_env.poincare.families import Bounds, Family
from powered_walker_env.poincare.fixed_points import newton
from powered_walker_env.poincare.gaits import Gait, GaitNotFoundError, describe
from powered_walker_env.poincare.maps import StrideMap
from powered_walker_env.simulation.strides import Array


@dataclass(frozen=True, eq=False)
class Branch:
    """Gaits along one parameter, in the order in which the branch passes through them.

    A branch may turn back at folds, so `values` need not be monotone. Durations, lengths
    and works are those of the whole period, as in `Gait`.
    """

    params: WalkerParams  # of the gait that the branch was started from
    control: AnyControl | Policy | None
    parameter: str  # the name of what changes along the branch
    period: int  # strides
    section: str  # of the gaits that `gait` returns
    bounds: Bounds  # of the parameter
    values: Array  # (n,) of the parameter
    states: Array = field(repr=False)  # (n, 4) post-strike
    multipliers: NDArray[np.complex128] = field(repr=False)  # (n, 4) largest first
    duration: Array = field(repr=False)  # (n,) s
    step_length: Array = field(repr=False)  # (n,) m
    positive_work: Array = field(repr=False)  # (n,) J
    cost_of_transport: Array = field(repr=False)  # (n,)
    min_clearance: Array = field(repr=False)  # (n,) m, least after mid-swing; below 0 it scuffs
    special_points: tuple[SpecialPoint, ...]
    ends: tuple[CurveEnd, CurveEnd]  # why it goes no further, before the first and after the last

    def __len__(self) -> int:
        """Number of gaits."""
        return len(self.values)

    @property
    def spectral_radius(self) -> Array:
        """(n,) modulus of the largest multiplier."""
        radius: Array = np.abs(self.multipliers[:, 0])
        return radius

    @property
    def stable(self) -> NDArray[np.bool_]:
        """(n,) whether small deviations die out."""
        return self.spectral_radius < 1.0

    @property
    def speed(self) -> Array:
        """(n,) m/s."""
        return self.step_length / self.duration

    def of_kind(self, kind: SpecialKind) -> list[SpecialPoint]:
        """The special points of one kind, in order."""
        return [point for point in self.special_points if point.kind is kind]

    def gait(self, index: int) -> Gait:
        """The gait at a point of the branch."""
        stride_map = self._stride_map(float(self.values[index]))
        return describe(stride_map, self.states[index], self.section, self.period)

    def at(self, value: float) -> list[Gait]:
        """The gaits where the branch passes through a value of the parameter, in order.

        Raises:
            GaitNotFoundError: a passage between two points that Newton does not find.
        """
        before, after = self.values[:-1], self.values[1:]
        passes = (np.minimum(before, after) <= value) & (value <= np.maximum(before, after))
        gaits: list[Gait] = []
        for i in np.flatnonzero(passes & (before != after)).tolist():
            share = (value - before[i]) / (after[i] - before[i])
            guess = self.states[i] + share * (self.states[i + 1] - self.states[i])
            found = self._near(value, guess)
            units = natural_units(found.params)
            reach = np.linalg.norm((self.states[i + 1] - self.states[i]) / units)
            if np.linalg.norm((np.array(found.state) - self.states[i]) / units) > 2 * reach + 1e-6:
                raise GaitNotFoundError(
                    f"no gait of this branch found at {self.parameter} = {value}; "
                    "continue it again with a smaller step"
                )
            if not gaits or not np.allclose(found.state, gaits[-1].state, rtol=0, atol=1e-9):
                gaits.append(found)  # not again, where a point of the branch has this value
        return gaits

    def stable_ranges(self) -> list[tuple[float, float]]:
        """The stable stretches as (low, high) of the parameter, in order along the branch.

        They begin and end at the special points at which every other multiplier is inside:
        there, and nowhere else, stability changes, however many of them lie between two gaits
        of the branch. (Where the gaits say otherwise, a pair of points was missed: then the
        change is put half-way.)
        """
        stable = bool(self.stable[0])
        changes: list[tuple[float, bool]] = [(float(self.values[0]), stable)]
        for i, after in enumerate(self.stable[1:].tolist()):
            for point in self.special_points:
                if point.index == i and point.limits_stability:
                    stable = not stable
                    changes.append((point.value, stable))
            if stable is not after:
                stable = after
                changes.append((0.5 * float(self.values[i] + self.values[i + 1]), stable))
        changes.append((float(self.values[-1]), False))
        pairs = itertools.pairwise(changes)
        return [(min(a, b), max(a, b)) for (a, stable), (b, _) in pairs if stable and a != b]

    def _stride_map(self, value: float) -> StrideMap:
        family = Family(self.params, self.control, (self.parameter,), np.ones(1), self.period)
        return family.stride_map(np.array([value]))

    def _near(self, value: float, guess: Array) -> Gait:
        stride_map = self._stride_map(value)
        state, reason = newton(stride_map, guess, self.period)
        if state is None:
            raise GaitNotFoundError(f"no gait at {self.parameter} = {value!r}: {reason}")
        return describe(stride_map, state, self.section, self.period)


def branch_of(
    family: Family,
    section: str,
    bounds: Bounds,
    points: list[Solution],
    special_points: tuple[SpecialPoint, ...],
    ends: tuple[CurveEnd, CurveEnd],
) -> Branch:
    """The solutions of a family with one parameter as a branch."""
    values = np.array([family.values(p.u)[0] for p in points])
    states = np.array([family.state(p.u) for p in points])
    work, clearance = zip(*(work_and_clearance(family, p.u) for p in points), strict=True)
    length = np.array([p.equations.point.step_length for p in points])
    walkers = [family.walker(np.array([value]))[0] for value in values]
    weight = np.array([2.0 * w.leg_mass * w.gravity for w in walkers])
    return Branch(
        params=family.params,
        control=family.control,
        parameter=family.names[0],
        period=family.period,
        section=section,
        bounds=bounds,
        values=values,
        states=states,
        multipliers=np.array([p.equations.multipliers for p in points]),
        duration=np.array([p.equations.point.duration for p in points]),
        step_length=length,
        positive_work=np.array(work),
        cost_of_transport=np.array(work) / (weight * length),
        min_clearance=np.array(clearance),
        special_points=special_points,
        ends=ends,
    )


def work_and_clearance(family: Family, u: Array) -> tuple[float, float]:
    """Positive motor work over the period, J, and the least clearance after mid-swing, m."""
    stride_map, state = family.stride_map(family.values(u)), family.state(u)[np.newaxis]
    work, clearance = 0.0, np.inf
    for _ in range(family.period):
        batch = stride_map.strides(state)
        work += float(batch.positive_work[0])
        clearance = min(clearance, float(batch.min_clearance[0]))
        state = batch.state
    return work, clearance
