"""Derivatives of a stride, carried along with it.

The variational equations S' = (∂f/∂y) S + ∂f/∂p are stepped through the stages of every
accepted step, so that S is the derivative of the very walk that is taken. At an event
the saltation matrix corrects for the event's time moving: with the guard g and the flow
f⁻ before and f⁺ after, dt = −(∇g·S + ∂g/∂p)/ġ and S⁺ = S + (f⁻ − f⁺) dt (Leine and
Nijmeijer, Dynamics and Bifurcations of Non-Smooth Mechanical Systems, 2004, chapter 7);
a reset R gives ∂R/∂y (S + f⁻ dt) + ∂R/∂p.

States are loaded `unseen`: asking for derivatives must not change a bit of the stride.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from powered_walker_env.compiled.decorators import internal
from powered_walker_env.compiled.lanes import Table, bits, load, rows_from, unseen, where
from powered_walker_env.model.mechanics.actuation import flow
from powered_walker_env.model.mechanics.constants import lanes_of
from powered_walker_env.model.mechanics.ground import clearance
from powered_walker_env.model.mechanics.heel_strike import momentum_matrix, new_contact, swapped
from powered_walker_env.model.mechanics.stop import stance_matrix
from powered_walker_env.model.mechanics.swing import direction, mass_matrix, vectors
from powered_walker_env.model.mechanics.tangents import (
    flow_tangent,
    holding_torque_rate,
    holding_torque_tangent,
    mass_matrix_tangent,
    momenta_before_tangent,
    push_moments_tangent,
    stance_momenta_tangent,
    swing_foot_tangent,
    unpack_direction,
    vectors_tangent,
)
from powered_walker_env.model.phases import Guard, Reset
from powered_walker_env.simulation.lockstep import FALL, blend
from powered_walker_env.simulation.runge_kutta import (
    ADVANCES,
    DIMENSION,
    STAGE_ROWS,
    STAGES,
    acting,
    load_state,
    plus,
    store_state,
    weighted,
)

OUTPUTS = 6  # what a stride is differentiated of: α, s, α', β' after it, duration, step length
SWITCH_ANGLE, LANDING = int(Guard.SWITCH_ANGLE), int(Guard.LANDING)
STOP, HEEL_STRIKE = int(Guard.STOP), int(Reset.HEEL_STRIKE)
_FIRST, _STAGE, _WEIGHT = ADVANCES
_SWITCH, _STRENGTH, _PARAMS = 4, 5, 6  # columns of a direction: state, control, packed walker


class Directions(NamedTuple):
    """What to differentiate by, and the derivatives of eight strides under way.

    Tables of lanes, with so many rows for each of n directions one after another.
    """

    n: int
    changes: Table  # (n, 6 + PACKED) of post-strike state, control and packed walker
    S: Table  # 6, derivative of (φ, α, β and rates), now
    slopes: Table  # 78, of S at the stages
    shift: Table  # 1, s, how far the last event moves
    out: Table  # OUTPUTS, the result
    derivatives: Table  # (N·n, OUTPUTS) where the results go


DIRECTION_ROWS = DIMENSION + STAGE_ROWS + 1 + OUTPUTS


@internal
def directions_of(rows, changes, n, derivatives):
    """Room for n directions in the first n·DIRECTION_ROWS of a table of lanes."""
    slopes = n * DIMENSION
    shift = slopes + n * STAGE_ROWS
    return Directions(
        n,
        changes,
        rows,
        rows_from(rows, slopes),
        rows_from(rows, shift),
        rows_from(rows, shift + n),
        derivatives,
    )


@internal
def write_derivatives(d, index, lane, walked):
    """The derivatives of the stride that one lane has ended; NaN after a fall."""
    for k in range(d.n):
        for j in range(OUTPUTS):
            value = d.out[k * OUTPUTS + j, lane] if walked else math.nan
            d.derivatives[index * d.n + k, j] = value


@internal
def _state(rows):
    """A state of the stride, for the derivatives' own use."""
    return load_state(rows, unseen(0))


@internal
def _walkers(w):
    """The walkers' constants, for the derivatives' own use."""
    return lanes_of(rows_from(w.constants, unseen(0)))


@internal
def begin(d, lane):
    """S at the start of a stride: both feet locked, φ = α − lock."""
    for k in range(d.n):
        S, change = DIMENSION * k, d.changes
        d.S[S, lane] = change[k, 0] - change[k, _PARAMS + 3]
        d.S[S + 1, lane], d.S[S + 2, lane] = change[k, 0], change[k, 1]
        d.S[S + 3, lane], d.S[S + 4, lane] = change[k, 2], change[k, 2]
        d.S[S + 5, lane] = change[k, 3]
        d.shift[k, lane] = 0.0


@internal
def _walker(d, k, s, unfold, c):
    """The direction's change of the walkers."""
    change = (
        d.changes[k, 6], d.changes[k, 7], d.changes[k, 8], d.changes[k, 9], d.changes[k, 10],
        d.changes[k, 11], d.changes[k, 12], d.changes[k, 13], d.changes[k, 14], d.changes[k, 15],
        d.changes[k, 16], d.changes[k, 17], d.changes[k, 18],
    )  # fmt: skip
    return unpack_direction(load(s.gravity, 0), unfold, change, c)


@internal
def _blend_state(array, row, mask, y):
    for i in range(DIMENSION):
        blend(array, row + i, mask, y[i])


@internal
def propagate(d, s, w, mask):
    """Carry S over the steps just taken, where the mask holds, and on to the events."""
    c, drive, locked = (
        _walkers(w),
        acting(w),
        load(w.locked, 0) > 0.0,
    )
    h, correction, fresh = load(w.length, 0), load(s.correction, 0), load(s.fresh, 0) > 0.0
    unfold = direction(-c.lock)
    for stage in range(STAGES + 1):
        y = load_state(w.stages, unseen(DIMENSION * stage))
        slope = load_state(w.slopes, DIMENSION * stage)
        at = vectors(y[0], y[1], y[2], c)
        matrix = mass_matrix(at[0], at[1], at[2], at[3], c)
        for k in range(d.n):
            slopes = rows_from(d.slopes, STAGE_ROWS * k)
            t = load_state(d.S, DIMENSION * k)
            if stage > 0:
                t = plus(t, h, weighted(_FIRST, _STAGE, _WEIGHT, stage - 1, slopes))
            dc = _walker(d, k, s, unfold, c)
            change = d.changes[k, _STRENGTH]
            out = flow_tangent(locked, y, slope, at, matrix, t, drive, change, c, dc)
            if stage == 0:
                _blend_state(slopes, 0, mask & fresh, out)
            else:
                store_state(slopes, DIMENSION * stage, out)
            if stage == STAGES:
                _blend_state(d.S, DIMENSION * k, mask, plus(t, correction, out))
                _blend_state(slopes, 0, mask, out)


@internal
def _guard_tangent(guard, y, before, S, drive, switch_change, strength_change, c, dc):
    """∇g·S + ∂g/∂p of one guard."""
    if guard == SWITCH_ANGLE:
        return S[2] - S[1] - switch_change
    if guard == LANDING:
        return swing_foot_tangent(y, S, c, dc).real
    if guard == STOP:
        return dc.lock - (S[1] - S[0])
    return holding_torque_tangent(y, before, S, drive, strength_change, c, dc)


@internal
def _guard_rate(guard, y, before, drive, c):
    """ġ in the phase that ends."""
    if guard == SWITCH_ANGLE:
        return y[5] - y[4]
    if guard == LANDING:
        return clearance(y, c)[1]
    if guard == STOP:
        return y[3] - y[4]
    return holding_torque_rate(y, before, drive, c)


@internal
def leave_phases(d, s, w, mask):
    """Move S to the events, which move too: S + f⁻ dt with dt = −(∇g·S + ∂g/∂p)/ġ.

    An event that is there as its phase begins moves with the event before it, and at the
    start of a stride not at all.
    """
    c, y, drive = _walkers(w), _state(w.y), acting(w)
    before = flow(load(w.locked, 0) > 0.0, y, drive, c)
    target = where(mask & (load(s.elapsed, 0) > 0.0), load(s.target, 0), 0.0)
    unfold = direction(-c.lock)
    for k in range(d.n):
        S = load_state(d.S, DIMENSION * k)
        dc = _walker(d, k, s, unfold, c)
        switch, strength = d.changes[k, _SWITCH], d.changes[k, _STRENGTH]
        dt = where(load(s.elapsed, 0) > 0.0, 0.0, load(d.shift, k))
        for guard in range(1, FALL):
            if bits(target == guard):
                change = _guard_tangent(guard, y, before, S, drive, switch, strength, c, dc)
                moved = -change / _guard_rate(guard, y, before, drive, c)
                dt = where(target == guard, moved, dt)
        blend(d.shift, k, mask, dt)
        _blend_state(d.S, DIMENSION * k, mask, plus(S, dt, before))


@internal
def stop_phases(d, s, w, mask):
    """S through the impact at the ankle's stop, y being just before it."""
    c, y, struck = (
        _walkers(w),
        _state(w.y),
        _state(s.struck),
    )
    at = vectors(y[0], y[1], y[2], c)
    matrix = mass_matrix(at[0], at[1], at[2], at[3], c)
    a11, a12, a21, a22 = stance_matrix(y[0], y[1], y[2], c)
    determinant = a11 * a22 - a12 * a21
    unfold = direction(-c.lock)
    for k in range(d.n):
        S = load_state(d.S, DIMENSION * k)
        dc = _walker(d, k, s, unfold, c)
        moved = vectors_tangent(y, S, at[0], at[1], at[2], at[3], dc)
        stance, swing = stance_momenta_tangent(y, S, at, moved, matrix, c, dc)
        d11, d12, d21, d22 = _momentum_matrix_tangent((y[0], y[1], y[2]), S, c, dc)
        f1 = stance - (d11 - c.reaction * d21) * struck[4] - (d12 - c.reaction * d22) * struck[5]
        f2 = swing - d21 * struck[4] - d22 * struck[5]
        dalpha = (f1 * a22 - a12 * f2) / determinant
        dbeta = (a11 * f2 - a21 * f1) / determinant
        _blend_state(d.S, DIMENSION * k, mask, (S[0], S[1], S[2], dalpha, dalpha, dbeta))


@internal
def enter_phases(d, s, w, mask):
    """The other half of the saltation, S − f⁺ dt, where a phase follows in the same stride."""
    after = flow(
        load(w.locked, 0) > 0.0,
        _state(w.y),
        acting(w),
        _walkers(w),
    )
    for k in range(d.n):
        S = load_state(d.S, DIMENSION * k)
        _blend_state(d.S, DIMENSION * k, mask, plus(S, -load(d.shift, k), after))


@internal
def _momentum_matrix_tangent(y, t, c, dc):
    """Changes of `momentum_matrix`."""
    at = vectors(y[0], y[1], y[2], c)
    moved = vectors_tangent(y, t, at[0], at[1], at[2], at[3], dc)
    d11, d12, d13, d22, d23, d33 = mass_matrix_tangent(at, moved, c, dc)
    coupling = d13 + d23
    walker = c.reaction * coupling
    return d11 + 2.0 * d12 + d22 + walker, walker + c.reaction * d33, coupling, d33


@internal
def _either(condition, yes, no):
    return (
        where(condition, yes[0], no[0]),
        where(condition, yes[1], no[1]),
        where(condition, yes[2], no[2]),
    )


@internal
def strike(d, s, w, mask):
    """The result: derivatives of the post-strike state, the duration and the step length."""
    c, y, struck = (
        _walkers(w),
        _state(w.y),
        _state(s.struck),
    )
    at = vectors(y[0], y[1], y[2], c)
    contact = new_contact(y[0], y[1], y[2], c)
    place = _either(c.as_published, (y[0], y[1], y[2]), swapped(y[2], y[1], c))
    a11, a12, a21, a22 = momentum_matrix(place[0], place[1], place[2], c)
    determinant = a11 * a22 - a12 * a21
    unfold = direction(-c.lock)
    rolled = y[0] - load(s.first_phi, 0)
    pushing = load(s.reset, 0) > HEEL_STRIKE
    for k in range(d.n):
        S = load_state(d.S, DIMENSION * k)
        dc = _walker(d, k, s, unfold, c)
        moved = vectors_tangent(y, S, at[0], at[1], at[2], at[3], dc)
        walker, trailing = momenta_before_tangent(y, S, at, moved, contact, c, dc)
        turn = _either(c.as_published, (S[0], S[1], S[2]), (S[2] - dc.lock, S[2], S[1]))
        d11, d12, d21, d22 = _momentum_matrix_tangent(place, turn, c, dc)
        push, dpush = load(s.impulse, 0), where(pushing, d.changes[k, _STRENGTH], 0.0)
        about_contact, about_hip = push_moments_tangent(
            y, S, at, moved, contact, push, dpush, c, dc
        )
        f1 = walker + about_contact - d11 * struck[4] - d12 * struck[5]
        f2 = trailing + about_hip - d21 * struck[4] - d22 * struck[5]
        started = d.changes[k, 0] - d.changes[k, _PARAMS + 3]
        foot = swing_foot_tangent(y, S, c, dc).imag
        out = rows_from(d.out, OUTPUTS * k)
        blend(out, 0, mask, S[2])
        blend(out, 1, mask, S[1])
        blend(out, 2, mask, (f1 * a22 - a12 * f2) / determinant)
        blend(out, 3, mask, (a11 * f2 - a21 * f1) / determinant)
        blend(out, 4, mask, load(d.shift, k))
        blend(out, 5, mask, foot + dc.R * rolled + c.R * (S[0] - started))
