"""What commands put out: a report, progress on a terminal, files under --out."""

from __future__ import annotations

import argparse
import math
import shutil
import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from powered_walker_env.files import check_writable, write_text
from powered_walker_env.results import save_result

if TYPE_CHECKING:
    from powered_walker_env.pictures.charts import Drawing

UNFINISHED = ".unfinished"  # suffix of the folder that keeps the pieces of an unfinished study
PICTURE = (".png", ".svg", ".csv")  # the files of a drawing
#: Attributes of the parsed arguments that are no settings of the result.
NO_SETTINGS = ("command", "json", "out", "overwrite", "no_plot", "resumable", "saved", "drawn")


class PictureError(RuntimeError):
    """A result is saved, but it could not be drawn."""


class Report(NamedTuple):
    """What a command found: for people, for programs and for --out."""

    text: str
    data: dict[str, Any]
    status: int = 0  # exit status
    result: Any = None  # saved as BASE.npz
    texts: Mapping[str, str] | None = None  # saved as they are, by ending
    draw: Callable[[], Mapping[str, Drawing]] | None = None  # by what follows BASE


def add_out(
    parser: argparse.ArgumentParser,
    saved: Sequence[str] = (".npz",),
    drawings: Sequence[str] = ("",),
    tables: Sequence[str] = (),
    *,
    resumable: bool = False,
) -> None:
    """Arguments that choose where results and figures go.

    Args:
        saved: endings of the files besides those of drawings.
        drawings: what follows BASE in the names of drawings.
        tables: endings of the drawings' further tables.
        resumable: whether pieces of an unfinished study are kept beside BASE.
    """
    drawn = (*(f"{name}{ending}" for name in drawings for ending in PICTURE), *tables)
    files = ", ".join(f"BASE{ending}" for ending in (*saved, *drawn))
    parser.add_argument("--out", metavar="BASE", help=f"save result and pictures: {files}")
    parser.add_argument("--overwrite", action="store_true", help="replace files that exist")
    if drawn:
        parser.add_argument("--no-plot", action="store_true", help="save the result only")
    parser.set_defaults(resumable=resumable, saved=tuple(saved), drawn=drawn)


def check_out(options: argparse.Namespace) -> None:
    """Find out before the work begins whether its result can be put where it should go.

    Raises:
        OSError, ValueError: --out cannot be written; ImportError: no matplotlib.
    """
    if not _base_asked(options):
        return
    base, drawn = Path(options.out), () if _no_plot(options) else options.drawn
    if base.name in ("", ".."):
        raise ValueError(f"--out must end in a name for the files, got {options.out!r}")
    targets = [ending_in(base, ending) for ending in (*options.saved, *drawn)]
    check_writable(targets, options.overwrite)
    if drawn:
        figures()


def put_out(options: argparse.Namespace, report: Report) -> Report:
    """Save what --out asks for, the result first, and say so in the report.

    Raises:
        PictureError: the result is saved, but cannot be drawn.
    """
    if not _base_asked(options):
        return report
    base, written = Path(options.out), []
    if report.result is not None:
        settings = {k: value for k, value in vars(options).items() if k not in NO_SETTINGS}
        written.append(save_result(report.result, ending_in(base, ".npz"), settings))
    for ending, text in (report.texts or {}).items():
        written.append(ending_in(base, ending))
        write_text(written[-1], text)
    if options.resumable:
        shutil.rmtree(ending_in(base, UNFINISHED), ignore_errors=True)
    if report.draw is not None and not _no_plot(options):
        try:
            for name, drawing in report.draw().items():
                written += figures().save_drawing(drawing, ending_in(base, name))
        except Exception as error:
            raise PictureError(
                f"the result is saved ({', '.join(map(str, written))}), but its picture failed: "
                f"{type(error).__name__}: {error}"
            ) from error
    files = [str(path) for path in written]
    text, data = f"{report.text}\nwritten: {', '.join(files)}", {**report.data, "written": files}
    return report._replace(text=text, data=data)


def unfinished(options: argparse.Namespace) -> Path | None:
    """The folder beside --out for the pieces of a study; it goes once the result is saved."""
    return None if options.out is None else ending_in(Path(options.out), UNFINISHED)


def ending_in(base: Path, ending: str) -> Path:
    """The base with an ending; a point in its name is none of a suffix."""
    return base.with_name(base.name + ending)


def _base_asked(options: argparse.Namespace) -> bool:
    """Whether --out asks for files; a command with a folder of its own has no endings."""
    return options.out is not None and bool(getattr(options, "saved", ()))


def _no_plot(options: argparse.Namespace) -> bool:
    return bool(getattr(options, "no_plot", False))


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


class Progress:
    """A bar with the time left, on a terminal only; used as a context, called as work is done."""

    def __init__(self, name: str) -> None:
        self.name = name
        self._bar: Any = None

    def __enter__(self) -> Progress:
        return self

    def __exit__(self, *_: object) -> None:
        if self._bar is not None:
            self._bar.close()

    def __call__(self, done: int, total: int, seconds_left: float = math.nan) -> None:
        """Show that `done` of `total` are done; what is done at the first call took no time."""
        if self._bar is None:
            from tqdm import tqdm

            self._bar = tqdm(
                desc=self.name, total=total, initial=done, leave=False, disable=None,
                file=sys.stderr,
            )  # fmt: skip
        self._bar.update(done - self._bar.n)


def finite(value: Any) -> Any:
    """The data with null for numbers that JSON does not know."""
    if isinstance(value, dict):
        return {key: finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [finite(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
