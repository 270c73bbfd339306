"""The stride by heyoka: Taylor series of automatically chosen order, compiled (import on demand).

Biscani and Izzo, Revisiting high-order Taylor methods for astrodynamics and celestial
mechanics, MNRAS 504 (2021). Two integrators, one for each phase, each ended by a terminal
event; they are compiled when they are made. Needs heyoka.
"""

from __future__ import annotations

import math
from typing import Any

import heyoka as hy
import numpy as np

from benchmarks.equations import (
    Array,
    clearance,
    equations,
    free_accelerations,
    locked_accelerations,
)
from benchmarks.problem import Problem

LONGEST = 10.0  # s: no stride of the presets lasts longer
FIRST_EVENT = -1  # heyoka's outcome for its first terminal event
TIGHTEST = 2.3e-16  # heyoka's own default: rounding


def taylor_strides(problem: Problem, rtol: float) -> Any:
    """A function from (n, 4) post-strike states to the next ones; NaN where one fails."""
    c = problem.constants
    strike = equations(c, jitted=True).strike
    swing, extension = _swing(c, rtol), _extension(c, rtol)

    def advance(states: Array) -> Array:
        ends = np.full_like(states, np.nan)
        for i, (alpha, s, d_alpha, d_beta) in enumerate(states.tolist()):
            if not _run(swing, (alpha, s + math.pi, d_alpha, d_beta)):
                continue
            a, b, da, db = swing.state.tolist()
            if _run(extension, (a - c.lock, a, b, da, da, db)):
                ends[i] = strike(extension.state)
        return ends

    return advance


def _run(integrator: Any, start: tuple[float, ...]) -> bool:
    """Integrate to the terminal event; whether it came."""
    integrator.time = 0.0
    integrator.state[:] = start
    integrator.reset_cooldowns()  # the event of the last run is not to be remembered
    outcome = integrator.propagate_until(LONGEST)[0]
    return int(outcome) == FIRST_EVENT


def _turns(*angles: Any) -> tuple[Any, ...]:
    return tuple(function(angle) for angle in angles for function in (hy.cos, hy.sin))


def _integrator(system: Any, ending: Any, rtol: float) -> Any:
    event = hy.t_event(ending, direction=hy.event_direction.negative)
    return hy.taylor_adaptive(
        system, [0.0] * len(system), t_events=[event], tol=max(rtol, TIGHTEST)
    )


def _swing(c: Any, rtol: float) -> Any:
    alpha, beta, da, db = hy.make_vars("alpha", "beta", "da", "db")
    turns = _turns(alpha - c.lock, alpha, beta)
    dda, ddb = locked_accelerations(c, turns, (da, da, db))
    system = [(alpha, da), (beta, db), (da, dda), (db, ddb)]
    return _integrator(system, beta - alpha - c.switch, rtol)


def _extension(c: Any, rtol: float) -> Any:
    phi, alpha, beta, df, da, db = hy.make_vars("phi", "alpha", "beta", "df", "da", "db")
    turns = _turns(phi, alpha, beta)
    ddf, dda, ddb = free_accelerations(c, turns, (df, da, db))
    system = [(phi, df), (alpha, da), (beta, db), (df, ddf), (da, dda), (db, ddb)]
    return _integrator(system, clearance(c, turns, hy.cos(beta - c.lock)), rtol)
