"""Strides by heyoka's Taylor series, which is needed: one at a time, or in its own lanes.

One compiled integrator for each phase, ended by a terminal event (Biscani and Izzo, Revisiting
high-order Taylor methods for astrodynamics and celestial mechanics, MNRAS 504, 2021). In batch
mode a terminal event calls Python, which notes the lane's state, gives it the next stride and
goes on, so that no lane waits for another: half a microsecond an event, two events a stride.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import heyoka as hy
import numpy as np

from benchmarks.equations import (
    Array,
    Constants,
    clearance,
    equations,
    free_accelerations,
    locked_accelerations,
)

LONGEST = 10.0  # s: no stride of the presets lasts longer
FIRST_EVENT = -1  # the outcome of the first terminal event
# Tuned on Zen 5, errors being the same: `fast_math` makes the scalar form a tenth faster and the
# batch a twentieth, `force_avx512` the batch another twentieth; twice the lanes are slower.
OPTIONS = {"compact_mode": False, "high_accuracy": False, "fast_math": True, "force_avx512": True}


class System(NamedTuple):
    """A phase as heyoka takes it."""

    equations: list[tuple[Any, Any]]
    ending: Any  # falls through zero as the phase ends


def systems(c: Constants) -> tuple[System, System]:
    """The swing with the foot locked, (α, β, α', β'), and the motor's, (φ, α, β, φ', α', β')."""
    phi, alpha, beta, df, da, db = hy.make_vars("phi", "alpha", "beta", "df", "da", "db")
    turn = math.cos(c.lock), math.sin(c.lock)  # sums of angles: a tenth faster than more sines
    cf, sf, ca, sa, cb, sb = (f(angle) for angle in (phi, alpha, beta) for f in (hy.cos, hy.sin))
    foot = ca * turn[0] + sa * turn[1], sa * turn[0] - ca * turn[1]
    dda, ddb = locked_accelerations(c, (*foot, ca, sa, cb, sb), (da, da, db))
    swing = System([(alpha, da), (beta, db), (da, dda), (db, ddb)], beta - alpha - c.switch)
    free = cf, sf, ca, sa, cb, sb
    ddf, dda, ddb = free_accelerations(c, free, (df, da, db))
    extension = System(
        [(phi, df), (alpha, da), (beta, db), (df, ddf), (da, dda), (db, ddb)],
        clearance(c, free, cb * turn[0] + sb * turn[1]),
    )
    return swing, extension


def _tolerance(rtol: float) -> float:
    return max(rtol, float(np.finfo(float).eps))


def _freed(y: Any, c: Constants) -> Any:
    """(6, ...) the state as the motor starts, from (4, ...) of the swing."""
    return np.array([y[0] - c.lock, y[0], y[1], y[2], y[2], y[3]])


def scalar_strides(c: Constants, rtol: float) -> Callable[[Array], Array]:
    """Strides one at a time: (n, 4) post-strike states to the next ones, NaN for a fall."""
    swing, extension = (
        hy.taylor_adaptive(
            system.equations,
            [0.0] * len(system.equations),
            t_events=[hy.t_event(system.ending, direction=hy.event_direction.negative)],
            tol=_tolerance(rtol),
            **OPTIONS,
        )
        for system in systems(c)
    )
    strike = equations(c, jitted=True).strike

    def ended(phase: Any, start: tuple[float, ...]) -> bool:
        phase.time, phase.state[:] = 0.0, start
        phase.reset_cooldowns()  # the event of the last run is not to be remembered
        return int(phase.propagate_until(LONGEST)[0]) == FIRST_EVENT

    def advance(states: Array) -> Array:
        ends = np.full_like(states, np.nan)
        for i, (stance, s, d_stance, d_swing) in enumerate(states.tolist()):
            if ended(swing, (stance, s + math.pi, d_stance, d_swing)):
                a, b, rate, swing_rate = swing.state.tolist()
                if ended(extension, (a - c.lock, a, b, rate, rate, swing_rate)):
                    ends[i] = strike(extension.state)
        return ends

    return advance


class _Lanes:
    """An integrator in batch mode, whose lanes each take the next start as they end one."""

    def __init__(self, system: System, rtol: float, width: int) -> None:
        event = hy.t_event_batch(
            system.ending, direction=hy.event_direction.negative, callback=self._ended
        )
        self._integrator = hy.taylor_adaptive_batch(
            system.equations,
            np.zeros((len(system.equations), width)),
            t_events=[event],
            tol=_tolerance(rtol),
            **OPTIONS,
        )
        self._columns, self._times = list(self._integrator.state.T), self._integrator.time

    def __deepcopy__(self, _: Any) -> _Lanes:
        return self  # heyoka copies its callbacks: they are to find this queue

    def ends(self, starts: Array) -> Array:
        """(n, k) states at the event, from (n, k) starts; NaN where there was none in time."""
        self._starts, self._found = starts, np.full_like(starts, np.nan)
        self._left = self._waiting = len(starts)
        self._number, self._begun = [-1] * len(self._columns), [0.0] * len(self._columns)
        self._integrator.set_time(0.0)
        for lane in range(len(self._columns)):
            self._next(lane)
        self._integrator.reset_cooldowns()
        self._integrator.propagate_until(LONGEST * len(starts))
        return self._found

    def _next(self, lane: int) -> None:
        """Give a lane the next start, or, where none is left, the first one again to idle with."""
        number = len(self._starts) - self._waiting
        self._waiting -= 1 if self._waiting else 0
        idle = number == len(self._starts)
        self._number[lane], self._begun[lane] = -1 if idle else number, self._times[lane]
        self._columns[lane][:] = self._starts[0 if idle else number]

    def _ended(self, _integrator: Any, _sign: int, lane: int) -> bool:
        """A lane has come to the event: whether to go on."""
        number = self._number[lane]
        if number >= 0:
            if self._times[lane] - self._begun[lane] < LONGEST:
                self._found[number] = self._columns[lane]
            self._left -= 1
        self._next(lane)
        return self._left > 0


def batch_strides(c: Constants, rtol: float) -> Callable[[Array], Array]:
    """Strides in as many lanes as a register of this machine has, in heyoka's own batch mode."""
    swing, extension = (_Lanes(system, rtol, hy.recommended_simd_size()) for system in systems(c))
    strike = equations(c, jitted=True).strike

    def advance(states: Array) -> Array:
        ends = np.full_like(states, np.nan)
        switched = swing.ends(states + np.array([0.0, math.pi, 0.0, 0.0]))
        going = np.flatnonzero(np.isfinite(switched).all(axis=1))
        landed = extension.ends(np.ascontiguousarray(_freed(switched[going].T, c).T))
        ends[going] = [strike(row) for row in landed]
        return ends

    return advance
