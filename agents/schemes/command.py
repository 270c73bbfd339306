"""The same legs under all actuation schemes at equal speed: measures, figures and tables.

Writes schemes.json and figures into a folder, whole or not at all. One core, about a minute.
"""

from __future__ import annotations

import argparse
import json
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from agents.command import CONFIGS
from agents.schemes.cases import CASES, Case
from agents.schemes.content import content
from agents.schemes.figures import figures
from agents.schemes.tables import coordination, efficiency
from powered_walker_env.files import folder_aside, write_text

PAGES = CONFIGS.parent / "docs" / "questions"
CONTENT = "schemes.json"
DIGITS = 7  # significant, of the numbers in the JSON
SMALL: dict[str, Any] = {
    "cases": (Case("camp1997"),), "loops": ("toe-off",), "maps": ("kneed",), "nodes": 3,
    "samples": 20,
}  # fmt: skip


def parser() -> argparse.ArgumentParser:
    """The command line."""
    result = argparse.ArgumentParser(
        prog="python -m agents.schemes", description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )  # fmt: skip
    result.add_argument(
        "--out", type=Path, metavar="FOLDER", help="a folder that does not exist yet"
    )
    result.add_argument(
        "--legs", nargs="+", metavar="PRESET", help="only cases of these legs, with no maps"
    )
    result.add_argument("--small", action="store_true", help="very little: a trial of the code")
    result.add_argument(
        "--publish", action="store_true", help="into docs/questions, beside the pages, instead"
    )
    result.add_argument(
        "--redraw", action="store_true", help="with --publish: from the measures that are there"
    )
    return result


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command.

    Raises:
        ValueError: bad arguments. FileExistsError: the folder exists.
    """
    options = parser().parse_args(arguments)
    if (options.out is None) != options.publish:
        raise ValueError("give either --out FOLDER or --publish")
    if options.publish and (options.small or options.legs):
        raise ValueError("--publish must be left out with --small and --legs, which are not all")
    if options.redraw and not options.publish:
        raise ValueError("--redraw must go with --publish: it draws what was published")
    chosen = _chosen(options)
    if options.out is not None and options.out.exists():
        raise FileExistsError(f"--out must not exist yet, got {str(options.out)!r}; choose another")
    if options.out is not None and not options.out.absolute().parent.is_dir():
        raise FileNotFoundError(f"the folder of {str(options.out)!r} does not exist; make it first")
    if options.redraw:
        found = json.loads((PAGES / CONTENT).read_text(encoding="utf-8"))
    else:
        found = rounded(content(told=lambda what: print(what, flush=True), **chosen))
    found["tables"] = {"coordination": coordination(found), "efficiency": efficiency(found)}
    if options.publish:
        written = _write(found, PAGES)
    else:
        with folder_aside(options.out) as aside:
            written = [options.out / path.name for path in _write(found, aside)]
    print(f"{found['seconds']:g} s of processor time")
    for path in written:
        print(path)


def _chosen(options: argparse.Namespace) -> dict[str, Any]:
    chosen = dict(SMALL) if options.small else {}
    if options.legs:
        cases = tuple(case for case in CASES if case.legs in options.legs)
        known = sorted({case.legs for case in CASES})
        if unknown := sorted(set(options.legs) - set(known)):
            raise ValueError(f"--legs must be of {', '.join(known)}, got {', '.join(unknown)}")
        chosen |= {"cases": cases, "loops": (), "maps": ()}
    return chosen


def _write(found: dict[str, Any], folder: Path) -> list[Path]:
    """Figures, then the JSON that they are of, on one line: it is long."""
    written = figures(found, folder)
    write_text(folder / CONTENT, json.dumps(found, allow_nan=False) + "\n")
    return [*written, folder / CONTENT]


def rounded(value: Any) -> Any:
    """The same with numbers of so many digits as are meant, none that JSON does not know.

    Raises:
        ValueError: a number that is not finite.
    """
    if isinstance(value, dict):
        return {name: rounded(each) for name, each in value.items()}
    if isinstance(value, list | tuple):
        return [rounded(each) for each in value]
    if isinstance(value, float):
        if not math.isfinite(value):
            raise ValueError(f"measures must be finite, got {value!r}")
        return float(f"{value:.{DIGITS}g}")
    return value
