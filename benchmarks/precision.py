"""Work and precision: how many strides a second, and how far off they are."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING

import numpy as np

from benchmarks.strides import MANY, STARTS, Method, Problem, methods
from benchmarks.timing import Array, Case, Section, Timing, measure
from powered_walker_env.simulation.arguments import LOOSEST, TIGHTEST
from powered_walker_env.tabular import aligned

if TYPE_CHECKING:
    from powered_walker_env.pictures.charts import Drawing

RTOLS = (1e-4, 1e-6, 1e-8, 1e-10, 1e-12)
OWN = "ours, a batch"
LOST = 1e-2  # an error from which it is another stride: steps so long that they miss an event


@dataclass(frozen=True)
class Rung:
    """A method at one tolerance."""

    method: str
    cores: str  # "1" or "all"
    rtol: float
    error: float  # largest component of the post-strike state over the starts, rad and rad/s
    strides_per_second: float  # of CPU time on one core, of wall time on all
    ratio: float  # to scipy's plain DOP853 at equal error; NaN if there is none
    given: float  # cores that the machine gave: fewer where others use it, too


def precision(problem: Problem, rtols: Sequence[float] = RTOLS, seconds: float = 1.0) -> Section:
    """Measure all methods at all tolerances, in the same rounds.

    Args:
        seconds: for each method, shared out over the tolerances.

    Raises:
        ValueError: a tolerance out of bounds.
    """
    tolerances = check_rtols(rtols)
    present = [method for method in methods() if not method.missing]
    missing = {method.name: method.missing for method in methods() if method.missing}
    errors, cases = [], []
    for method in present:
        batch = np.resize(problem.starts, (method.batch, 4))
        for rtol in tolerances:
            advance = method.make(problem, rtol)
            errors.append(problem.error(advance(problem.starts[:STARTS])))
            cases.append(Case(lambda f=advance, b=batch: f(b), method.batch))  # type: ignore[misc]
    timings = measure(cases, seconds / len(tolerances))
    rungs = _rungs(present, tolerances, np.reshape(errors, (len(present), -1)), timings)
    agreement = {
        method.name: problem.error(method.make(problem, TIGHTEST)(problem.starts[:STARTS]))
        for method in present
        if not method.name.startswith("ours")
    }
    worst = {rtol: problem.error(problem.walked(problem.starts, rtol)) for rtol in tolerances}
    shape = (len(present), len(tolerances))
    ahead = leads(
        [method.name for method in present],
        np.reshape(errors, shape),
        np.array([1.0 / timing.cpu for timing in timings]).reshape(*shape, -1),
    )
    return Section(
        "\n\n".join(
            [_text(problem, rungs, missing, agreement, worst), _leads_text(tolerances, ahead)]
        ),
        {
            "rungs": [asdict(rung) for rung in rungs], "missing": missing,
            "agreement": agreement, "worst_of_many": worst, "leads": ahead,
        },
        lambda: {"work_precision": _drawing(problem, rungs)},
    )  # fmt: skip


def check_rtols(rtols: Sequence[float]) -> tuple[float, ...]:
    """The tolerances from loose to tight, each once.

    Raises:
        ValueError: one out of bounds.
    """
    for rtol in rtols:
        if not TIGHTEST <= rtol <= LOOSEST:
            raise ValueError(f"rtol must lie in [{TIGHTEST}, {LOOSEST}], got {rtol!r}")
    return tuple(sorted({float(rtol) for rtol in rtols}, reverse=True))


def speed_at(error: float, errors: Array, speeds: Array) -> float:
    """Speed of a method at an error, between its rungs log against log; at an end's beyond it.

    NaN if no rung, or the error asked for, is that of the same stride (`LOST`).
    """
    good = (errors > 0) & (errors < LOST)
    if not good.any() or not error < LOST:
        return float("nan")
    order = np.argsort(errors[good])
    x, y = np.log(errors[good][order]), np.log(speeds[good][order])
    return float(np.exp(np.interp(np.log(max(error, 1e-300)), x, y)))


def leads(names: Sequence[str], errors: Array, speeds: Array) -> dict[str, list[float]]:
    """How many times as fast as each of the others this package's batch is on one core.

    At equal error, for each tolerance: the larger of the two errors there, which both methods
    reach, so that neither is read beyond its last rung; medians of the ratios round by round.

    Args:
        names: of the methods; errors: (methods, tolerances); speeds: (methods, tolerances,
            rounds), strides per second of CPU time.
    """
    own, found = names.index(OWN), {}
    for i, name in enumerate(names):
        if name.startswith("ours"):
            continue
        found[name] = [
            float(np.median([
                speed_at(error, errors[own], speeds[own, :, turn])
                / speed_at(error, errors[i], speeds[i, :, turn])
                for turn in range(speeds.shape[2])
            ]))
            for error in np.maximum(errors[i], errors[own])
        ]  # fmt: skip
    return found


def _rungs(
    present: list[Method], rtols: tuple[float, ...], errors: Array, timings: list[Timing]
) -> list[Rung]:
    """Medians, and ratios to the first method taken round by round."""
    rungs, count = [], len(rtols)
    for i, timing in enumerate(timings):
        method, rtol, error = present[i // count], rtols[i % count], float(errors.flat[i])
        clock = "wall" if method.every_core else "cpu"
        base = np.array([1.0 / getattr(rung, clock) for rung in timings[:count]])
        ratios = [
            1.0 / (own * speed_at(error, errors[0], speeds))
            for own, speeds in zip(getattr(timing, clock), base.T, strict=True)
        ]
        rate = timing.rate if method.every_core else timing.rate_per_core
        used = "all" if method.every_core else "1"
        ratio = float(np.median(ratios))
        rungs.append(Rung(method.name, used, rtol, error, rate, ratio, timing.cores))
    return rungs


def _text(
    problem: Problem,
    rungs: list[Rung],
    missing: Mapping[str, str],
    agreement: Mapping[str, float],
    worst: Mapping[float, float],
) -> str:
    lines = [("method", "cores", "rtol", "error", "strides/s", "to scipy at equal error")]
    for rung in rungs:
        found = f"{rung.error:.1e}" if rung.error < LOST else "loses its way"
        ratio = "" if rung.ratio != rung.ratio else f"{rung.ratio:,.3g}"
        speed = f"{rung.strides_per_second:,.0f}"
        lines.append((rung.method, rung.cores, f"{rung.rtol:.0e}", found, speed, ratio))
    distances = ", ".join(f"{name} {value:.0e}" for name, value in agreement.items())
    many = ", ".join(f"{error:.0e} at {rtol:.0e}" for rtol, error in worst.items())
    given = min(rung.given for rung in rungs if rung.cores == "all")
    return "\n".join(
        [
            f"Work and precision: one stride of {problem.name}",
            "",
            *aligned(lines),
            *(f"{name}: {remedy}" for name, remedy in missing.items()),
            "",
            f"error: largest component of the post-strike state (rad, rad/s) over {STARTS} starts",
            "near the gait, against this package at rtol 1e-13, from which the others at 1e-13",
            f"differ by: {distances};",
            '"loses its way": steps so long that they jump over an event',
            f"ours over {MANY} starts: {many};",
            "strides/s: of CPU time on one core, of wall time on all (of which the machine gave "
            f"{given:.2f}",
            "or more); medians of rounds in turn",
        ]
    )


def _leads_text(rtols: Sequence[float], ahead: Mapping[str, Sequence[float]]) -> str:
    lines = [("rtol", *(f"{rtol:.0e}" for rtol in rtols))]
    for name, ratios in ahead.items():
        lines.append((name, *("" if ratio != ratio else f"{ratio:,.3g}" for ratio in ratios)))
    head = "Times as fast as the others: ours, a batch on one core, at the larger of both errors"
    return "\n".join([head, "", *aligned(lines)])


def _drawing(problem: Problem, rungs: list[Rung]) -> Drawing:
    """Strides per second against error, a line for each method."""
    from powered_walker_env.pictures.charts import sheet as paper

    @paper.styled
    def draw() -> Drawing:
        figure, (axes,) = paper.sheet()
        colours = (
            paper.GREY, paper.INK, paper.ORANGE, paper.GREEN, paper.VIOLET, paper.BLUE, paper.RED,
        )  # fmt: skip
        for name, colour in zip(dict.fromkeys(r.method for r in rungs), colours, strict=False):
            good = [r for r in rungs if r.method == name and 0 < r.error < LOST]
            errors, speeds = [r.error for r in good], [r.strides_per_second for r in good]
            axes.loglog(errors, speeds, color=colour, marker="o", label=name)
        axes.invert_xaxis()
        axes.set(
            xlabel="largest error of the post-strike state (rad, rad/s)",
            ylabel="strides per second",
            title=f"One stride of {problem.name}: work and precision",
        )
        axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
        columns = {field: [getattr(rung, field) for rung in rungs] for field in asdict(rungs[0])}
        return paper.Drawing(figure, columns)

    return draw()
