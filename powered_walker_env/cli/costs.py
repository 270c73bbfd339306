"""`powered-walker energetics`: what walking costs, by what powers it."""

from __future__ import annotations

import argparse
import json
import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from powered_walker_env.cli.options import add_command, add_preset
from powered_walker_env.cli.output import Report, add_out, figures, finite
from powered_walker_env.model.powering import SCHEMES, ToeOff
from powered_walker_env.poincare import Costs, at_equal_gait, comparison
from powered_walker_env.poincare.energy.energetics import STEP, first_gait
from powered_walker_env.results import versions
from powered_walker_env.tabular import aligned

SHOWN = 5  # gaits of a family in the table
COLUMNS = ("speed, m/s", "step, m", "mechanical", "net", "electrical", "ideal push", "least",
           "largest multiplier")  # fmt: skip


def add_commands(commands: Any) -> None:
    """Add this command."""
    parser = add_command(
        commands, "energetics", _energetics,
        "cost of transport against speed and step length, by what powers the walker",
    )  # fmt: skip
    add_preset(parser, "compass")
    parser.add_argument(
        "--scheme", nargs="+", choices=SCHEMES, metavar="NAME",
        help=f"some of {', '.join(SCHEMES)} (default: all that the preset's legs can walk with)",
    )  # fmt: skip
    parser.add_argument(
        "--step", type=float, default=STEP, help="arclength between gaits (default %(default)s)"
    )
    add_out(parser, saved=(".json",))


def _energetics(options: argparse.Namespace) -> Report:
    if not 0 < options.step < math.inf:
        raise ValueError(f"--step must be positive, got {options.step!r}")
    families = comparison(options.preset, options.scheme, step=options.step)
    timings = _timings(options.preset, families)
    data = {
        "preset": options.preset,
        "families": {name: [_plain(row) for row in rows] for name, rows in families.items()},
        "at_equal_gait": {name: _plain(row) for name, row in timings.items()},
    }
    saved = finite({**data, "versions": versions()})
    title = f"Cost of transport on the legs of {options.preset}"
    return Report(
        _text(options.preset, families, timings), data,
        texts={".json": json.dumps(saved, indent=1, ensure_ascii=False)},
        draw=lambda: {"": figures().energetics_figure(families, title=title)},
    )  # fmt: skip


def _timings(preset: str, families: Mapping[str, Sequence[Costs]]) -> dict[str, Costs]:
    """The first toe-off gait's costs by when it pushes; nothing where no family has one."""
    for name in (name for name, rows in families.items() if rows):
        if isinstance((gait := first_gait(name, preset)[0]).control, ToeOff):
            return at_equal_gait(gait)
    return {}


def _plain(row: Costs) -> dict[str, Any]:
    return {**row._asdict(), "mechanical": row.mechanical}


def _text(
    preset: str, families: Mapping[str, Sequence[Costs]], timings: Mapping[str, Costs]
) -> str:
    rows: list[tuple[str, ...]] = [("", *COLUMNS)]
    for name, found in families.items():
        if not found:
            rows.append((f"{name}: no gait found",))
            continue
        rows.append((f"{name}, by {found[0].parameter.replace('_', ' ')}",))
        for index in np.unique(np.linspace(0, len(found) - 1, SHOWN).round().astype(int)).tolist():
            rows.append((f"  {found[index].value:.5g}", *_cells(found[index])))
    if timings:
        rows.append(("the same toe-off gait, pushed before, with or after the heel strike",))
        rows += [(f"  {name}", *_cells(row)) for name, row in timings.items()]
    return "\n".join([f"cost of transport on the legs of {preset}", *aligned(rows)])


def _cells(row: Costs) -> list[str]:
    values = (row.speed, row.step_length, row.mechanical, row.net, row.electrical, row.ideal,
              row.least, row.spectral_radius)  # fmt: skip
    return ["-" if math.isnan(value) else f"{value:.4g}" for value in values]
