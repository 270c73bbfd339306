"""Special points of a branch: folds, period doublings, Neimark–Sacker points.

Each is a zero of a test function along the branch (Kuznetsov, Elements of Applied
Bifurcation Theory, section 10.2.2, for maps): a fold of the tangent's component along the
parameter, a doubling of det(A + 1) = Π (μᵢ + 1), a Neimark–Sacker point of the bialternate
product's det(A ⊙ A − 1) = Π_{i<j} (μᵢ μⱼ − 1), which also vanishes at a neutral saddle
(two real multipliers with the product 1): that is no bifurcation and is left out.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from powered_walker_env.model.state import PostStrikeState
from powered_walker_env.poincare.branches.arclength import Solution, locate
from powered_walker_env.poincare.families import Family, OffCurveError
from powered_walker_env.poincare.gaits import Gait, describe

CRITICAL = 1e-4  # a multiplier this near to its critical value is the one that crosses


class SpecialKind(Enum):
    """What a multiplier on the unit circle does to a branch."""

    FOLD = "fold"  # at 1: two gaits meet and vanish
    PERIOD_DOUBLING = "period doubling"  # at -1: a gait of twice the period is born
    NEIMARK_SACKER = "Neimark-Sacker"  # a complex pair: an invariant circle is born


@dataclass(frozen=True, eq=False)
class SpecialPoint:
    """Where a multiplier of a branch crosses the unit circle."""

    kind: SpecialKind
    parameter: str
    value: float  # of the parameter
    gait: Gait  # there, post-strike section
    index: int  # of the branch's point just before

    @property
    def state(self) -> PostStrikeState:
        """The post-strike state there."""
        return self.gait.state

    @property
    def multipliers(self) -> NDArray[np.complex128]:
        """(4,) largest first."""
        return self.gait.multipliers

    @property
    def period(self) -> int:
        """Strides of the gait there."""
        return self.gait.period

    @property
    def critical_multiplier(self) -> complex:
        """The multiplier on the unit circle (of a pair, the one above the real axis)."""
        return _nearest_critical(self.kind, self.multipliers)

    @property
    def limits_stability(self) -> bool:
        """Whether every other multiplier is inside: the gait is stable on one side."""
        critical = self.critical_multiplier
        distance = np.minimum(
            abs(self.multipliers - critical), abs(self.multipliers - critical.conjugate())
        )
        others = self.multipliers[distance > CRITICAL]
        return bool(np.all(abs(others) < 1.0))


def fold_test(solution: Solution) -> float:
    """The parameter's share in the tangent."""
    return float(solution.tangent[-1])


def doubling_test(solution: Solution) -> float:
    """det(A + 1)."""
    return float(np.prod(solution.equations.multipliers + 1.0).real)


def circle_test(solution: Solution) -> float:
    """det(A ⊙ A − 1), of the bialternate product."""
    pairs = itertools.combinations(solution.equations.multipliers.tolist(), 2)
    return float(np.prod([a * b - 1.0 for a, b in pairs]).real)


TESTS: dict[SpecialKind, Callable[[Solution], float]] = {
    SpecialKind.FOLD: fold_test,
    SpecialKind.PERIOD_DOUBLING: doubling_test,
    SpecialKind.NEIMARK_SACKER: circle_test,
}


def special_points(
    family: Family, points: list[Solution], offset: int = 0
) -> tuple[SpecialPoint, ...]:
    """The special points between neighbours on a branch, in order; rounding-sharp."""
    found = []
    for index, (here, there) in enumerate(itertools.pairwise(points)):
        between = []
        for kind, test in TESTS.items():
            if test(here) * test(there) >= 0.0:
                continue
            try:
                solution = locate(family, here, there, test)
            except OffCurveError:
                continue  # the walkers in between fall: there is no curve to be smooth on
            if _is_real(kind, solution):
                between.append((float(here.tangent @ solution.u), kind, solution))
        between.sort(key=lambda item: item[0])
        found += [_named(family, kind, sol, index + offset) for _, kind, sol in between]
    return tuple(found)


def _is_real(kind: SpecialKind, solution: Solution) -> bool:
    multiplier = _nearest_critical(kind, solution.equations.multipliers)
    if kind is SpecialKind.NEIMARK_SACKER:
        return abs(abs(multiplier) - 1.0) < CRITICAL and multiplier.imag > CRITICAL
    return abs(abs(multiplier) - 1.0) < CRITICAL


def _nearest_critical(kind: SpecialKind, multipliers: NDArray[np.complex128]) -> complex:
    if kind is SpecialKind.NEIMARK_SACKER:
        above = multipliers[multipliers.imag > 0.0]
        if not len(above):
            return 0j
        return complex(above[np.argmin(abs(abs(above) - 1.0))])
    target = 1.0 if kind is SpecialKind.FOLD else -1.0
    return complex(multipliers[np.argmin(abs(multipliers - target))])


def _named(family: Family, kind: SpecialKind, solution: Solution, index: int) -> SpecialPoint:
    values = family.values(solution.u)
    gait = describe(
        family.stride_map(values), family.state(solution.u), "post-strike", family.period
    )
    return SpecialPoint(kind, family.names[0], float(values[0]), gait, index)
