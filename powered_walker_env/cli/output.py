"""What commands put out: a report, progress on a terminal, files under --out."""

from __future__ import annotations

import argparse
import math
import shutil
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from powered_walker_env.results import save_result

if TYPE_CHECKING:
    from powered_walker_env.pictures.charts import Drawing

BAR = 24  # characters
UNFINISHED = ".unfinished"  # suffix of the folder that keeps the pieces of an unfinished study


class Report(NamedTuple):
    """What a command found: for people and for programs."""

    text: str
    data: dict[str, Any]
    status: int = 0  # exit status


def add_out(parser: argparse.ArgumentParser, *, resumable: bool = False) -> None:
    """Arguments that choose where results and figures go."""
    parser.add_argument(
        "--out", metavar="BASE", help="save the result as BASE.npz, its figure as BASE.png and "
        "BASE.svg, and its numbers as BASE.csv",
    )  # fmt: skip
    parser.add_argument("--overwrite", action="store_true", help="replace files that exist")
    parser.add_argument("--no-plot", action="store_true", help="save the result only")
    parser.set_defaults(resumable=resumable)


def check_out(options: argparse.Namespace) -> None:
    """Find out before the work begins whether its result can be put where it should go.

    Raises:
        FileExistsError, FileNotFoundError: --out cannot be written; ImportError: no matplotlib.
    """
    if options.out is None:
        return
    base = Path(options.out)
    if not base.name:
        raise ValueError(f"--out must end in a name for the files, got {options.out!r}")
    if not base.parent.is_dir():
        raise FileNotFoundError(f"the folder {str(base.parent)!r} does not exist; make it first")
    result = _result_file(base)
    if result.exists() and not options.overwrite:
        raise FileExistsError(
            f"{str(result)!r} exists already; choose another --out, or --overwrite"
        )
    if not options.no_plot:
        figures()


def put_out(
    options: argparse.Namespace, report: Report, result: Any, draw: Callable[[], Drawing]
) -> Report:
    """Save a result and its figure if --out asks for it, and say so in the report."""
    if options.out is None:
        return report
    base, kept = Path(options.out), ("command", "json", "out", "overwrite", "no_plot", "resumable")
    settings = {name: value for name, value in vars(options).items() if name not in kept}
    written = []
    if not options.no_plot:
        written += figures().save_drawing(draw(), base)
    written.append(save_result(result, _result_file(base), settings))
    files = [str(path) for path in written]
    return Report(f"{report.text}\nwritten: {', '.join(files)}", {**report.data, "written": files})


def _result_file(base: Path) -> Path:
    return base.with_name(f"{base.name}.npz")


def figures() -> Any:
    """The module that draws.

    Raises:
        ImportError: without matplotlib, with the remedy.
    """
    try:
        from powered_walker_env.pictures import charts as module
    except ModuleNotFoundError as error:
        if error.name and error.name.partition(".")[0] == "matplotlib":
            raise ImportError(
                "plots need matplotlib: pip install 'powered-walker-env[render]', or --no-plot"
            ) from error
        raise
    return module


@contextmanager
def unfinished(options: argparse.Namespace) -> Iterator[Path | None]:
    """A folder beside --out for the pieces of a study; it goes when the study is done."""
    if options.out is None:
        yield None
        return
    base = Path(options.out)
    folder = base.with_name(base.name + UNFINISHED)
    yield folder
    shutil.rmtree(folder, ignore_errors=True)


class Progress:
    """A bar with the time left, on a terminal only; used as a context, called as work is done."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.shown = sys.stderr.isatty()

    def __enter__(self) -> Progress:
        return self

    def __exit__(self, *_: object) -> None:
        if self.shown:
            print("\r\x1b[K", end="", file=sys.stderr, flush=True)

    def __call__(self, done: int, total: int, seconds_left: float) -> None:
        if self.shown:
            line = bar(self.name, done, total, seconds_left)
            print(f"\r{line}\x1b[K", end="", file=sys.stderr, flush=True)


def bar(name: str, done: int, total: int, seconds_left: float) -> str:
    """One line: name, bar, share and time left."""
    filled = BAR * done // total
    left = "" if seconds_left != seconds_left else f"  {clock(seconds_left)} left"
    return f"{name} [{'#' * filled}{'.' * (BAR - filled)}] {100 * done // total:3d} %{left}"


def clock(seconds: float) -> str:
    """Seconds as minutes and seconds, or hours and minutes."""
    whole = round(seconds)
    if whole >= 3600:
        return f"{whole // 3600} h {whole % 3600 // 60:02d} min"
    return f"{whole // 60}:{whole % 60:02d}"


def finite(value: Any) -> Any:
    """The data with null for numbers that JSON does not know."""
    if isinstance(value, dict):
        return {key: finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [finite(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
