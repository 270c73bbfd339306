"""Pictures of planes: stability boundaries, basins, and ramps of a parameter."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.colors import ListedColormap
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator
from numpy.typing import ArrayLike

from powered_walker_env.model.phases import Outcome
from powered_walker_env.pictures.charts.branches import MARKS
from powered_walker_env.pictures.charts.sheet import (
    BLUE,
    GREEN,
    INK,
    ORANGE,
    PALE,
    RED,
    VIOLET,
    Drawing,
    label_of,
    sheet,
    styled,
)
from powered_walker_env.poincare.branches.boundary import Boundary
from powered_walker_env.poincare.branches.ramps import BifurcationDiagram
from powered_walker_env.poincare.regions.basins import FELL, WALKING, Basin
from powered_walker_env.poincare.regions.slices import COORDINATES

GAITS = (BLUE, GREEN, VIOLET, ORANGE)  # colours of attractors, by number


@styled
def boundary_figure(
    boundaries: Sequence[Boundary],
    *,
    nominal: tuple[float, float] | None = None,
    title: str = "",
) -> Drawing:
    """Curves in the plane of two parameters where a gait loses its stability.

    Args:
        boundaries: of the same two parameters; thick where the curve is the edge of
            stability, thin where another multiplier is outside already.
        nominal: a point to mark, as the values of the two parameters.
    """
    figure, (axes,) = sheet(1, 4.4)
    seen: set[str] = set()
    for boundary in boundaries:
        name = boundary.kind.value.replace("Neimark-", "Neimark–")
        name += "" if boundary.period == 1 else f" of period {boundary.period}"
        colour = MARKS[boundary.kind][1]
        x, y = boundary.values.T
        axes.plot(x, y, color=colour, linewidth=0.7)
        edge = boundary.limits_stability
        axes.plot(
            np.where(edge, x, np.nan), np.where(edge, y, np.nan), color=colour, linewidth=2.2,
            label=None if name in seen else name,
        )  # fmt: skip
        seen.add(name)
    if nominal is not None:
        axes.plot(*nominal, "o", color=INK, markersize=6, label="the gait asked for")
    first, second = boundaries[0].parameters
    axes.set(xlabel=label_of(first), ylabel=label_of(second), title=title)
    figure.legend(loc="outside lower center", ncols=3)
    rows = np.concatenate([b.values for b in boundaries])
    edges = np.concatenate([b.limits_stability for b in boundaries])
    columns: dict[str, ArrayLike] = {
        "kind": [b.kind.value for b in boundaries for _ in range(len(b))],
        first: rows[:, 0],
        second: rows[:, 1],
        "limits_stability": edges.astype(int),
        "critical_angle_rad": np.concatenate([b.angle for b in boundaries]),
    }
    return Drawing(figure, columns)


@styled
def bifurcation_figure(
    diagram: BifurcationDiagram, *, component: str = "stance_angle", title: str = ""
) -> Drawing:
    """One component of the post-strike state against a parameter ramped up and down.

    Args:
        component: a name out of `PostStrikeState`.

    Raises:
        ValueError: an unknown component.
    """
    if component not in COORDINATES:
        raise ValueError(f"component must be one of {', '.join(COORDINATES)}, got {component!r}")
    column = COORDINATES.index(component)
    figure, (axes,) = sheet(1, 4.4)
    x = np.repeat(diagram.values, diagram.keep)
    rising, falling = (ramp.states[:, :, column].ravel() for ramp in (diagram.up, diagram.down))
    small: Any = {"linestyle": "", "markeredgewidth": 0, "rasterized": True}
    axes.plot(x, rising, marker="o", markersize=3.0, color=BLUE, label="ramped up", **small)
    axes.plot(x, falling, marker="o", markersize=1.4, color=ORANGE, label="ramped down", **small)
    axes.set(
        xlabel=label_of(diagram.parameter),
        ylabel=f"{label_of(component)}\nafter heel strike",
        title=title,
        xlim=(diagram.values[0], diagram.values[-1]),
    )
    figure.legend(loc="outside lower center", ncols=2, markerscale=2)
    columns = {diagram.parameter: x, f"{component}_up": rising, f"{component}_down": falling}
    return Drawing(figure, columns)


@styled
def basin_figure(basin: Basin, *, title: str = "") -> Drawing:
    """What becomes of the starts of a slice: the gait each ends on, or the strides it lasts.

    Raises:
        ValueError: a basin of a list of states, which has no picture.
    """
    fate, strides = basin.picture("attractor"), basin.picture("strides")
    grid = basin.grid
    assert grid is not None  # or `picture` has refused
    figure, (axes,) = sheet(1, 4.8)
    (left, right), (low, high) = grid.ranges
    fell = np.ma.masked_where(fate != FELL, strides)
    shades = axes.imshow(
        fell, origin="lower", extent=(left, right, low, high), aspect="auto", cmap="Greys",
        vmin=0, vmax=max(1.0, 1.25 * float(strides[fate == FELL].max(initial=1))),
        interpolation="nearest",
    )  # fmt: skip
    whole = MaxNLocator(integer=True, nbins=6)
    figure.colorbar(shades, ax=axes, label="strides before the fall", shrink=0.85, ticks=whole)
    colours = [PALE, *(GAITS[k % len(GAITS)] for k in range(len(basin.gaits)))]
    colours[0] = RED
    alive = np.ma.masked_where(fate == FELL, fate - WALKING)
    axes.imshow(
        alive, origin="lower", extent=(left, right, low, high), aspect="auto",
        cmap=ListedColormap(colours), vmin=-0.5, vmax=len(colours) - 0.5, interpolation="nearest",
    )  # fmt: skip
    indices = [COORDINATES.index(name) for name in grid.axes]
    for gait in basin.gaits:
        x, y = gait.states[:, indices].T
        axes.plot(x, y, "o", color="white", markeredgecolor=INK, markersize=6, zorder=4)
    axes.grid(visible=False)
    axes.set(xlabel=label_of(grid.axes[0]), ylabel=label_of(grid.axes[1]), title=title)
    axes.set(xlim=(left, right), ylim=(low, high))
    figure.legend(handles=_fates(basin, colours), loc="outside lower center", ncols=3)
    return Drawing(figure, _basin_table(basin))


def _fates(basin: Basin, colours: Sequence[str]) -> list[Patch]:
    names = [f"still walking after {basin.limit} strides", *map(_attractor_name, basin.gaits)]
    there = [bool((basin.attractor == WALKING + k).any()) for k in range(len(names))]
    handles = zip(names, colours, there, strict=True)
    return [Patch(color=colour, label=name) for name, colour, some in handles if some]


def _attractor_name(gait: object) -> str:
    period = int(getattr(gait, "period", 1))
    return "ends on the gait" if period == 1 else f"ends on the gait of period {period}"


def _basin_table(basin: Basin) -> dict[str, ArrayLike]:
    return {
        **dict(zip(COORDINATES, basin.states.T, strict=True)),
        "attractor": basin.attractor,
        "strides": basin.strides,
        "outcome": [Outcome(value).label for value in basin.outcome.tolist()],
    }
