"""`powered-walker energetics`: what walking costs, by what powers it."""

from __future__ import annotations

import argparse
import json
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from powered_walker_env.cli.options import add_command
from powered_walker_env.cli.output import Report, figures, finite
from powered_walker_env.files import write_text
from powered_walker_env.model.powering import SCHEMES, ToeOff
from powered_walker_env.model.presets import PRESETS
from powered_walker_env.poincare.energy.energetics import (
    STEP,
    Costs,
    at_equal_gait,
    comparison,
    first_gait,
)
from powered_walker_env.results import versions

SUFFIXES = (".csv", ".json", ".png", ".svg")
COLUMNS = ("speed", "step", "mechanical", "net", "electrical", "ideal push", "least", "radius")


def add_commands(commands: Any) -> None:
    """Add this command."""
    parser = add_command(
        commands,
        "energetics",
        _energetics,
        "cost of transport against speed and step length, by what powers the walker",
    )
    parser.add_argument(
        "--preset", default="compass", choices=PRESETS, help="(default %(default)s)"
    )
    parser.add_argument(
        "--scheme", nargs="+", choices=SCHEMES, metavar="NAME",
        help=f"some of {', '.join(SCHEMES)} (default: all that the preset's legs can walk with)",
    )  # fmt: skip
    parser.add_argument(
        "--step", type=float, default=STEP, help="arclength between gaits (default %(default)s)"
    )
    parser.add_argument(
        "--out", metavar="BASE", help="save the table as BASE.csv and BASE.json, and the figure as "
        "BASE.png and BASE.svg",
    )  # fmt: skip
    parser.add_argument("--overwrite", action="store_true", help="replace files that exist")


def _energetics(options: argparse.Namespace) -> Report:
    base = _base(options)
    families = comparison(options.preset, options.scheme, step=options.step)
    timings = _timings(options.preset, families)
    data = {
        "preset": options.preset,
        "families": {name: [_plain(row) for row in rows] for name, rows in families.items()},
        "at_equal_gait": {name: _plain(row) for name, row in timings.items()},
    }
    report = Report(_text(options.preset, families, timings), data)
    if base is None:
        return report
    title = f"Cost of transport on the legs of {options.preset}"
    drawing = figures().energetics_figure(families, title=title)
    written = figures().save_drawing(drawing, base)
    table = base.with_name(base.name + ".json")
    saved = finite({**data, "versions": versions()})
    write_text(table, json.dumps(saved, indent=1, ensure_ascii=False))
    names = [str(path) for path in (*written, table)]
    return Report(f"{report.text}\nwritten: {', '.join(names)}", {**data, "written": names})


def _timings(preset: str, families: Mapping[str, Sequence[Costs]]) -> dict[str, Costs]:
    """The first toe-off gait's costs by when it pushes; nothing where no family has one."""
    for name in (name for name, rows in families.items() if rows):
        if isinstance((gait := first_gait(name, preset)[0]).control, ToeOff):
            return at_equal_gait(gait)
    return {}


def _base(options: argparse.Namespace) -> Path | None:
    """What --out asks for, before anything is computed.

    Raises:
        FileExistsError, FileNotFoundError, ValueError: it cannot be written; ImportError: no
            matplotlib.
    """
    if not options.step > 0:
        raise ValueError(f"--step must be positive, got {options.step!r}")
    if options.out is None:
        return None
    base = Path(options.out)
    if base.name in ("", ".."):
        raise ValueError(f"--out must end in a name for the files, got {options.out!r}")
    if not base.parent.is_dir():
        raise FileNotFoundError(f"the folder {str(base.parent)!r} does not exist; make it first")
    for suffix in SUFFIXES:
        file = base.with_name(base.name + suffix)
        if file.exists() and not options.overwrite:
            raise FileExistsError(
                f"{str(file)!r} exists already; choose another --out, or --overwrite"
            )
    figures()
    return base


def _plain(row: Costs) -> dict[str, Any]:
    return {**row._asdict(), "mechanical": row.mechanical}


def _text(
    preset: str, families: Mapping[str, Sequence[Costs]], timings: Mapping[str, Costs]
) -> str:
    lines = [f"cost of transport on the legs of {preset}", _line("", COLUMNS)]
    for name, rows in families.items():
        if not rows:
            lines.append(f"{name}: no gait found")
            continue
        lines.append(f"{name}, by {rows[0].parameter.replace('_', ' ')}")
        for index in np.unique(np.linspace(0, len(rows) - 1, 5).round().astype(int)).tolist():
            lines.append(_line(f"  {rows[index].value:.5g}", _cells(rows[index])))
    if timings:
        lines.append("the same toe-off gait, pushed before, with or after the heel strike")
        lines += [_line(f"  {name}", _cells(row)) for name, row in timings.items()]
    return "\n".join(lines)


def _cells(row: Costs) -> list[str]:
    values = (row.speed, row.step_length, row.mechanical, row.net, row.electrical, row.ideal,
              row.least, row.spectral_radius)  # fmt: skip
    return ["-" if math.isnan(value) else f"{value:.4g}" for value in values]


def _line(name: str, cells: Sequence[str]) -> str:
    return f"{name:<22}" + "".join(f"{cell:>12}" for cell in cells)
