"""Figures for papers: gaits, walks, branches, boundaries, ramps, basins, costs (needs matplotlib).

Every function returns a `Drawing`: the figure and the numbers it shows. `save_drawing`
writes both: PNG, SVG and CSV; `save_figure` the figure alone. Nothing touches pyplot, and
neither a style nor a matplotlibrc of the user's changes a picture.
"""

from powered_walker_env.pictures.charts.boundaries import boundary_figure
from powered_walker_env.pictures.charts.branches import branch_figure, stability_figure
from powered_walker_env.pictures.charts.chances import passage_figure, viability_figure
from powered_walker_env.pictures.charts.energetics import energetics_figure
from powered_walker_env.pictures.charts.gaits import cycle, gait_figure
from powered_walker_env.pictures.charts.learning import learning_curve, learning_curves
from powered_walker_env.pictures.charts.planes import (
    basin_figure,
    bifurcation_figure,
    fate_pixels,
)
from powered_walker_env.pictures.charts.poses import angles_figure, stride_figure
from powered_walker_env.pictures.charts.sheet import Drawing, save_drawing, save_figure
from powered_walker_env.pictures.charts.sticks import stick_figure
from powered_walker_env.pictures.charts.walks import disturbed_walks, portrait_figure

__all__ = [
    "Drawing",
    "angles_figure",
    "basin_figure",
    "bifurcation_figure",
    "boundary_figure",
    "branch_figure",
    "cycle",
    "disturbed_walks",
    "energetics_figure",
    "fate_pixels",
    "gait_figure",
    "learning_curve",
    "learning_curves",
    "passage_figure",
    "portrait_figure",
    "save_drawing",
    "save_figure",
    "stability_figure",
    "stick_figure",
    "stride_figure",
    "viability_figure",
]
