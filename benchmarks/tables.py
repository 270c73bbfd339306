"""The benchmarks in words: one table for each section."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from benchmarks.environments import VECTOR, Environments
from benchmarks.precision import LOST, Precision
from benchmarks.problem import MANY, STARTS
from benchmarks.roofline import Roofline
from benchmarks.scaling import LARGE, PAST_START, Scaling
from benchmarks.startup import Startup


def machine_text(machine: dict[str, Any]) -> str:
    """What it ran on."""
    found = ", ".join(f"{name} {version}" for name, version in machine["versions"].items())
    load = "" if machine["load"] is None else f", load {machine['load']:.1f} at the start"
    return f"{machine['processor']}, {_cores(machine['cores'])}{load}\n{found}"


def precision_text(found: Precision) -> str:
    """Method, tolerance, error, speed, ratio."""
    rows = [("method", "cores", "rtol", "error", "strides/s", "to scipy at equal error")]
    for rung in found.rungs:
        fails = not rung.error < LOST
        rows.append(
            (
                rung.method,
                rung.cores,
                f"{rung.rtol:.0e}",
                "loses its way" if fails else f"{rung.error:.1e}",
                f"{rung.strides_per_second:,.0f}",
                "" if rung.ratio != rung.ratio else f"{rung.ratio:,.3g}",
            )
        )
    some_fail = any(not rung.error < LOST for rung in found.rungs)
    lines = [f"Work and precision: one stride of {found.walker}", "", *_table(rows)]
    lines += [f"{name:24s}  {remedy}" for name, remedy in found.missing.items()]
    distances = ", ".join(f"{name} {value:.0e}" for name, value in found.agreement.items())
    worst = ", ".join(f"{error:.0e} at {rtol:.0e}" for rtol, error in found.worst_of_many.items())
    lines += [
        "",
        f"error: largest component of the post-strike state (rad, rad/s) over {STARTS} starts near",
        "the gait, against this package at rtol 1e-13; from which the others at 1e-13 differ by:",
        f"{distances}",
        f"ours over {MANY} starts: {worst}",
        "strides/s: of CPU time on one core, of wall time on all (of which the machine gave "
        f"{min(r.given for r in found.rungs if r.cores == 'all'):.2f} or more);",
        "medians of rounds in turn",
    ]
    if some_fail:
        lines.append("loses its way: steps so long that they jump over an event")
    return "\n".join(lines)


def roofline_text(found: Roofline) -> str:
    """Counts, peaks and the bound."""
    locked, free = found.step_flops
    peak = max(found.product_gflops, found.loop_gflops)
    return "\n".join(
        [
            f"Roofline: one core, DOP853 to an error of {found.error:.0e}",
            "",
            f"one evaluation            {found.locked_flops} flops with the foot locked, "
            f"{found.free_flops} with the motor on (sines included)",
            f"one step beside them      {locked} and {free} flops",
            f"one stride                {found.steps:.1f} steps, {found.evaluations:.0f} "
            f"evaluations, {found.flops / 1e3:.1f} kflop",
            f"peak, matrix product      {found.product_gflops:.1f} GFLOP/s",
            f"peak, multiply-add loop   {found.loop_gflops:.1f} GFLOP/s",
            f"bound                     {found.bound:,.0f} strides/s at {peak:.1f} GFLOP/s",
            f"ours, a batch             {found.strides_per_second:,.0f} strides/s: "
            f"{100 * found.share:.1f} % of the bound, "
            f"{found.strides_per_second * found.flops / 1e9:.1f} GFLOP/s",
        ]
    )


def scaling_text(found: Scaling) -> str:
    """By walkers and by cores."""
    rows = [("walkers in a batch", "strides/s on one core", "on all cores")]
    for size, one, every in zip(found.sizes, found.one_core, found.all_cores, strict=True):
        rows.append((f"{size:,}", f"{one:,.0f}", f"{every:,.0f}"))
    by_cores = [("cores", "strides/s", "of proportion", "cores the machine gave", "by CPU time")]
    rows_by_cores = zip(
        found.cores, found.by_cores, found.efficiency, found.given, found.undisturbed, strict=True
    )
    for count, rate, share, given, undisturbed in rows_by_cores:
        by_cores.append(
            (
                str(count),
                f"{rate:,.0f}",
                f"{100 * share:.0f} %",
                f"{given:.2f}",
                f"{100 * undisturbed:.0f} %",
            )
        )
    lines = [
        f"Scaling: rtol {found.rtol:.0e}; one core by CPU time, all cores by wall time",
        "",
        *_table(rows),
        "",
    ]
    if found.start_up == found.start_up:
        lines += [
            f"time on one core = {max(1e6 * found.start_up, 0):.0f} µs + walkers/rate, within "
            f"{100 * found.departure:.1f} % from {PAST_START} walkers up",
            "",
        ]
    return "\n".join(
        [
            *lines,
            *_table(by_cores),
            f"({LARGE:,} walkers for each core; of proportion: to one core's rate, times cores)",
        ]
    )


def environments_text(found: Environments) -> str:
    """What an environment adds."""
    rows = [
        ("one call of stride", f"{found.stride_us:,.1f} µs"),
        ("env.step", f"{found.step_us:,.1f} µs"),
        ("env.unwrapped.step", f"{found.bare_step_us:,.1f} µs"),
        (f"{VECTOR} walkers: stride_batch", f"{found.batch_us:,.0f} µs"),
        (
            f"{VECTOR} walkers: vector step",
            f"{found.vector_us:,.0f} µs, {100 * found.vector_overhead:+.1f} %",
        ),
    ]
    if found.sb3_us is not None:
        rows.append((f"{VECTOR} walkers: step for SB3", f"{found.sb3_us:,.0f} µs"))
    rows += [
        (f"{found.crowd:,} walkers: vector step", f"{found.crowd_ms:,.0f} ms"),
        (f"{found.crowd:,} walkers: first reset", f"{found.crowd_reset_s:.1f} s"),
        (
            f"{found.crowd:,} walkers: memory",
            f"{found.crowd_bytes:.0f} bytes each, {found.crowd_peak_bytes:.0f} while they step",
        ),
        *(
            (f"for orientation: {name}", f"{us:,.1f} µs a step")
            for name, us in found.others_us.items()
        ),
        *((name, remedy) for name, remedy in found.missing.items()),
    ]
    width = max(len(name) for name, _ in rows)
    lines = [f"{name:{width}s}  {value}" for name, value in rows]
    return "\n".join([f"Environments: {found.env_id}, wall time, medians", "", *lines])


def startup_text(found: Startup) -> str:
    """Milliseconds on the way to a first stride."""
    lines = ["Cold start: new processes, kernels found on disk, medians", ""]
    for marks in (found.environment, found.stride):
        lines += [f"{name:44s}  {1e3 * seconds:9.1f} ms" for name, seconds in marks.items()]
        lines += [f"{'in all':44s}  {1e3 * sum(marks.values()):9.1f} ms", ""]
    lines.append(f"the very first process, which compiles if need be: {found.first_process:.1f} s")
    return "\n".join(lines)


def _cores(count: int) -> str:
    return "1 core" if count == 1 else f"{count} cores"


def _table(rows: Sequence[Sequence[str]]) -> list[str]:
    """Columns of equal width, the first to the left, a line under the heads."""
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
    lines = [
        "  ".join(
            [
                row[0].ljust(widths[0]),
                *(c.rjust(w) for c, w in zip(row[1:], widths[1:], strict=True)),
            ]
        )
        for row in rows
    ]
    return [lines[0].rstrip(), "-" * len(lines[0]), *(line.rstrip() for line in lines[1:])]
