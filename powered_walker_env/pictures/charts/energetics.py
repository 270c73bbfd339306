"""What walking costs: cost of transport against speed and step length, a curve per scheme."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

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
from powered_walker_env.poincare import Costs

COLOURS = {
    "passive": INK,
    "toe-off": BLUE,
    "toe-off-at-strike": GREEN,
    "late-toe-off": ORANGE,
    "hip-torque": RED,
    "motor": VIOLET,
    "motor-with-stop": BLUE,
}
LABELS = {
    "passive": "gravity, on a slope",
    "toe-off": "push-off just before heel strike",
    "toe-off-at-strike": "push-off with heel strike",
    "late-toe-off": "push-off just after heel strike",
    "hip-torque": "hip torque",
    "motor": "ankle motor",
    "motor-with-stop": "ankle motor with a stop",
}
FAINT = 0.35  # of lines where gaits are unstable
DRAWN_CURRENT = "-."
ACROSS = {"speed": "speed (m/s)", "step_length": "step length (m)"}


@styled
def energetics_figure(families: Mapping[str, Sequence[Costs]], *, title: str = "") -> Drawing:
    """Mechanical cost of transport of families of gaits, and what a mass would need at least.

    Lines are faint where gaits are unstable. Dashed, in the colour of each family: the least
    cost of a mass on point feet at its speeds and step lengths; dash-dotted, for ankle motors:
    what they draw.

    Args:
        families: name of the scheme -> its gaits' costs, in order (`comparison`).

    Raises:
        ValueError: no gait at all.
    """
    drawn = {name: rows for name, rows in families.items() if rows}
    if not drawn:
        raise ValueError("families must hold at least one gait; there is nothing to draw")
    figure, panels = sheet(2, 7.2)
    for axes, across in zip(panels, ACROSS, strict=True):
        for name, rows in drawn.items():
            _family(axes, across, name, rows)
        axes.set(xlabel=ACROSS[across], ylabel="cost of transport", yscale="log")
    panels[0].set_title(title)
    panels[0].plot([], [], "--", color=GREY, label="dashed: least for a mass on point feet")
    if any(row.spectral_radius >= 1.0 for rows in drawn.values() for row in rows):
        panels[0].plot([], [], color=INK, alpha=FAINT, label="faint: unstable gaits")
    if any(np.isfinite(row.electrical) for rows in drawn.values() for row in rows):
        panels[0].plot(
            [], [], DRAWN_CURRENT, color=GREY, label="dash-dotted: drawn from the supply"
        )
    figure.legend(loc="outside lower center", ncols=2)
    every = [row for rows in drawn.values() for row in rows]
    columns = {field: [getattr(row, field) for row in every] for field in Costs._fields}
    return Drawing(figure, {**columns, "mechanical": [row.mechanical for row in every]})


def _family(axes: Axes, across: str, name: str, rows: Sequence[Costs]) -> None:
    colour = COLOURS.get(name, GREY)
    x = np.array([getattr(row, across) for row in rows])
    cost = np.array([row.mechanical for row in rows])
    stable = np.array([row.spectral_radius < 1.0 for row in rows])
    label = LABELS.get(name, name) if axes.get_subplotspec().is_first_row() else None  # type: ignore[union-attr]
    axes.plot(x, cost, color=colour, alpha=FAINT)
    axes.plot(x, _where(stable, cost), color=colour, label=label)
    axes.plot(x, [row.least for row in rows], "--", color=colour, linewidth=0.9)
    axes.plot(x, [row.electrical for row in rows], DRAWN_CURRENT, color=colour, linewidth=1.1)


def _where(good: NDArray[np.bool_], values: NDArray[np.float64]) -> NDArray[np.float64]:
    """The values with gaps where they are not good."""
    return np.where(good, values, np.nan)
