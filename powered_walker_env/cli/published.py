"""`powered-walker validate`, `reproduce`: what others have published, and what comes out here."""

from __future__ import annotations

import argparse
import json
from typing import Any

from powered_walker_env.cli.options import add_command
from powered_walker_env.cli.output import Progress, Report, add_out, figures
from powered_walker_env.literature.values import (
    FAMILIES,
    table_csv,
    table_data,
    table_text,
    validate,
)
from powered_walker_env.results import versions


def add_commands(commands: Any) -> None:
    """Add this family's commands."""
    check = add_command(
        commands, "validate", _validate, "compare with every published value that is known here"
    )
    check.add_argument(
        "--only", nargs="+", choices=FAMILIES, metavar="FAMILY",
        help=f"some of {', '.join(FAMILIES)}",
    )  # fmt: skip
    check.add_argument(
        "--long", action="store_true", help="the cascades of doublings, too: a minute or two"
    )
    add_out(check, saved=(".csv", ".json"), drawings=())
    again = add_command(
        commands, "reproduce", _reproduce,
        "redraw the thesis's figures 4, 5 and 6, and check its text",
    )  # fmt: skip
    again.add_argument("--out", default="reproduce", help="folder, made (default %(default)s)")
    again.add_argument("--overwrite", action="store_true", help="replace files that exist")


def _validate(options: argparse.Namespace) -> Report:
    with Progress("validate") as progress:
        rows = validate(options.only, long=options.long, progress=progress)
    data = table_data(rows) | {"versions": versions()}
    saved = json.dumps(data, indent=1, ensure_ascii=False)
    return Report(
        table_text(rows), data, status=int(data["fail"] > 0),
        texts={".csv": table_csv(rows), ".json": saved},
    )  # fmt: skip


def _reproduce(options: argparse.Namespace) -> Report:
    figures()
    from powered_walker_env.literature.figures import report_text, reproduce

    with Progress("reproduce") as progress:
        report = reproduce(options.out, overwrite=options.overwrite, progress=progress)
    return Report(f"{report_text(report)}\nwritten: {options.out}", report)
