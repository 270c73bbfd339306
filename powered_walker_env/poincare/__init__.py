"""Gaits as fixed points of the stride map (Camp 1997, section 7)."""

from powered_walker_env.poincare.gaits import Gait, GaitNotFoundError, find_gait
from powered_walker_env.poincare.maps import PARAMETERS, MapPoint, Policy, StrideMap

__all__ = [
    "PARAMETERS",
    "Gait",
    "GaitNotFoundError",
    "MapPoint",
    "Policy",
    "StrideMap",
    "find_gait",
]
