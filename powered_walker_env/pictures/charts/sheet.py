"""A sheet to draw on: sizes, colours, labels with units; figure and numbers to files."""

from __future__ import annotations

import csv
import functools
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from io import StringIO
from pathlib import Path
from typing import Any, ParamSpec

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

from powered_walker_env.files import write_text, written_aside

P = ParamSpec("P")

BLUE, RED, GREEN, VIOLET, ORANGE = "#1f6f8b", "#c8553d", "#5f8a2e", "#8a5a99", "#d08a1d"
INK, GREY, PALE = "#222222", "#8a8a8a", "#e4e4e4"
WIDTH = 6.4  # inches: a text column and a half
DOTS = 200  # per inch, of a PNG
STYLE: Any = {
    "font.size": 9.5,
    "axes.labelsize": 10,
    "axes.titlesize": 10,
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": INK,
    "legend.frameon": False,
    "legend.fontsize": 8.5,
    "lines.linewidth": 1.5,
    "svg.hashsalt": "powered-walker-env",  # the same figure gives the same file
}
#: Labels of what a walker can be continued in, with units.
LABELS = {
    "switch_angle": "switch angle (rad)",
    "stall_torque": "stall torque (N m)",
    "impulse": "toe-off impulse (N s)",
    "hip_torque": "hip torque (N m)",
    "leg_length": "leg length (m)",
    "foot_length": "foot length (m)",
    "foot_radius": "foot radius (m)",
    "locked_ankle_angle": "locked ankle angle (rad)",
    "leg_mass": "leg mass (kg)",
    "leg_inertia": "leg inertia (kg m²)",
    "com_along": "centre of mass along the leg (m)",
    "com_across": "centre of mass across the leg (m)",
    "gravity": "gravity (m/s²)",
    "slope": "slope (rad)",
    "no_load_speed": "no-load speed (rad/s)",
    "stance_angle": "stance angle (rad)",
    "swing_angle": "swing angle (rad)",
    "stance_rate": "stance rate (rad/s)",
    "swing_rate": "swing rate (rad/s)",
}


@dataclass(frozen=True, eq=False)
class Drawing:
    """A figure and the numbers in it."""

    figure: Figure
    columns: Mapping[str, ArrayLike]  # of the CSV: name with unit -> (n,) values
    tables: Mapping[str, Mapping[str, ArrayLike]] = field(default_factory=dict)  # further CSVs


def styled(draw: Callable[P, Drawing]) -> Callable[P, Drawing]:
    """Draw in the style of the package and leave matplotlib's settings as they were."""

    @functools.wraps(draw)
    def drawn(*arguments: P.args, **named: P.kwargs) -> Drawing:
        with matplotlib.rc_context(STYLE):
            return draw(*arguments, **named)

    return drawn


def sheet(rows: int = 1, height: float = 4.0, **arguments: Any) -> tuple[Figure, Sequence[Axes]]:
    """A figure with `rows` panels one above another."""
    figure = Figure(figsize=(WIDTH, height), layout="constrained")
    panels = figure.subplots(rows, 1, squeeze=False, **arguments)[:, 0]
    for axes in panels:
        axes.grid(color=PALE, linewidth=0.6)
        axes.set_axisbelow(True)
    return figure, list(panels)


def save_drawing(
    drawing: Drawing,
    path: str | os.PathLike[str],
    formats: Sequence[str] = ("png", "svg"),
) -> list[Path]:
    """Write the figure in the formats, and a CSV for each table; each file whole or not at all.

    Args:
        path: without suffix; further tables are named `path-table.csv`.

    Raises:
        FileNotFoundError: the folder does not exist.
        ValueError: a format that matplotlib does not know.
    """
    base = Path(path)
    if not base.parent.is_dir():
        raise FileNotFoundError(f"the folder {str(base.parent)!r} does not exist; make it first")
    written = []
    for suffix in formats:
        target = base.with_name(f"{base.name}.{suffix}")
        metadata = {"Date": None} if suffix == "svg" else None
        with matplotlib.rc_context(STYLE), written_aside(target) as aside:
            drawing.figure.savefig(aside, dpi=DOTS, metadata=metadata)
        written.append(target)
    for name, columns in {"": drawing.columns, **drawing.tables}.items():
        target = base.with_name(f"{base.name}-{name}.csv" if name else f"{base.name}.csv")
        write_text(target, csv_text(columns))
        written.append(target)
    return written


def csv_text(columns: Mapping[str, ArrayLike]) -> str:
    """Columns of equal length as CSV; floats with all their digits, NaN as an empty cell."""
    text = StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    values = [np.asarray(column).tolist() for column in columns.values()]
    for row in zip(*values, strict=True):
        writer.writerow(["" if value != value else value for value in row])
    return text.getvalue()


def label_of(parameter: str) -> str:
    """A parameter's name and unit for an axis."""
    return LABELS.get(parameter, parameter.replace("_", " "))
