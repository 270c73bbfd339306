"""Gaits as fixed points of the stride map (Camp 1997, section 7)."""

from powered_walker_env.poincare.gaits import Gait, GaitNotFoundError, find_gait

__all__ = ["Gait", "GaitNotFoundError", "find_gait"]
