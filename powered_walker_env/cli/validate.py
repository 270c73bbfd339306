"""`powered-walker validate`: published values, and what comes out here."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

from powered_walker_env.cli.options import add_command
from powered_walker_env.cli.output import Progress, Report
from powered_walker_env.files import write_text
from powered_walker_env.literature.values import (
    FAMILIES,
    table_csv,
    table_data,
    table_text,
    validate,
)
from powered_walker_env.results import versions

SUFFIXES = (".csv", ".json")


def add_commands(commands: Any) -> None:
    """Add this command."""
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
    check.add_argument("--out", metavar="BASE", help="save the table as BASE.csv and BASE.json")
    check.add_argument("--overwrite", action="store_true", help="replace files that exist")


def _validate(options: argparse.Namespace) -> Report:
    files = _files(options)
    with Progress("validate") as progress:
        rows = validate(options.only, long=options.long, progress=progress)
    data = table_data(rows) | {"versions": versions()}
    report = Report(table_text(rows), data, status=int(data["fail"] > 0))
    if not files:
        return report
    write_text(files[0], table_csv(rows))
    write_text(files[1], json.dumps(data, indent=1, ensure_ascii=False))
    names = [str(path) for path in files]
    text = f"{report.text}\nwritten: {', '.join(names)}"
    return report._replace(text=text, data={**data, "written": names})


def _files(options: argparse.Namespace) -> list[Path]:
    """What --out asks for, before anything is computed.

    Raises:
        FileExistsError, FileNotFoundError, ValueError: it cannot be written.
    """
    if options.out is None:
        return []
    base = Path(options.out)
    if base.name in ("", ".."):
        raise ValueError(f"--out must end in a name for the files, got {options.out!r}")
    if not base.parent.is_dir():
        raise FileNotFoundError(f"the folder {str(base.parent)!r} does not exist; make it first")
    files = [base.with_name(base.name + suffix) for suffix in SUFFIXES]
    for file in files:
        if file.exists() and not options.overwrite:
            raise FileExistsError(
                f"{str(file)!r} exists already; choose another --out, or --overwrite"
            )
    return files
