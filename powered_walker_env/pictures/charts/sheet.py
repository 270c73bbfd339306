"""A sheet to draw on: sizes, colours, labels with units; figure and numbers to files."""

from __future__ import annotations

import contextlib
import functools
import io
import os
import textwrap
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, ParamSpec, TypeVar

import matplotlib
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

from powered_walker_env.files import write_text, written_aside
from powered_walker_env.model.knee import Knee
from powered_walker_env.model.powering import SCHEMES
from powered_walker_env.model.quantities import quantities
from powered_walker_env.model.walker import WalkerParams
from powered_walker_env.poincare.branches.paths import PATH
from powered_walker_env.tabular import csv_text

P = ParamSpec("P")

BLUE, RED, GREEN, VIOLET, ORANGE = "#1f6f8b", "#c8553d", "#5f8a2e", "#8a5a99", "#d08a1d"
INK, GREY, PALE = "#222222", "#8a8a8a", "#e4e4e4"
WIDTH = 6.4  # inches: a text column and a half
DOTS = 200  # per inch, of a PNG
NOTEBOOK_DOTS = 110  # the same in a notebook
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
#: One colour after the other, told apart by all eyes.
PALETTE = (RED, BLUE, GREEN, VIOLET, ORANGE)
LONGEST_LABEL = 44  # characters of a line


@dataclass(frozen=True, eq=False)
class Drawing:
    """A figure and the numbers in it."""

    figure: Figure
    columns: Mapping[str, ArrayLike]  # of the CSV: name with unit -> (n,) values
    tables: Mapping[str, Mapping[str, ArrayLike]] = field(default_factory=dict)  # further CSVs

    def __repr__(self) -> str:
        return f"Drawing({', '.join(self.columns)})"

    def _repr_png_(self) -> bytes:
        """The figure, for notebooks."""
        with _own_style(), io.BytesIO() as file:
            self.figure.savefig(file, format="png", dpi=NOTEBOOK_DOTS)
            return file.getvalue()


D = TypeVar("D", Drawing, Drawing | None)  # None: there is nothing to draw


def styled(draw: Callable[P, D]) -> Callable[P, D]:
    """Draw in the style of the package and leave matplotlib's settings as they were."""

    @functools.wraps(draw)
    def drawn(*arguments: P.args, **named: P.kwargs) -> D:
        with _own_style():
            return draw(*arguments, **named)

    return drawn


@contextlib.contextmanager
def _own_style() -> Iterator[None]:
    """The style of the package over matplotlib's own, whatever a user's matplotlibrc says."""
    with matplotlib.rc_context():
        matplotlib.rcdefaults()
        matplotlib.rcParams.update(STYLE)
        yield


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
    named = [base.with_name(f"{base.name}.{suffix}") for suffix in formats]
    written = [save_figure(drawing, target) for target in named]
    for name, columns in {"": drawing.columns, **drawing.tables}.items():
        target = base.with_name(f"{base.name}-{name}.csv" if name else f"{base.name}.csv")
        write_text(target, csv_text(columns))
        written.append(target)
    return written


def save_figure(drawing: Drawing, path: str | os.PathLike[str]) -> Path:
    """Write a drawing's figure only; the suffix of `path` says the format.

    Raises:
        ValueError: a suffix that matplotlib does not know.
        FileNotFoundError: the folder does not exist.
    """
    target = Path(path)
    if not target.parent.is_dir():
        raise FileNotFoundError(f"the folder {str(target.parent)!r} does not exist; make it first")
    metadata = {"Date": None} if target.suffix == ".svg" else None
    with _own_style(), written_aside(target) as aside:
        drawing.figure.savefig(aside, dpi=DOTS, metadata=metadata)
    return target


def label_of(name: str) -> str:
    """What a number of a walker, a control or a post-strike state is, and its unit, for an axis."""
    if name == PATH:
        return "λ along the path"
    label, unit = name.replace("_", " "), "rad/s" if name.endswith("rate") else "rad"
    for owner in (WalkerParams, Knee, *(each.control for each in SCHEMES.values())):
        if owner is not None and name in quantities(owner):
            label, unit = quantities(owner)[name].label, quantities(owner)[name].unit
            break
    whole = unit.replace(" ", "\u00a0")  # a unit is not broken
    return textwrap.fill(f"{label} ({whole})" if unit else label, LONGEST_LABEL)
