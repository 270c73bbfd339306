"""Gaits along parameters.

- how does a gait change with a parameter, and what happens on the way? `continuation`, along
  the curves of `arclength`; `branch` and its `special_points`; along a path through several
  parameters at once, `paths`;
- where do doublings lead? `cascades`; and where do limits of stability run in a plane of two
  parameters? `boundary`, by the equations of `critical`;
- what walks, by brute force? `ramps`, begun on the gaits of `starts`.
"""

from powered_walker_env.poincare.branches.arclength import CurveEnd, EndReason
from powered_walker_env.poincare.branches.boundary import (
    Boundary,
    continue_boundary,
    stability_boundaries,
)
from powered_walker_env.poincare.branches.branch import Branch
from powered_walker_env.poincare.branches.cascades import Cascade, doubling_cascade
from powered_walker_env.poincare.branches.continuation import continue_gait, switch_branch
from powered_walker_env.poincare.branches.paths import PathBranch, continue_path
from powered_walker_env.poincare.branches.ramps import BifurcationDiagram, Ramp, bifurcation_diagram
from powered_walker_env.poincare.branches.special_points import SpecialKind, SpecialPoint
from powered_walker_env.poincare.branches.starts import stable_gait

__all__ = [
    "BifurcationDiagram",
    "Boundary",
    "Branch",
    "Cascade",
    "CurveEnd",
    "EndReason",
    "PathBranch",
    "Ramp",
    "SpecialKind",
    "SpecialPoint",
    "bifurcation_diagram",
    "continue_boundary",
    "continue_gait",
    "continue_path",
    "doubling_cascade",
    "stability_boundaries",
    "stable_gait",
    "switch_branch",
]
