"""Stability boundaries in two parameters: each point marginal, each curve where branches say."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from powered_walker_env import PRESETS, Control, find_gait
from powered_walker_env.poincare import GaitNotFoundError
from powered_walker_env.poincare.branches.arclength import EndReason
from powered_walker_env.poincare.branches.boundary import (
    Boundary,
    continue_boundary,
    stability_boundaries,
)
from powered_walker_env.poincare.branches.branch import Branch
from powered_walker_env.poincare.branches.continuation import continue_gait
from powered_walker_env.poincare.branches.special_points import SpecialKind, SpecialPoint
from tests.helpers.published import PASSIVE_GAITS

PLANE = ("switch_angle", "stall_torque")
AROUND = ((2.88, 2.93), (715.0, 745.0))


@pytest.fixture(scope="module")
def conserving() -> Branch:
    params, control, state, _ = PRESETS["camp1997"]
    return continue_gait(find_gait(params, control, state), "stall_torque", (715.0, 745.0))


def the(branch: Branch, kind: SpecialKind) -> SpecialPoint:
    """The point of that kind at the highest torque."""
    return max(branch.of_kind(kind), key=lambda point: point.value)


def marginal_value(boundary: Boundary, switch_angle: float) -> float:
    """The stall torque of the special point at another switch angle, found by a branch."""
    index = int(np.argmin(abs(boundary.values[:, 0] - switch_angle)))
    gait = boundary.gait(index)
    assert isinstance(gait.control, Control)
    angle, torque = boundary.values[index]
    branch = continue_gait(gait, "stall_torque", (torque - 2.0, torque + 2.0), max_points=6)
    values = [point.value for point in branch.of_kind(boundary.kind)]
    assert gait.control.switch_angle == angle
    return min(values, key=lambda value: abs(value - torque)) - torque


@pytest.mark.parametrize(
    ("kind", "critical"), [("PERIOD_DOUBLING", -1.0), ("FOLD", 1.0), ("NEIMARK_SACKER", None)]
)
def test_boundaries_are_where_branches_at_other_switch_angles_have_their_points(
    kind: str, critical: float | None, conserving: Branch
) -> None:
    point = the(conserving, SpecialKind[kind])
    boundary = continue_boundary(point, PLANE, AROUND, step=0.1)
    assert boundary.kind is point.kind
    assert len(boundary) > 5
    assert {end.reason for end in boundary.ends} == {EndReason.BOUND}
    distance = abs(boundary.multipliers - np.exp(1j * boundary.angle)[:, np.newaxis]).min(axis=1)
    assert distance.max() < 1e-8
    if critical is not None:
        assert np.cos(boundary.angle) == pytest.approx(critical)
    assert np.hypot(*(boundary.values - [2.9068, point.value]).T).min() < 1e-6
    assert marginal_value(boundary, 2.915) == pytest.approx(0.0, abs=1e-6)


def test_the_upper_edge_of_stability_is_a_doubling_all_along(conserving: Branch) -> None:
    point = the(conserving, SpecialKind.PERIOD_DOUBLING)
    boundary = continue_boundary(point, PLANE, AROUND, step=0.1)
    assert boundary.limits_stability.all()
    inside = boundary.gait(2)
    assert isinstance(inside.control, Control)
    lower = replace(inside.control, stall_torque=inside.control.stall_torque - 0.05)
    assert find_gait(inside.params, lower, inside.state).stable
    higher = replace(inside.control, stall_torque=inside.control.stall_torque + 0.05)
    assert not find_gait(inside.params, higher, inside.state).stable


def test_both_neimark_sacker_points_of_the_branch_lie_on_one_curve(conserving: Branch) -> None:
    upper = the(conserving, SpecialKind.NEIMARK_SACKER)
    lower = min(conserving.of_kind(SpecialKind.NEIMARK_SACKER), key=lambda point: point.value)
    bounds = ((2.8, 3.0), (700.0, 760.0))
    boundary = continue_boundary(upper, PLANE, bounds, step=0.1)
    ends = [end.reason for end in boundary.ends]
    assert ends == [EndReason.RESONANCE, EndReason.RESONANCE]
    steps = np.diff(boundary.values, axis=0)
    crossings = (boundary.values[:-1, 0] - 2.9068) * (boundary.values[1:, 0] - 2.9068) < 0
    torques = []
    for i in np.flatnonzero(crossings).tolist():
        share = (2.9068 - boundary.values[i, 0]) / steps[i, 0]
        torques.append(boundary.values[i, 1] + share * steps[i, 1])
    assert min(abs(np.array(torques) - lower.value)) < 0.2  # by linear interpolation


def test_all_boundaries_of_a_gait_are_found_once(conserving: Branch) -> None:
    params, control, state, _ = PRESETS["camp1997"]
    gait = find_gait(params, control, state)
    bounds = ((2.8, 3.0), (700.0, 760.0))
    curves = stability_boundaries(gait, PLANE, bounds, step=0.1, backend="threading")
    limits = [point for point in conserving.special_points if point.limits_stability]
    assert len(limits) == 4
    # A fold, a doubling, and one curve through both Neimark-Sacker points.
    assert sorted(curve.kind.name for curve in curves) == [
        "FOLD", "NEIMARK_SACKER", "PERIOD_DOUBLING",
    ]  # fmt: skip
    doubling = the(conserving, SpecialKind.PERIOD_DOUBLING)
    alone = continue_boundary(doubling, PLANE, bounds, step=0.1)
    (same,) = (curve for curve in curves if curve.kind is doubling.kind)
    np.testing.assert_allclose(same.values, alone.values, rtol=1e-6)
    assert same.ends == alone.ends


def test_passive_walkers_have_boundaries_in_slope_and_shape() -> None:
    compass = next(gait for gait in PASSIVE_GAITS if gait.walker.startswith("compass"))
    gait = find_gait(compass.params, None, compass.state)
    (point,) = continue_gait(gait, "slope", (0.03, 0.08), step=0.1).special_points
    boundary = continue_boundary(
        point, ("slope", "com_along"), ((0.03, 0.12), (0.7, 0.8)), step=0.1
    )
    nearest = int(np.argmin(abs(boundary.values[:, 1] - 0.75)))
    assert boundary.values[nearest, 0] == pytest.approx(math.radians(4.390898249602), abs=1e-9)
    assert boundary.limits_stability.all()


def test_bad_arguments_are_named(conserving: Branch) -> None:
    point = the(conserving, SpecialKind.FOLD)
    with pytest.raises(ValueError, match="two different names"):
        continue_boundary(point, ("slope", "slope"), ((-0.1, 0.1), (-0.1, 0.1)))
    with pytest.raises(ValueError, match="two different names"):
        stability_boundaries(point.gait, ("slope", "slope"), ((-0.1, 0.1), (-0.1, 0.1)))
    with pytest.raises(GaitNotFoundError, match="no limit of stability for stall_torque"):
        stability_boundaries(conserving.gait(-1), PLANE, ((2.8, 3.0), (744.0, 746.0)))
    with pytest.raises(ValueError, match=r"bounds must be \(low, high\) for each of"):
        continue_boundary(point, PLANE, ((2.8, 3.0),))  # type: ignore[arg-type]
    with pytest.raises(TypeError, match=r"bounds must be a pair \(low, high\), got 5.0"):
        continue_boundary(point, PLANE, ((2.8, 3.0), 5.0))  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="bounds must hold the gait's stall_torque"):
        continue_boundary(point, PLANE, ((2.8, 3.0), (800.0, 900.0)))
    with pytest.raises(ValueError, match="parameter must be one of"):
        continue_boundary(point, ("colour", "slope"), ((0.0, 1.0), (-0.1, 0.1)))
