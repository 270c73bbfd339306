"""Figures for papers: gaits, branches, boundaries, ramps, basins and costs (needs matplotlib).

Every function returns a `Drawing`: the figure and the numbers it shows. `save_drawing`
writes both: PNG, SVG and CSV. Nothing touches pyplot.
"""

from powered_walker_env.pictures.charts.branches import branch_figure, stability_figure
from powered_walker_env.pictures.charts.energetics import energetics_figure
from powered_walker_env.pictures.charts.gaits import gait_figure
from powered_walker_env.pictures.charts.planes import (
    basin_figure,
    bifurcation_figure,
    boundary_figure,
)
from powered_walker_env.pictures.charts.sheet import Drawing, save_drawing

__all__ = [
    "Drawing",
    "basin_figure",
    "bifurcation_figure",
    "boundary_figure",
    "branch_figure",
    "energetics_figure",
    "gait_figure",
    "save_drawing",
    "stability_figure",
]
