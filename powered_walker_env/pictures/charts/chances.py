"""Pictures of disturbed walks: how long they last, and what can be saved."""

from __future__ import annotations

import numpy as np
from matplotlib.colors import to_rgb
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from powered_walker_env.pictures.charts.sheet import (
    BLUE,
    GREY,
    INK,
    ORANGE,
    PALE,
    Drawing,
    label_of,
    sheet,
    styled,
)
from powered_walker_env.poincare import Capture, FirstPassage

SHOWN = 1e-3  # of the walks: how far down survival is drawn
FINE = 200  # points across and up of a slice


@styled
def passage_figure(passage: FirstPassage, *, title: str = "") -> Drawing:
    """The share of walks that last so many strides: as walked, by the table, by its eigenvalue."""
    walks = passage.walks
    longest = int(min(walks.limit, max(10, np.quantile(walks.strides, 1.0 - SHOWN))))
    walked = walks.survival(longest)
    counts = np.arange(len(walked))
    table = passage.survival[: len(walked)]
    table = np.pad(table, (0, len(walked) - len(table)), constant_values=np.nan)
    share = passage.second_eigenvalue
    at = min(len(walked) - 1, max(1, int(np.median(walks.strides))))
    slope = walked[at] * share ** (counts - at)
    figure, (axes,) = sheet(1, 4.0)
    axes.semilogy(counts, walked, ".", color=BLUE, label=f"{len(walks.strides)} plain walks")
    axes.semilogy(counts, table, color=INK, label="stay on the grid, by the table")
    rate = f"second eigenvalue {share:.4f}: {passage.mean_first_passage:.4g} strides in the mean"
    axes.semilogy(counts, slope, "--", color=ORANGE, label=rate)
    axes.set(xlabel="strides", ylabel="share of the walks that walk them", title=title)
    axes.set_ylim(SHOWN, 1.3)
    figure.legend(loc="outside lower center", ncols=2)
    columns = {"strides": counts, "walked": walked, "on_grid": table, "eigenvalue": slope}
    return Drawing(figure, columns)


@styled
def viability_figure(found: Capture, *, title: str = "") -> Drawing:
    """Saved, lost and open in the planes of the grid through the gait, two coordinates each."""
    grid = found.grid
    section = grid.section
    assert section is not None
    here = section.points([found.gait.state])[0]
    names, pairs = section.coordinates, [(0, 1), (0, 2)][: max(1, len(here) - 1)]
    low, high = grid.points.min(axis=0), grid.points.max(axis=0)
    figure, panels = sheet(len(pairs), 3.4 * len(pairs) + 0.6)
    colours = {1: BLUE, 0: PALE, -1: ORANGE}
    table: dict[str, list[float]] = {name: [] for name in (*names, "fate")}
    for axes, (i, j) in zip(panels, pairs, strict=True):
        across, up = np.meshgrid(
            np.linspace(low[i], high[i], FINE), np.linspace(low[j], high[j], FINE)
        )
        points = np.tile(here, (across.size, 1))
        points[:, i], points[:, j] = across.ravel(), up.ravel()
        fate = _nearest(found, points)
        picture = np.array([to_rgb(colours[value]) for value in fate.tolist()])
        axes.imshow(
            picture.reshape(FINE, FINE, 3), origin="lower", aspect="auto",
            extent=(low[i], high[i], low[j], high[j]), interpolation="nearest",
        )  # fmt: skip
        axes.plot(here[i], here[j], "o", color="white", markeredgecolor=INK, markersize=6)
        axes.grid(visible=False)
        axes.set(xlabel=label_of(names[i]), ylabel=label_of(names[j]))
        for name, column in zip(names, points.T, strict=True):
            table[name] += column.tolist()
        table["fate"] += fate.tolist()
    panels[0].set_title(f"{title}\non the section: {section}, through the gait".strip())
    handles: list[Patch | Line2D] = [
        Patch(color=BLUE, label=f"saved for {found.strides} strides"),
        Patch(color=PALE, label="left open by the grid"),
        Patch(color=ORANGE, label="lost whatever is done"),
        Line2D([], [], marker="o", color="white", markeredgecolor=GREY, ls="", label="the gait"),
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=2)
    return Drawing(figure, table)


def _nearest(found: Capture, points: np.ndarray) -> np.ndarray:
    """The fate of the node nearest to each point (N, k)."""
    grid = found.grid
    last = np.array(grid.table_shape) - 1
    places = np.clip(np.rint(grid.places(points)), 0, last).astype(np.int64)
    fate: np.ndarray = found.fate[np.ravel_multi_index(tuple(places.T), grid.table_shape)]
    return fate
