"""Pictures of planes: basins, and ramps of a parameter."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from matplotlib.colors import to_rgb
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator
from numpy.typing import ArrayLike, NDArray

from powered_walker_env.model.phases import Outcome
from powered_walker_env.pictures.charts.branches import HUES
from powered_walker_env.pictures.charts.sheet import (
    BLUE,
    INK,
    ORANGE,
    PALE,
    RED,
    Drawing,
    label_of,
    sheet,
    styled,
)
from powered_walker_env.poincare import (
    Basin,
    BifurcationDiagram,
    Gait,
)
from powered_walker_env.poincare.regions.basins import FELL, WALKING
from powered_walker_env.poincare.regions.slices import COORDINATES

#: Colours of the kinds of fall; darker with more strides.
FALLS = {
    Outcome.FELL_FORWARD: "#e3c9a8",
    Outcome.FELL_BACKWARD: "#b9b9b9",
    Outcome.SWING_LEG_HORIZONTAL: "#d9b8c4",
    Outcome.HIP_BELOW_FLOOR: "#c3b7dd",
    Outcome.FOOT_ROLLED_OVER: "#a9c7d8",
    Outcome.FOOT_FELL_BACK: "#c9d3a6",
    Outcome.NO_SWITCH: "#b5d6cc",
    Outcome.NO_LANDING: "#ece3a3",
}
OTHER_FALL = "#ececec"


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
    axes.xaxis.set_major_locator(MaxNLocator(6))
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
    fallen = np.isnan(diagram.up.states[:, -1, 0]) & np.isnan(diagram.down.states[:, -1, 0])
    if fallen.any():
        axes.fill_between(
            diagram.values, 0, 1, where=fallen.tolist(), transform=axes.get_xaxis_transform(),
            color=PALE, lw=0, step="mid", zorder=0.5, label="no walk, up or down",
        )  # fmt: skip
    figure.legend(loc="outside lower center", ncols=3, markerscale=2)
    columns = {diagram.parameter: x, f"{component}_up": rising, f"{component}_down": falling}
    return Drawing(figure, columns)


@styled
def basin_figure(basin: Basin, *, title: str = "") -> Drawing:
    """What becomes of the starts of a slice: the gait each ends on, or the strides it lasts.

    Raises:
        ValueError: a basin of a list of states, which has no picture.
    """
    pixels, meanings = fate_pixels(basin)
    grid = basin.grid
    assert grid is not None  # or `fate_pixels` has refused
    figure, (axes,) = sheet(1, 4.8)
    (left, right), (low, high) = grid.ranges
    handles: list[Patch | Line2D] = [Patch(color=colour, label=name) for name, colour in meanings]
    axes.imshow(pixels, origin="lower", extent=(left, right, low, high), aspect="auto",
                interpolation="nearest")  # fmt: skip
    indices = [COORDINATES.index(name) for name in grid.axes]
    for gait in basin.gaits:
        on = gait.states if grid.on is None else grid.on.states(grid.on.points(gait.states))
        x, y = on[:, indices].T
        handles += axes.plot(x, y, "o", color="white", markeredgecolor=INK, markersize=6, zorder=4,
                             label="the gait")  # fmt: skip
    axes.grid(visible=False)
    axes.set(xlabel=label_of(grid.axes[0]), ylabel=label_of(grid.axes[1]))
    axes.set_title(f"{title}\n{_fixed(basin)}".strip())
    axes.set(xlim=(left, right), ylim=(low, high))
    if (basin.attractor == FELL).any():
        shade = f"* the darker, the more strides before: to {_most_before_a_fall(basin)}"
        handles.append(Patch(color="none", label=shade))
    figure.legend(handles=handles, loc="outside lower center", ncols=3)
    return Drawing(figure, _basin_table(basin))


def fate_pixels(basin: Basin) -> tuple[NDArray[np.float64], list[tuple[str, str]]]:
    """Colours of the starts of a slice, (up, across, 3) from 0 to 1, and what they mean.

    Returns:
        The colours, and for each hue that occurs its meaning and colour; those of falls, whose
        meaning ends in an asterisk, are the darker, the more strides the walker made before.

    Raises:
        ValueError: a basin of a list of states, which has no picture.
    """
    fate, strides = basin.picture("attractor"), basin.picture("strides")
    ends = basin.picture("outcome")
    pixels, meanings = np.empty((*fate.shape, 3)), []
    for number, name, colour in _fates(basin):
        pixels[fate == number] = to_rgb(colour)
        if (fate == number).any():
            meanings.append((name, colour))
    darker = 1.0 - 0.55 * (strides / _most_before_a_fall(basin))[..., np.newaxis]
    for outcome in map(Outcome, sorted(set(ends[fate == FELL].tolist()))):
        colour = FALLS.get(outcome, OTHER_FALL)
        here = (fate == FELL) & (ends == outcome)
        pixels[here] = (np.array(to_rgb(colour)) * darker)[here]
        meanings.append((f"{outcome.label}*", colour))
    return pixels, meanings


def _most_before_a_fall(basin: Basin) -> int:
    return max(int(basin.strides[basin.attractor == FELL].max(initial=0)), 1)


def _fixed(basin: Basin) -> str:
    """What the plane keeps, and the section that it lies on."""
    grid = basin.grid
    assert grid is not None
    free = COORDINATES if grid.on is None else grid.on.coordinates
    kept = [
        f"{name.replace('_', ' ')} {value:.4g} {'rad/s' if name.endswith('rate') else 'rad'}"
        for name, value in zip(COORDINATES, grid.base, strict=True)
        if name in free and name not in grid.axes
        and not (grid.on and name == "stance_angle")  # the swing angle stands for it
    ]  # fmt: skip
    section = [] if grid.on is None else [f"on the section: {grid.on}"]
    return ", ".join([*section, *([f"at {', '.join(kept)}"] if kept else [])])


def _fates(basin: Basin) -> Iterator[tuple[int, str, str]]:
    """Number, name and colour of what may become of those that do not fall."""
    yield WALKING, f"still walking after {basin.limit} strides", RED
    for number, gait in enumerate(basin.gaits):
        yield number, _attractor_name(gait), HUES[number % len(HUES)]


def _attractor_name(gait: Gait) -> str:
    return "ends on the gait" if gait.period == 1 else f"ends on the gait of period {gait.period}"


def _basin_table(basin: Basin) -> dict[str, ArrayLike]:
    return {
        **dict(zip(COORDINATES, basin.states.T, strict=True)),
        "attractor": basin.attractor,
        "strides": basin.strides,
        "outcome": [Outcome(value).label for value in basin.outcome.tolist()],
    }
