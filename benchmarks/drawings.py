"""The work–precision plot and the scaling plot (import on demand: needs matplotlib)."""

from __future__ import annotations

import numpy as np

from benchmarks.precision import LOST, Precision
from benchmarks.scaling import Scaling
from powered_walker_env.pictures.charts.sheet import (
    BLUE,
    GREEN,
    GREY,
    INK,
    ORANGE,
    RED,
    VIOLET,
    Drawing,
    sheet,
    styled,
)

STYLES = (
    (GREY, "o"), (INK, "s"), (ORANGE, "^"), (VIOLET, "v"), (BLUE, "D"), (RED, "P"), (GREEN, "X"),
)  # fmt: skip


@styled
def precision_figure(found: Precision) -> Drawing:
    """Strides per second against error, a line for each method."""
    figure, (axes,) = sheet()
    methods = list(dict.fromkeys(rung.method for rung in found.rungs))
    for method, (colour, marker) in zip(methods, STYLES, strict=False):
        rungs = [r for r in found.rungs if r.method == method and 0 < r.error < LOST]
        errors, speeds = [r.error for r in rungs], [r.strides_per_second for r in rungs]
        axes.loglog(errors, speeds, color=colour, marker=marker, label=method)
    axes.invert_xaxis()
    axes.set(
        xlabel="largest error of the post-strike state (rad, rad/s)",
        ylabel="strides per second",
        title=f"One stride of {found.walker}: work and precision",
    )
    axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    return Drawing(
        figure,
        {
            "method": [rung.method for rung in found.rungs],
            "cores": [rung.cores for rung in found.rungs],
            "rtol": [rung.rtol for rung in found.rungs],
            "error": [rung.error for rung in found.rungs],
            "strides_per_second": [rung.strides_per_second for rung in found.rungs],
            "ratio_to_scipy": [rung.ratio for rung in found.rungs],
        },
    )


@styled
def scaling_figure(found: Scaling) -> Drawing:
    """Strides per second against walkers, and against cores."""
    figure, (walkers, by_cores) = sheet(2, 6.4)
    walkers.loglog(found.sizes, found.all_cores, color=RED, marker="P", label="all cores")
    walkers.loglog(found.sizes, found.one_core, color=BLUE, marker="D", label="one core")
    walkers.set(
        xlabel="walkers in a batch",
        ylabel="strides per second",
        title=f"Scaling with the number of walkers (rtol {found.rtol:.0e})",
    )
    walkers.legend(loc="lower right")
    count = np.array(found.cores)
    by_cores.plot(count, count * found.by_cores[0], color=GREY, linestyle="--", label="proportion")
    by_cores.plot(count, found.by_cores, color=RED, marker="P", label="measured")
    by_cores.set(
        xlabel="cores", ylabel="strides per second", title="and of cores", ylim=(0, None),
        xticks=count,
    )  # fmt: skip
    by_cores.legend(loc="lower right")
    table = {"cores": found.cores, "strides_per_second": found.by_cores}
    return Drawing(
        figure,
        {"walkers": found.sizes, "one_core": found.one_core, "all_cores": found.all_cores},
        {"cores": table | {"of_proportion": found.efficiency, "given": found.given}},
    )
